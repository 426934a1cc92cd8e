#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "common/graph/pieces.hpp"
#include "common/graph/placed_loop.hpp"
#include "common/map/map_delta.hpp"
#include "common/match/tracking_state.hpp"
#include "common/scan/scan_match.hpp"
#include "services/wire/wire.hpp"

namespace crsm {

/// Whether two requests ask for the same, whatever their numbers.
bool SameQuestion(const map_request_t& one, const map_request_t& other);

/// A copy of the map that another process owns, kept whole over a network that loses messages.
///
/// Deltas for everybody lead from one version to the next and are applied when all their parts are there. When one is
/// missing, and at the start, the replica asks the owner page by page (MAP_REQUEST) until it holds a whole version
/// again. Of which map the versions are says their epoch: when a delta has another, the owner is asked, and when it has
/// begun a new map, the replica does too. It touches neither network nor clock: messages go in, and NextRequest says
/// what to send.
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

  /// What the owner said of a scan.
  struct Answer {
    std::int64_t utime = 0;
    std::optional<ScanMatch> match;  ///< nothing: it is not in the map
  };

  /// Which map of the owner's.
  enum class View {
    kMatched,  ///< that scans are matched to: told of every change
    kWhole     ///< all that was seen, where it belongs by all that is known: as of the last time it was asked for
  };

  /// requester: a number of this replica's own, not 0.
  MapReplica(std::int64_t requester, Keeper keeper, View view = View::kMatched);

  /// Takes a delta for everybody, or a page that answers the question that NextRequest gave last. Pages that answer any
  /// other question are left out: somebody else may have asked it in this replica's name.
  void Handle(const map_delta_t& delta);

  /// Whether a whole version is held, so far as the replica knows.
  bool synced() const { return synced_; }
  /// Of the map that is held; 0 before the owner was heard.
  std::int64_t epoch() const { return epoch_; }
  std::int64_t version() const { return version_; }
  /// After the scans that the owner has answered; where matches are wanted, as the owner last said.
  const TrackingState& tracking() const { return tracking_; }
  /// Loops as the owner last said, where matches are wanted.
  const std::vector<PlacedLoop>& loops() const { return loops_; }
  /// How the map hangs together, likewise; nothing where loops are not looked for.
  const std::optional<MapPieces>& pieces() const { return pieces_; }

  /// From now on the whole map is that of another piece, by its number from 2 on: its own scans, its own versions.
  void TurnTo(int piece) {
    piece_ = piece;
    Doubt();
  }

  /// Pages that answer a question in this replica's name that it never asked: somebody forges MAP_REQUEST.
  std::int64_t num_forged() const { return num_forged_; }

  /// Doubts that the version held is the last: the owner is to be asked.
  void Doubt() { synced_ = false; }
  /// Doubts; and from now on wants answers of when loops have been looked for in all scans so far.
  void AwaitSettled() {
    settled_ = true;
    Doubt();
  }

  /// Asks the owner whether a scan is in the map already; once answered, AnswerAbout has it until something else is
  /// asked, or it is forgotten.
  void AskAbout(std::int64_t utime);
  const Answer* AnswerAbout(std::int64_t utime) const;
  /// What was answered is true no longer: the scan has just been matched.
  void ForgetAnswer() { answer_.reset(); }

  /// What to ask the owner; nothing when synced and not asking. A new question has a new number.
  std::optional<map_request_t> NextRequest();

 private:
  std::optional<map_request_t> Question() const;
  bool Answers(const map_request_t& request);
  void HandlePage(const map_delta_t& page);
  void HandleBroadcast(const map_delta_t& delta);
  void ApplyParts();
  bool TakeMatches(const map_delta_t& page);
  void Begin(std::int64_t epoch, double cell_size_m);
  bool wants_matches() const { return static_cast<bool>(keeper_.add); }

  std::int64_t requester_;
  Keeper keeper_;
  View view_;
  bool settled_ = false;
  std::int32_t piece_ = 0;  ///< 0: the map that is shown
  map_request_t asked_{};   ///< last; none while its requester is 0
  std::int64_t num_forged_ = 0;

  bool synced_ = false;
  bool whole_ = false;              ///< all of version_ is held, and nothing of a later one
  std::int64_t heard_version_ = 0;  ///< the newest that the owner has told everybody
  std::int64_t epoch_ = 0;
  std::int64_t version_ = 0;
  std::int64_t version_utime_ = 0;  ///< of the scan that made it
  double cell_size_m_ = 0.0;
  std::int64_t num_matches_ = 0;  ///< taken over, as such or within the tracking state
  TrackingState tracking_;
  std::vector<PlacedLoop> loops_;
  std::optional<MapPieces> pieces_;

  std::int32_t next_tile_ = 0;                 ///< of the pages under way
  std::optional<std::int64_t> pages_version_;  ///< the owner's when the first of them came
  std::map<std::int32_t, map_delta_t> parts_;  ///< of version + 1, by number; together no larger than a map

  std::int64_t asked_utime_ = -1;  ///< not answered yet
  std::optional<Answer> answer_;
};

}  // namespace crsm
