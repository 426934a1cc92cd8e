#pragma once

#include <optional>

#include "services/replica/delta_reader.hpp"
#include "services/replica/map_follower.hpp"
#include "services/replica/scan_question.hpp"

namespace crsm {

/// The map that scans are matched to, for a matcher on the bus: MAP_DELTA says what its matches have changed, MAP_PAGE
/// what it lacks, and SCAN_ANSWER whether a scan is in the map already.
class MatchedMap {
 public:
  MatchedMap(Service& service, MapFollower::Keeper keeper);

  const MapReplica& replica() const { return pages_.replica(); }
  void RequestUpdate() { pages_.RequestUpdate(); }

  /// A match has been sent: its delta leads on from it.
  void Await(const ScanMatch& match) {
    deltas_.Await(match);
    question_.NoteMatched(match.utime);
  }

  void AskAbout(std::int64_t utime) { question_.Ask(utime); }
  const ScanQuestion::Answer* AnswerAbout(std::int64_t utime) const { return question_.AnswerAbout(utime); }
  bool IsKnownToBeNew(std::int64_t utime) const {
    return question_epoch_ == replica().epoch() && question_.IsKnownToBeNew(utime);
  }

  /// Sends the requests that are due, if any; to be called often.
  void Poll();

 private:
  Service& service_;
  const std::int64_t requester_;
  MapFollower pages_;
  DeltaReader deltas_;
  ScanQuestion question_;
  std::int64_t question_epoch_ = 0;         ///< of the map that was asked about
  std::optional<std::int64_t> last_asked_;  ///< scan
  Backoff backoff_{std::chrono::milliseconds(50)};
  StallWatch stall_watch_;
};

}  // namespace crsm
