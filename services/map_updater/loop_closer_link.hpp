#pragma once

#include <functional>
#include <optional>

#include "common/graph/mapper.hpp"
#include "services/base/backoff.hpp"
#include "services/base/status.hpp"
#include "services/replica/request_limiter.hpp"
#include "services/wire/graph_messages.hpp"

namespace crsm {

/// What the map's owner and a loop closer tell each other: KEYFRAME there, POSE_GRAPH back. A keyframe is sent again
/// until it is answered; a loop closer that lacks older ones asks for them (KEYFRAME_REQUEST).
///
/// It touches neither network nor clock: messages and the time come in, and what is to be sent goes out by `send`.
class LoopCloserLink {
 public:
  using Clock = Backoff::Clock;

  /// The map's owner.
  struct Owner {
    std::function<void(const keyframe_t&)> send;
    std::function<void(const GraphUpdate&)> keep;   ///< gets each update that the mapper has taken
    std::function<void(KeyframeId)> keep_searched;  ///< gets keyframes of which, and before which, no more will come
    /// Tells the places of the map; those of that checksum are held already.
    std::function<void(std::int64_t marks_held)> tell_marks = [](std::int64_t) {};
    /// Whose questions come first.
    std::function<bool(const Sender&)> is_loop_closer = [](const Sender&) { return false; };
  };

  LoopCloserLink(Mapper& mapper, Counters& counters, Owner owner);

  /// Of the map; nothing is sent or heard before.
  void SetEpoch(std::int64_t epoch) { epoch_ = epoch; }

  /// Sends the newest keyframe, of which there must be one: it is new, or has not been answered for some time.
  void SendNewest(Clock::time_point now);
  void Poll(Clock::time_point now);

  /// A message of a loop closer's. Parts of an update may come in any order, and more than once.
  void Take(const pose_graph_t& message, Clock::time_point now);
  void Answer(const keyframe_request_t& request, const Sender& sender, Clock::time_point now);

  /// Whether all is known that has to take effect with the next keyframe.
  bool IsReadyForNext() const { return num_awaited() < mapper_.lag(); }
  /// Whether loops were looked for in all keyframes.
  bool IsSettled() const { return num_awaited() == 0; }
  /// Keyframes, the newest ones, of which it was not said yet that loops were looked for in them.
  int num_awaited() const {
    return looked_through_ ? mapper_.graph().CountAfter(*looked_through_) : mapper_.graph().size();
  }

 private:
  void Send(KeyframeId id);

  Mapper& mapper_;
  Counters& counters_;
  Owner owner_;
  std::int64_t epoch_ = 0;
  std::optional<KeyframeId> looked_through_;  ///< the newest keyframe in which loops were looked for
  GraphUpdateParts parts_;
  RequestLimiter request_limiter_;
  Backoff backoff_{std::chrono::milliseconds(50)};
};

}  // namespace crsm
