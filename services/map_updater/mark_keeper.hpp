#pragma once

#include <deque>
#include <functional>
#include <vector>

#include "common/marks/mark_book.hpp"
#include "services/bus/look_limiter.hpp"
#include "services/bus/service.hpp"
#include "services/journal/match_store.hpp"

namespace crsm {

/// Hears MARK, and keeps the places with names of the map: a mark is fixed when the scans around it are in the map, and
/// answered when it is kept. Whoever sees a place may say so; only who has the role of a guide moves or removes one.
/// However many come, they take little of the owner's time: who was not answered sends again.
class MarkKeeper {
 public:
  /// What the owner of the map does with a mark that is new: it goes into the journal.
  using Keep = std::function<void(const FixedMark&)>;

  /// mapper, answered: of the owner, which outlives this.
  MarkKeeper(Service& service, const Mapper& mapper, const MatchStore& answered, Keep keep);

  /// Takes up a mark of an earlier session. False if it does not fit the scans so far.
  bool Restore(const FixedMark& fixed) { return book_.Add(fixed, mapper_); }

  /// Fixes and answers what it is time for; to be called often.
  void Poll(Clock::time_point now);

  /// No more scans come: what waits for one behind it is fixed by the one before it.
  void Finish() { FixSome(held_.size(), Clock::time_point::max()); }

  std::vector<AnchoredMark> Anchor() const { return book_.Anchor(mapper_); }
  std::vector<PlacedMark> Place() const { return book_.Place(mapper_); }

 private:
  static constexpr std::size_t kMostHeld = 256;

  struct Held {
    Mark mark;
    Clock::time_point heard;
  };

  void Hear(const mark_t& message);
  bool MayChange(const Mark& mark);
  void FixSome(std::size_t most, Clock::time_point now);
  bool Fix(const Held& held, Clock::time_point now);
  void Take(const FixedMark& fixed);
  bool IsNew(const Mark& mark, MarkBook::Judgement judgement);
  void Answer(const Mark& mark);
  void Refuse(const Mark& mark, const char* why);

  Service& service_;
  const Mapper& mapper_;
  const MatchStore& answered_;
  Keep keep_;
  MarkBook book_;
  std::deque<Held> held_;
  Clock::time_point next_fix_{};
  LookLimiter looks_{std::chrono::milliseconds(20)};
};

}  // namespace crsm
