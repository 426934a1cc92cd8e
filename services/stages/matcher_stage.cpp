#include "services/stages/matcher_stage.hpp"

#include <fmt/core.h>

#include <cmath>
#include <utility>

#include "common/match/match_scan.hpp"
#include "common/scan/scan_counts.hpp"
#include "services/diagnosis/lost_news.hpp"
#include "services/wire/pose_types.hpp"

namespace crsm {
namespace {

using Seconds = std::chrono::duration<double>;

/// But for the last bits of the poses, which a map that is corrected takes along.
bool AreSame(ScanMatch a, const ScanMatch& b) {
  constexpr double kLastBits = 1e-6;  // [m] and [rad]
  const Pose2 error = Inverse(a.T_map_laser) * b.T_map_laser;
  if (Length(error) < kLastBits && std::abs(error.yaw_rad) < kLastBits) a.T_map_laser = b.T_map_laser;
  return a == b;
}

const char* Describe(const ScanMatch& match) {
  switch (OutcomeOf(match)) {
    case ScanOutcome::kLost:
      return "lost";
    case ScanOutcome::kWithoutRays:
      return "without rays";
    default:
      return match.state == MatchState::kDegenerate ? "degenerate" : "matching";
  }
}

}  // namespace

MatcherStage::MatcherStage(const CommandLine& command_line, MakeMatcher make_matcher)
    : matching_{command_line.parameters().loops.loops},
      settings_(command_line.settings()),
      service_(command_line),
      scans_(service_.counters()),
      make_matcher_(std::move(make_matcher)),
      map_(service_, {[this](double cell_size_m) {
                        matcher_ = make_matcher_(cell_size_m);
                        last_match_.reset();
                      },
                      [this](std::span<const TileChange> changes) { return matcher_->Apply(changes); }}),
      stall_watch_(service_.name(), Say) {
  service_.TakeRole(kMatcherRole);
  service_.bus().SubscribeToOne<critical_rays_t>(
      kCriticalRaysChannel, kSelectorRole, [this](const critical_rays_t& message) { Receive(FromMessage(message)); });
  service_.bus().SubscribeBytes(kStartPoseChannel,
                                [this](std::span<const std::uint8_t> bytes) { return ReceiveStart(bytes); });
  if (!settings_.odometry) return;
  const std::string channel = settings_.odometry_topic.empty() ? kOdometryChannel : settings_.odometry_topic;
  service_.bus().SubscribeBytes(channel, [this](std::span<const std::uint8_t> bytes) {
    const auto odometry = DecodePose(bytes);
    if (odometry) odometry_.Add(*odometry);
    expects_odometry_ |= odometry && odometry->T_odom_robot;
    return odometry.has_value();
  });
}

void MatcherStage::Run() {
  constexpr int kPeriod_ms = 20;  // of looks at what is waited for
  service_.Run(
      [this] {
        while (!scans_.empty() && Answer(scans_.front())) scans_.Pop();
        map_.Poll();
        if (settings_.lockstep) stall_watch_.Look(Awaited(), Clock::now());
        return true;
      },
      kPeriod_ms);
}

/// A scan whose match was lost on the way is answered at once, also while another one waits.
void MatcherStage::Receive(CriticalRays scan) {
  if (!AnswerAgain(scan.utime)) scans_.Push(std::move(scan));
}

/// Somebody says where the robot is. While a map is made that would tear it.
bool MatcherStage::ReceiveStart(std::span<const std::uint8_t> bytes) {
  const auto told = DecodePose(bytes);
  if (!told || !told->T_odom_robot) return false;
  const TrackingState& tracking = map_.replica().tracking();
  if (!tracking.on_finished_map() || tracking.empty()) {
    service_.Complain("start_ignored",
                      fmt::format("{}: START_POSE is ignored: it is for a robot that is localised on a "
                                  "finished map, after its first scan",
                                  service_.name()));
    return true;
  }
  const Sender sender = service_.bus().sender();
  const auto now = Clock::now();
  if (!start_looks_.MayLook(sender, now) || !service_.bus().MayHaveRole(sender, kGuideRole)) {
    service_.Complain("start_refused", fmt::format("{}: START_POSE from {} is refused: only map_viewer, or another "
                                                   "process with the role {}, may tell where the robot is",
                                                   service_.name(), sender.Describe(), kGuideRole));
    return true;
  }
  told_start_ = told->T_odom_robot;
  service_.counters().Add(kStartTold);
  const auto line = start_lines_.Pass(
      fmt::format("{}: {}{}: the robot is at x {:.2f} m, y {:.2f} m, yaw {:.2f} rad: the next scan is searched there",
                  service_.name(), kToldBy, sender.Describe(), told_start_->x_m, told_start_->y_m,
                  told_start_->yaw_rad),
      now);
  if (line) Say(*line);
  return true;
}

bool MatcherStage::AnswerAgain(std::int64_t utime) {
  const TrackingState& tracking = map_.replica().tracking();
  const bool is_last = last_match_ && last_match_->utime == utime;
  const ScanMatch* match = is_last ? &*last_match_ : tracking.FindRecent(utime);  // before this process was started
  if (!match) return false;
  service_.counters().Add("resent");
  if (is_last || match == &tracking.recent().back()) {
    Publish(*match, is_last ? T_local_map_ : tracking.T_local_map());
  } else {  // POSE does not go back
    service_.bus().Publish(kScanMatchChannel, ToMessage(*match));
  }
  return true;
}

/// Answers a scan if it can be answered now.
bool MatcherStage::Answer(const CriticalRays& scan) {
  if (AnswerAgain(scan.utime)) return true;
  const std::optional<bool> in_map = IsInMap(scan.utime);
  if (!in_map) return false;
  if (*in_map) {  // in an earlier session, say, or a packet that was under way for long
    service_.counters().Add("utime_repeated");
    SayLeftOut();
    service_.bus().Publish(kScanMatchChannel, ToMessage(*map_.AnswerAbout(scan.utime)->match));
    return true;
  }
  if (!MapIsCurrent()) return false;
  ScanOdometry odometry;
  if (settings_.odometry) {
    odometry = FindOdometry(scan.utime);
    if (odometry.state == ScanOdometry::State::kAwaited && settings_.lockstep) {
      service_.counters().Add("odometry_awaited");  // it will be sent again, and the scan with it
      odometry_awaited_ = scan.utime;
      service_.SetState("waiting for ODOMETRY: does the publisher run with --no-odometry?");
      return true;
    }
    const bool is_awaited = odometry.state == ScanOdometry::State::kAwaited && expects_odometry_;
    if (is_awaited && !HasWaitedLong(scan.utime)) return false;
    if (odometry.state != ScanOdometry::State::kKnown && expects_odometry_) service_.counters().Add("odometry_missing");
    if (is_awaited) expects_odometry_ = false;
  }
  Match(scan, odometry.T_odom_robot);
  return true;
}

/// In lockstep it is no news: there the source of the scans has told it, or an earlier session has mapped them.
void MatcherStage::SayLeftOut() {
  const auto news = left_out_.LeaveOut(Clock::now());
  if (!news || settings_.lockstep) return;
  Say(fmt::format("{}: {} of the last {} scans {}: the clock of the laser went back, or an earlier session has them",
                  service_.name(), news->num_left_out, news->num_all, kUtimeRepeated));
}

/// In lockstep the publisher sends the odometry of each scan with the scan's own utime, so that nothing depends on when
/// it comes. Live, wheels have a clock of their own: it is what lies between the samples around the scan.
ScanOdometry MatcherStage::FindOdometry(std::int64_t utime) {
  return settings_.lockstep ? odometry_.FindExact(utime) : odometry_.Find(utime);
}

/// Whether a scan has been held for as long as may be; from the first question on.
bool MatcherStage::HasWaitedLong(std::int64_t utime) {
  const auto now = Clock::now();
  if (held_utime_ != utime) held_since_ = now;
  held_utime_ = utime;
  return now - held_since_ > Seconds(settings_.map_wait_s);
}

/// Whether the map that the last match made is here, or has been waited for long enough. To be asked for a new scan.
bool MatcherStage::MapIsCurrent() {
  const MapReplica& replica = map_.replica();
  const auto now = Clock::now();
  const bool answered = !last_match_ || WasAnswered(last_match_->utime);
  if (replica.synced() && answered) {
    CheckAnswer();
    return true;
  }
  if (replica.synced() && settings_.lockstep && std::exchange(has_doubted_, false)) {
    // The publisher has gone on, so that scan was in the map; the owner, asked since, has it no longer.
    service_.Complain(
        "match_taken_back",
        fmt::format("{}: map_updater has lost scan {} again, by a power cut say: the map goes on without it",
                    service_.name(), last_match_->utime));
    last_match_.reset();
    return true;
  }
  if (replica.synced() && doubt_.Due(now)) {
    map_.RequestUpdate();
    has_doubted_ = true;
  }
  const bool has_map = replica.synced() || replica.version() > 0;  // whole, be it an old one
  if (settings_.lockstep || !has_map) return false;
  if (now - last_match_time_ < Seconds(settings_.map_wait_s)) return false;
  service_.counters().Add("map_late");
  return true;
}

/// Where senders are not known, this is how it shows that the map has another one's match of a scan.
void MatcherStage::CheckAnswer() {
  const ScanMatch* answered = last_match_ ? map_.replica().tracking().FindRecent(last_match_->utime) : nullptr;
  if (!answered || AreSame(*answered, LastMatchAsOfNow())) return;
  service_.Complain("match_contradicted", fmt::format("{}: map_updater and this matcher have different poses of scan "
                                                      "{}: is there another matcher on this bus? The map may be wrong",
                                                      service_.name(), last_match_->utime));
}

/// The map may have been corrected since it was found, and the poses of the last scans with it.
ScanMatch MatcherStage::LastMatchAsOfNow() const {
  ScanMatch match = *last_match_;
  const Pose2& T_local_map = map_.replica().tracking().T_local_map();
  if (T_local_map != T_local_map_) match.T_map_laser = Inverse(T_local_map) * T_local_map_ * match.T_map_laser;
  return match;
}

/// In lockstep: what the next match takes that is not here. What the map's owner is asked for, MapFollower says.
StallWatch::Awaited MatcherStage::Awaited() const {
  const MapReplica& replica = map_.replica();
  if (!replica.synced() || (!last_match_ && replica.tracking().empty())) return {};
  if (last_match_ && !WasAnswered(last_match_->utime)) return {"version {} of the map", replica.version() + 1};
  if (odometry_awaited_)
    return {"ODOMETRY of scan {} (does the publisher run with --no-odometry?)", *odometry_awaited_};
  return {"CRITICAL_RAYS after those of scan {}", replica.tracking().recent().back().utime};
}

bool MatcherStage::WasAnswered(std::int64_t utime) const { return map_.replica().tracking().FindRecent(utime); }

/// Whether a scan is in the map already; nothing while the owner is being asked. Scans that go on in time are new; one
/// that steps back may be of an earlier session, or of a clock that does.
std::optional<bool> MatcherStage::IsInMap(std::int64_t utime) {
  const MapReplica& replica = map_.replica();
  if (utime > replica.tracking().newest_utime() || map_.IsKnownToBeNew(utime)) return false;
  if (const auto* answer = map_.AnswerAbout(utime)) return answer->match.has_value();
  map_.AskAbout(utime);
  if (HasWaitedLong(utime) && !settings_.lockstep)
    return false;  // if it is there, the owner will say so and not draw it again
  return std::nullopt;
}

void MatcherStage::Match(const CriticalRays& scan, const std::optional<Pose2>& T_odom_robot) {
  const auto start = Clock::now();
  const MapReplica& replica = map_.replica();
  TrackingState tracking = replica.tracking();
  if (last_match_ && !WasAnswered(last_match_->utime)) tracking.Add(*last_match_);  // the map is late; this counts
  const auto told_start = std::exchange(told_start_, std::nullopt);
  if (told_start && tracking.on_finished_map()) tracking = tracking.MovedTo(*told_start);
  last_match_ = MatchScan(*matcher_, scan, tracking, T_odom_robot, matching_);
  last_match_->map_version = replica.version();
  T_local_map_ = tracking.T_local_map();
  last_match_time_ = Clock::now();
  doubt_.Restart(last_match_time_);
  has_doubted_ = false;
  odometry_awaited_.reset();
  map_.Await(*last_match_);
  service_.RecordLatency(start);
  service_.counters().Add("handled");
  left_out_.Take();
  if (OutcomeOf(*last_match_) == ScanOutcome::kLost) service_.counters().Add("lost");
  if (last_match_->state == MatchState::kDegenerate) service_.counters().Add("degenerate");
  service_.SetState(Describe(*last_match_));
  Publish(*last_match_, T_local_map_);
}

void MatcherStage::Publish(const ScanMatch& match, const Pose2& T_local_map) {
  service_.bus().Together([&] {
    service_.bus().Publish(kScanMatchChannel, ToMessage(match));
    service_.bus().Publish(kPoseChannel, ToPoseMessage(match));
    service_.bus().Publish(kLocalPoseChannel, ToPoseMessage(match.utime, T_local_map * match.T_map_laser));
  });
}

}  // namespace crsm
