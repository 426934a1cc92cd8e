#pragma once

#include <string>
#include <vector>

#include "common/graph/pieces.hpp"

namespace crsm {

/// Says which trajectories of a map float, which are joined, and that another piece is the larger one, as it happens.
class JoinNews {
 public:
  /// What is new since the last call, a line each. The first time nothing is: it was so before; nor is where an older
  /// break is not told any more.
  std::vector<std::string> Look(const MapPieces& pieces);

 private:
  std::int64_t first_ = 0;    ///< trajectory that is known, ...
  std::vector<int> numbers_;  ///< ... and for each from there on the number of its piece
};

/// Whether the map that is shown is another piece than the one that the run began with, as far as that is known.
bool IsFirstElsewhere(const MapPieces& pieces);

/// "floating: not joined to the map yet (trajectory 3)".
std::string DescribeFloating(std::int64_t trajectory);

}  // namespace crsm
