#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/fleet/fleet.hpp"
#include "common/fleet/fleet_drawing.hpp"
#include "common/fleet/fleet_marks.hpp"
#include "common/graph/background_map_error.hpp"
#include "common/logs/unique_utimes.hpp"
#include "common/map/map_updater.hpp"
#include "services/bus/sender.hpp"
#include "services/replica/growing_message.hpp"
#include "services/wire/wire.hpp"

namespace crsm {

/// The common map for those who ask for it, page by page, as the owner of a robot's map answers (WHOLE_MAP): the
/// largest piece with the keyframes of all robots, or another piece alone. A keyframe is told as a match, whose fitness
/// is the share of its rays that fit the common map. The places of all robots come with the last of them.
///
/// It touches neither network nor clock.
class FleetView {
 public:
  static constexpr std::size_t kMostWaiting = 64;

  FleetView(const Fleet& fleet, const FleetClock& clock, const FleetMarks& marks, const DrawingRules& drawing)
      : fleet_(fleet), clock_(clock), marks_(marks), whole_(drawing), piece_(drawing) {}

  /// Is answered by one of the next calls of Answer. A new question of a requester takes the place of its last one.
  void Ask(const map_request_t& request, const Sender& sender);

  /// Draws some keyframes for those who have asked. Their answers, when all is drawn.
  std::vector<map_page_t> Answer(const AnswerOptions& options);

  bool is_asked() const { return !asked_.empty(); }
  /// The pieces, as of SortPieces, for the last answer.
  const std::vector<int>& pieces() const { return pieces_; }
  /// Looks which pieces there are now, and whether what is drawn is elsewhere by now.
  void Look();

 private:
  /// What is told of one piece; of all keyframes where it is the one that is shown.
  struct Told {
    FleetDrawing& drawing;
    std::optional<int> only;  ///< this piece alone
    std::int64_t version;
  };

  map_page_t MakePage(const map_request_t& request, const Told& told, const AnswerOptions& options);
  MapPieces FindLayout(bool settled);
  ScanMatch MakeMatch(std::size_t keyframe, FleetDrawing& drawing) const;
  std::vector<std::size_t> ListKeyframes(std::optional<int> only) const;

  const Fleet& fleet_;
  const FleetClock& clock_;
  const FleetMarks& marks_;
  FleetDrawing whole_;
  FleetDrawing piece_;
  std::optional<int> drawn_piece_;  ///< in piece_
  std::vector<int> pieces_;
  std::int64_t num_layouts_ = -1;  ///< of the graph, as of what is drawn
  std::int64_t layout_ = 0;        ///< counts what is told as a map of its own
  BackgroundMapError map_error_;
  UniqueUtimes unique_;               ///< robots' clocks may tell the same times
  std::vector<std::int64_t> utimes_;  ///< by which keyframes are told, in the order of all
  struct Asked {
    map_request_t request;
    Sender sender;
  };
  std::vector<Asked> asked_;
};

}  // namespace crsm
