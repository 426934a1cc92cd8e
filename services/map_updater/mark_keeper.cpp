#include "services/map_updater/mark_keeper.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "services/base/printable.hpp"
#include "services/diagnosis/lost_news.hpp"
#include "services/wire/conversions.hpp"

namespace crsm {

MarkKeeper::MarkKeeper(Service& service, const Mapper& mapper, const MatchStore& answered, Keep keep)
    : service_(service), mapper_(mapper), answered_(answered), keep_(std::move(keep)) {
  service_.bus().Subscribe<mark_t>(kMarkChannel, [this](const mark_t& message) { Hear(message); });
}

void MarkKeeper::Poll(Clock::time_point now) {
  constexpr std::size_t kAtOnce = 10;
  constexpr auto kPeriod = std::chrono::milliseconds(50);
  if (held_.empty() || now < next_fix_) return;
  next_fix_ = now + kPeriod;
  FixSome(kAtOnce, now);
}

void MarkKeeper::Hear(const mark_t& message) {
  Mark mark = FromMessage(message);
  if (!MayChange(mark)) return;
  const auto IsSame = [&](const Held& held) { return held.mark.id == mark.id && held.mark.utime == mark.utime; };
  if (std::ranges::any_of(held_, IsSame)) return;
  if (held_.size() == kMostHeld) return Refuse(mark, "too many come at a time");
  held_.push_back({std::move(mark), Clock::now()});
}

/// Everybody may see something. What others have said may be taken back by a guide alone.
bool MarkKeeper::MayChange(const Mark& mark) {
  if (mark.action == MarkAction::kSeen) return true;
  const Sender sender = service_.bus().sender();
  if (looks_.MayLook(sender, Clock::now()) && service_.bus().MayHaveRole(sender, kGuideRole)) return true;
  service_.Complain("marks_refused", fmt::format("{}: {}from {} is refused: only map_viewer, or another process with "
                                                 "the role {}, may move or remove a place",
                                                 service_.name(), kMarkNews, sender.Describe(), kGuideRole));
  return false;
}

/// The first ones. Those that are still to be held come last then.
void MarkKeeper::FixSome(std::size_t most, Clock::time_point now) {
  for (std::size_t num = std::min(most, held_.size()); num > 0; --num) {
    Held held = std::move(held_.front());
    held_.pop_front();
    if (!Fix(held, now)) held_.push_back(std::move(held));
  }
}

/// Whether a mark need not be held any longer.
bool MarkKeeper::Fix(const Held& held, Clock::time_point now) {
  constexpr auto kPatience = std::chrono::seconds(1);  // for the scan behind it
  if (answered_.size() == 0) return false;
  const Mark& mark = held.mark;
  if (!IsNew(mark, book_.Judge(mark))) return true;
  if (mark.action == MarkAction::kRemoved) {
    Take({mark, {}});
    return true;
  }
  if (mark.in_map_frame) {
    Take(FixOnMap(mark, mapper_));
    return true;
  }
  const auto before = answered_.FindUpTo(mark.utime);
  const auto after = answered_.FindBehind(mark.utime);
  const bool is_exact = before && before->match.utime == mark.utime;
  if (!is_exact && !after && now - kPatience < held.heard) return false;
  const auto fixed = FixByLaser(mark, before, is_exact ? std::nullopt : after, mapper_);
  fixed ? Take(*fixed) : Refuse(mark, "no scan was matched within 0.5 s of it");
  return true;
}

void MarkKeeper::Take(const FixedMark& fixed) {
  if (!IsNew(fixed.mark, book_.Judge(fixed))) return;
  keep_(fixed);
  book_.Add(fixed, mapper_);
  service_.counters().Add("marks_kept");
  Answer(fixed.mark);
}

/// Others are answered, or refused.
bool MarkKeeper::IsNew(const Mark& mark, MarkBook::Judgement judgement) {
  if (judgement == MarkBook::Judgement::kNew) return true;
  judgement == MarkBook::Judgement::kKnown ? Answer(mark) : Refuse(mark, DescribeJudgement(judgement));
  return false;
}

void MarkKeeper::Answer(const Mark& mark) { service_.bus().Publish(kMarkAnswerChannel, ToMessage(mark)); }

void MarkKeeper::Refuse(const Mark& mark, const char* why) {
  service_.Complain("marks_refused",
                    fmt::format("{}: {}of {} is refused: {}", service_.name(), kMarkNews, MakePrintable(mark.id), why));
}

}  // namespace crsm
