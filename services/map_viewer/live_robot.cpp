#include "services/map_viewer/live_robot.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "common/results/json_text.hpp"
#include "common/scan/deskew.hpp"
#include "services/base/printable.hpp"
#include "services/bus/known_statuses.hpp"
#include "services/map_viewer/run_facts.hpp"
#include "services/map_viewer/service_info.hpp"
#include "services/wire/conversions.hpp"

namespace crsm {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kMostStageTimes = 600;

/// The stages that a scan goes through one after the other.
constexpr const char* kStages[]{"ray_selector", "rrhc_matcher", "map_updater"};

}  // namespace

LiveRobot::LiveRobot(const CommandLine& command_line)
    : service_(command_line),
      scene_(command_line.settings().channel_prefix),
      map_follower_(service_, MapFollower::View::kWhole,
                    {[this](double cell_size_m) { Begin(cell_size_m); },
                     [this](std::span<const TileChange> changes) { return Apply(changes); },
                     [this](const ScanMatch& match) { Add(match); }}) {
  Bus& bus = service_.bus();
  bus.SubscribeToOne<critical_rays_t>(kCriticalRaysChannel, kSelectorRole, [this](const critical_rays_t& message) {
    scan_heard_ = Clock::now();
    scans_.Hold(FromMessage(message));
  });
  bus.SubscribeToOne<scan_match_t>(kScanMatchChannel, kMatcherRole,
                                   [this](const scan_match_t& message) { Hear(message); });
  bus.SubscribeToOne<bot_core::pose_t>(kLocalPoseChannel, kMatcherRole,
                                       [this](const bot_core::pose_t& message) { Hear(message); });
  bus.SubscribeToOne<fleet_pose_t>(kFleetPoseChannel, kMapOwnerRole,
                                   [this](const fleet_pose_t& message) { Hear(message); });
  bus.SubscribeToOne<changes_t>(kChangesChannel, kMapOwnerRole,
                                [this](const changes_t& message) { changes_ = FromMessage(message); });
  TakeRole();
  scene_.SetStartHandler([this](const Pose2& T_map_laser) {
    TakeRole();
    service_.counters().Add("start_sent");
    service_.bus().Publish(kStartPoseChannel, ToPoseMessage(0, T_map_laser));
  });
  scene_.SetMarkHandler([this](const Mark& mark) {
    TakeRole();
    if (sent_marks_.size() < kMostSentMarks) sent_marks_.push_back({mark, Clock::now()});
  });
  bus.SubscribeToOne<mark_t>(kMarkAnswerChannel, kMapOwnerRole, [this](const mark_t& answer) {
    std::erase_if(sent_marks_,
                  [&](const SentMark& sent) { return sent.mark.id == answer.id && sent.mark.utime == answer.utime; });
  });
  bus.Subscribe<service_status_t>(kEveryServiceStatus, [this](const service_status_t& status) { Keep(status); });
}

/// Of who may tell the robot where it is. Another viewer may have it, until it ends.
void LiveRobot::TakeRole() {
  if (has_role_) return;
  try {
    service_.TakeRole(kGuideRole);
    has_role_ = true;
  } catch (const std::runtime_error& error) {
    service_.Complain("start_not_allowed",
                      fmt::format("{}: the pin tells the robot nothing: {}", service_.name(), error.what()));
  }
}

/// In their order, each until it is answered.
void LiveRobot::SendMarks() {
  constexpr auto kPause = milliseconds(300);
  constexpr int kMostTries = 40;
  if (sent_marks_.empty()) return;
  SentMark& sent = sent_marks_.front();
  const auto now = Clock::now();
  if (now < sent.next_try) return;
  if (sent.tries++ == kMostTries) {
    scene_.AddNews({fmt::format("{} was not kept: is map_updater running, and is there no other map_viewer?",
                                sent.mark.name.empty() ? sent.mark.id : sent.mark.name)});
    sent_marks_.pop_front();
    return;
  }
  sent.next_try = now + kPause;
  service_.bus().Publish(kMarkChannel, ToMessage(sent.mark));
}

void LiveRobot::Step(bool is_watched) {
  SendMarks();
  AskNowAndThen(is_watched);
  map_follower_.Poll();
  ShowMap();
  if (Clock::now() >= next_info_) ShowInfo();
}

void LiveRobot::Begin(double cell_size_m) {
  map_.emplace(cell_size_m);
  touched_.clear();
  is_anew_ = true;
  path_ = PathSketch();
  path_is_anew_ = true;
  fleet_.Begin();
}

bool LiveRobot::Apply(std::span<const TileChange> changes) {
  return map_->Apply(changes, [this](const TileChange& change) { touched_.insert(change.index); });
}

/// Where a scan of the path was taken, by all that is known now.
void LiveRobot::Add(const ScanMatch& match) {
  path_.Add(match);
  fleet_.Add(match);
  last_known_ = match;
}

void LiveRobot::Hear(const scan_match_t& message) {
  match_heard_ = Clock::now();
  last_match_ = FromMessage(message);
  if (last_match_->map_version == 0) ForgetRun();
  scene_.AddSample({last_match_->utime, static_cast<float>(last_match_->fitness), last_match_->state});
  service_.counters().Add("handled");
  if (!T_best_local_) Show(*last_match_);
}

/// The robot stands on the map that is shown, which a loop may have corrected already when the map that scans are
/// matched to was not yet, or the other way round. What leads from one scan to the next is the same on both: it is
/// taken from the poses that never jump.
void LiveRobot::Hear(const bot_core::pose_t& message) {
  const Odometry local = FromMessage(message);
  if (!local.T_odom_robot) return;
  local_poses_.Hold({local.utime, *local.T_odom_robot});
  if (!T_best_local_ || !last_match_ || last_match_->utime != local.utime) return;
  ScanMatch match = *last_match_;
  match.T_map_laser = *T_best_local_ * *local.T_odom_robot;
  if (last_known_ && last_known_->trajectory == match.trajectory) match.floating = last_known_->floating;
  Show(std::move(match));
}

