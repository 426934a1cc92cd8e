#pragma once

#include <vector>

#include "common/graph/whole_map.hpp"
#include "services/map_updater/answers.hpp"
#include "services/runtime/bus.hpp"

namespace crsm {

/// Answers those who want to see all that was seen (WHOLE_MAP): where loops are closed, where it belongs by all that is
/// known. For them it is drawn then, a piece at a time between the scans.
class WholeView {
 public:
  WholeView(Bus& bus, const UpdateParameters& drawing) : bus_(bus), whole_(drawing) {}

  /// Is answered by one of the next calls of Show. Of one requester only the newest question is.
  void Ask(const map_request_t& request);

  /// Draws a piece for those who have asked, and answers them when all is drawn. Without loops the mapper's own map is
  /// the whole one.
  void Show(const Mapper& mapper, const Answered& answered, AnswerOptions options);

  /// Whether somebody waits for an answer.
  bool is_asked() const { return !requests_.empty(); }

 private:
  Bus& bus_;
  WholeMap whole_;
  std::int64_t num_updates_ = 0;  ///< of the graph that are in the map
  std::vector<map_request_t> requests_;
};

}  // namespace crsm
