#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "common/scan/scan_counts.hpp"
#include "common/scan/scan_match.hpp"

namespace crsm {

/// Of all matches of a run as many as show its path in a picture: no more than a few thousand, however long it is.
class PathSketch {
 public:
  void Add(const ScanMatch& match);

  /// In order of arrival; the last ones are all there.
  std::vector<ScanMatch> Matches() const;

  std::int64_t num_matches() const { return counts_.scans(); }
  /// Of all matches.
  const ScanCounts& counts() const { return counts_; }

  struct Kept {
    std::int64_t number;  ///< of the match, from 0
    ScanMatch match;
  };
  /// The sketch without the last matches. It grows at its end, until it is thinned and is another one.
  const std::vector<Kept>& kept() const { return kept_; }
  int num_thinnings() const { return num_thinnings_; }

 private:
  bool TellsMore(const ScanMatch& match) const;
  void Thin();
  void Keep(const Kept& kept);

  std::vector<Kept> kept_;
  std::deque<Kept> recent_;
  std::map<int, Pose2> last_matched_;  ///< of kept_, by trajectory: several robots come in turn
  std::optional<Pose2> last_lost_;     ///< of kept_
  double spacing_m_ = 0.02;            ///< less than a pixel of most pictures
  ScanCounts counts_;
  int num_thinnings_ = 0;
};

}  // namespace crsm
