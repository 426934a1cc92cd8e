#pragma once

#include <optional>
#include <vector>

#include "common/graph/whole_map.hpp"
#include "services/bus/bus.hpp"
#include "services/map_updater/pages.hpp"

namespace crsm {

/// Answers those who want to see all that was seen (WHOLE_MAP): where loops are closed, where it belongs by all that is
/// known, or a piece of it that hangs together. For them it is drawn then, some scans at a time between the scans.
class WholeView {
 public:
  WholeView(Bus& bus, const UpdateParameters& drawing) : bus_(bus), whole_(drawing), piece_(drawing) {}

  /// Is answered by one of the next calls of Show. A new question of a requester takes the place of its last one only
  /// where both come from one sender: nobody can push out the question of another.
  void Ask(const map_request_t& request, const Sender& sender);

  /// Draws some scans for those who have asked, and answers them when all is drawn. Without loops the mapper's own map
  /// is the whole one.
  void Show(const Mapper& mapper, const Answered& answered, AnswerOptions options);

  /// Whether somebody waits for an answer.
  bool is_asked() const { return !asked_.empty(); }

 private:
  void ShowPiece(std::int32_t piece, const Mapper& mapper, const Answered& answered, AnswerOptions options);
  void AnswerWhoAskedFor(std::int32_t piece, const MapUpdater& map, const Answered& answered,
                         const AnswerOptions& options);

  Bus& bus_;
  WholeMap whole_;
  WholeMap piece_;                ///< of those who want to see another piece than the largest
  std::optional<int> component_;  ///< that is drawn there
  BackgroundMapError map_error_;
  std::int64_t num_layouts_ = 0;  ///< of the mapper, as of what is drawn
  static constexpr std::size_t kMostWaiting = 64;
  struct Asked {
    map_request_t request;
    Sender sender;
  };
  std::vector<Asked> asked_;
};

}  // namespace crsm
