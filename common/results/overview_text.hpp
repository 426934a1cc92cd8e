#pragma once

#include <cstdint>

#include "common/results/overview_caption.hpp"
#include "common/results/results.hpp"

namespace crsm {

/// What there is of a path.
struct PathCounts {
  std::int64_t num_scans = 0;
  std::int64_t num_lost = 0;
  std::int64_t num_elsewhere = 0;  ///< on other pieces, lost ones too
  bool is_drawn = false;
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

/// Null where nothing has judged the run.
const Verdict* FindVerdict(const Results& results);

/// What the caption of a run's overview says. There is a verdict only where the summary has one.
OverviewCaption DescribeRun(const Results& results, const PathCounts& path);

}  // namespace crsm
