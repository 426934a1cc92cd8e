#pragma once

#include "common/results/overview_caption.hpp"
#include "common/results/results.hpp"
#include "common/scan/scan_counts.hpp"

namespace crsm {

/// What there is of a path.
struct PathCounts {
  ScanCounts scans = {};
  bool is_drawn = false;
  bool has_lost = false;       ///< whether lost scans are drawn
  bool has_last_scan = false;  ///< whether that is drawn
};

/// A kind of loops, and how it is shown.
struct LoopKind {
  const char* name;
  PairStyle style;
  LegendItem::Sign sign;
  bool (*holds)(const PlacedLoop&);
};

/// Of which each loop has one.
const std::vector<LoopKind>& LoopKinds();

/// How the drive is shown that would tell most.
inline const PairStyle kWayBackStyle{overview_colour::kDoubt, 1.0, 5.0, true};

/// Null where nothing has judged the run.
const Verdict* FindVerdict(const Results& results);

/// What the caption of a run's overview says. There is a verdict only where the summary has one.
OverviewCaption DescribeRun(const Results& results, const PathCounts& path);

}  // namespace crsm
