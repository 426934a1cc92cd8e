#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/graph/pieces.hpp"
#include "common/graph/placed_loop.hpp"
#include "common/map/map_delta.hpp"
#include "common/marks/mark.hpp"
#include "common/match/guess/tracking_state.hpp"
#include "common/scan/scan_match.hpp"
#include "services/wire/wire.hpp"

namespace crsm {

/// Whether two requests ask for the same, whatever their numbers.
bool SameQuestion(const map_request_t& one, const map_request_t& other);

/// A copy of the map that another process owns, kept whole over a network that loses messages: it asks the owner page
/// by page (MAP_REQUEST) until it holds a whole version. It touches neither network nor clock: pages go in, and
/// NextRequest says what to send.
///
/// Of the matches it holds none: who wants them all gets each once, in order, and must keep them; for the others there
/// is the tracking state that follows from them.
class MapReplica {
 public:
  /// Who keeps the map.
  struct Keeper {
    /// Begins a map with cells of that size; what was held goes.
    std::function<void(double cell_size_m)> begin;
    /// Takes over changed tiles.
    std::function<void(std::span<const TileChange>)> apply;
    /// Takes over the next match; empty where no matches are wanted.
    std::function<void(const ScanMatch&)> add = {};
  };

  /// Which map of the owner's.
  enum class View {
    kMatched,  ///< that scans are matched to
    kWhole     ///< all that was seen, where it belongs by all that is known: as of the last time it was asked for
  };

  /// requester: a number of this replica's own, not 0.
  MapReplica(std::int64_t requester, Keeper keeper, View view);

  /// Takes a page that answers the question that NextRequest gave last. Pages that answer any other question are left
  /// out: somebody else may have asked it in this replica's name.
  void Handle(const map_page_t& page);

  /// Whether a whole version is held, so far as the replica knows.
  bool synced() const { return synced_; }
  /// Of the map that is held; 0 before the owner was heard.
  std::int64_t epoch() const { return lacking_.epoch; }
  std::int64_t version() const { return lacking_.base_version; }
  double cell_size_m() const { return cell_size_m_; }
  /// After the scans that the owner has answered; where matches are wanted, as the owner last said.
  const TrackingState& tracking() const { return tracking_; }
  /// Loops as the owner last said, where matches are wanted.
  const std::vector<PlacedLoop>& loops() const { return loops_; }
  /// How the map hangs together, likewise; nothing where loops are not looked for.
  const std::optional<MapPieces>& pieces() const { return pieces_; }
  /// Places with names, likewise.
  const std::vector<PlacedMark>& marks() const { return marks_; }
  /// Pages that answer a question in this replica's name that it never asked: somebody forges MAP_REQUEST.
  std::int64_t num_forged() const { return num_forged_; }

  /// There may be a newer version: the owner is to be asked. What it has said before is no answer to that.
  void RequestUpdate() {
    if (!std::exchange(synced_, false)) return;
    ++lacking_.question;
    asked_ = lacking_;
  }
  /// Likewise; and from now on wants answers of when loops have been looked for in all scans so far.
  void AwaitSettled() {
    lacking_.settled = 1;
    RequestUpdate();
  }
  /// Does no longer: the owner is asked anew.
  void AwaitNoLonger() {
    lacking_.settled = 0;
    ++lacking_.question;
    asked_ = lacking_;
  }
  /// From now on the whole map is that of another piece, by its number from 2 on: its own scans, its own versions.
  void TurnTo(int piece) {
    lacking_.piece = piece;
    RequestUpdate();
  }

  /// What to ask the owner; nothing when synced. A new question has a new number.
  std::optional<map_request_t> NextRequest();

  // What DeltaReader needs, where no matches are wanted.

  /// Whether all of the version is held, and nothing of a later one: no pages are under way.
  bool whole() const { return whole_; }
  /// The owner has told everybody of a version.
  void Hear(std::int64_t version) { heard_version_ = std::max(heard_version_, version); }
  /// The tiles of the next version have been changed: by a scan that was matched so, and brought that about.
  void Advance(std::span<const TileChange> changes) { keeper_.apply(changes); }
  void EndVersion(const ScanMatch& match, const AfterMatch& after);
  /// What is held is not the owner's.
  void BeginAgain() { Begin(epoch(), cell_size_m_); }

 private:
  bool Answers(const map_request_t& request);
  bool TakeTracking(const map_page_t& page);
  bool TakeMatches(const map_page_t& page);
  void Begin(std::int64_t epoch, double cell_size_m);
  bool wants_matches() const { return static_cast<bool>(keeper_.add); }
  /// Taken over, as such or within the tracking state.
  std::int64_t num_matches() const { return wants_matches() ? lacking_.first_match : tracking_.num_scans(); }

  Keeper keeper_;
  map_request_t lacking_{};  ///< as it is to be asked for
  map_request_t asked_{};    ///< last; none while its requester is 0
  std::int64_t num_forged_ = 0;

  bool synced_ = false;
  bool whole_ = false;
  std::int64_t heard_version_ = 0;             ///< the newest that the owner has told everybody
  std::optional<std::int64_t> pages_version_;  ///< the owner's when the first of the pages under way came
  double cell_size_m_ = 0.0;
  TrackingState tracking_;
  std::vector<PlacedLoop> loops_;
  std::optional<MapPieces> pieces_;
  std::vector<PlacedMark> marks_;
};

}  // namespace crsm