void LiveRobot::Hear(const fleet_pose_t& pose) {
  if (fleet_.Hear(pose, Clock::now())) return;
  service_.Complain("fleet_poses_ignored",
                    fmt::format("{}: FLEET_POSE is of more than {} robots, or of none: the page leaves out {}",
                                service_.name(), FleetRobots::kMost, MakePrintable(pose.robot)));
}

/// Another run begins, on a map of its own or on a finished one: what is known of scans by their utimes may be of
/// another log.
void LiveRobot::ForgetRun() {
  local_poses_ = {};
  last_known_.reset();
  T_best_local_.reset();
  changes_.clear();
}

void LiveRobot::Show(ScanMatch match) {
  const CriticalRays* scan = scans_.Find(match.utime);
  CriticalRays deskewed = scan ? Deskew(*scan, match.twist) : CriticalRays();
  scene_.SetRobot({std::move(match), std::move(deskewed)});
}

void LiveRobot::Keep(const service_status_t& status) {
  if (MayKeepStatus(statuses_, status.name, "the page", service_)) statuses_[status.name] = {status, Clock::now()};
}

void LiveRobot::AskNowAndThen(bool is_watched) {
  constexpr auto kLeastPause = milliseconds(100);
  constexpr auto kPauseUnwatched = std::chrono::seconds(5);
  constexpr int kOwnersShare = 20;
  const auto now = Clock::now();
  const bool synced = map_follower_.replica().synced();
  if (asked_ && synced) {
    next_ask_ = now + std::max<Clock::duration>(kLeastPause, kOwnersShare * (now - *asked_));
    asked_.reset();
  }
  const auto due = is_watched ? next_ask_ : next_ask_ + kPauseUnwatched;
  if (!asked_ && synced && now >= due) {
    map_follower_.RequestUpdate();
    asked_ = now;
  }
}

/// When it is whole; where it is corrected again and again, and is never whole for long, what there is of it.
void LiveRobot::ShowMap() {
  constexpr auto kPatience = milliseconds(500);
  if (!map_ || (touched_.empty() && !is_anew_ && !path_is_anew_ && !map_follower_.replica().synced())) return;
  const MapReplica& replica = map_follower_.replica();
  const auto now = Clock::now();
  if (!replica.synced() && now < next_glimpse_) return;
  next_glimpse_ = now + kPatience;
  SceneMap& shown = scene_.map();
  if (shown.cell_size_m() != map_->geometry().cell_size_m()) shown.Begin(map_->geometry().cell_size_m());
  for (const TileIndex index : std::exchange(touched_, {})) {
    if (const ByteMap::Tile* tile = map_->tiles().Find(index)) shown.Set(index, tile->cells, replica.version());
  }
  if (!replica.synced()) return;
  scene_.SetMarks(replica.marks());
  if (std::exchange(is_anew_, false)) shown.Replace(*map_, replica.version());
  if (shown.version() == replica.version() && shown.epoch() == replica.epoch()) return;
  if (shown.epoch() != replica.epoch()) next_info_ = now;  // says why
  shown.SetVersion(replica.epoch(), replica.version());
  scene_.SetPath(path_, std::exchange(path_is_anew_, false));
  if (const LocalPose* local = last_known_ ? local_poses_.Find(last_known_->utime) : nullptr) {
    T_best_local_ = last_known_->T_map_laser * Inverse(local->T_local_laser);
  }
  scene_.SetLoops(replica.loops());
  fleet_.Show();
  if (!replica.pieces()) return;
  const std::vector<JoinEvent> news = join_news_.Look(*replica.pieces());
  scene_.AddNews(fleet_.empty() ? Describe(news) : fleet_.DescribeNews(news));
}

void LiveRobot::ShowInfo() {
  const auto now = Clock::now();
  next_info_ = now + std::chrono::seconds(1);
  statuses_[service_.name()] = {service_.MakeStatus(), now};
  nlohmann::json info{{"live", true}};
  info.update(DescribeCounts(path_.counts()));
  info["changes"] = DescribeChanges(changes_);
  std::int64_t num_left_out = 0;
  for (const auto& [name, heard] : statuses_) num_left_out += heard.status.num_left_out;
  info["left_out"] = num_left_out;
  for (const auto& [name, heard] : {std::pair("scan_age_s", scan_heard_), std::pair("match_age_s", match_heard_)}) {
    if (heard) info[name] = std::chrono::duration<double>(now - *heard).count();
  }
  if (const auto& pieces = map_follower_.replica().pieces()) {
    info["loops_closed"] = pieces->num_closed;
    info["another_piece"] = IsFirstElsewhere(*pieces);
  }
  if (!fleet_.empty()) info["fleet"] = fleet_.Describe(now);
  for (const auto& [name, heard] : statuses_) {
    info["services"].push_back(DescribeService(heard.status, std::chrono::duration<double>(now - heard.heard).count()));
  }
  StageTimes times;
  for (const char* stage : kStages) {
    const auto heard = statuses_.find(stage);
    if (heard == statuses_.end()) continue;
    times.median_ms += heard->second.status.latency_p50_ms;
    times.p99_ms += heard->second.status.latency_p99_ms;
  }
  stage_times_.push_back(times);
  if (stage_times_.size() > kMostStageTimes) stage_times_.pop_front();
  for (const auto& [median_ms, p99_ms] : stage_times_) info["scan_times_ms"].push_back({median_ms, p99_ms});
  scene_.SetInfo(ToText(info));
}

}  // namespace crsm
