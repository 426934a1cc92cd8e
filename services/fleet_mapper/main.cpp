// fleet_mapper: KEYFRAME, POSE_GRAPH and ROBOT_MARKS of several robots -> WHOLE_MAP and FLEET_POSE. Owns the common
// map: what each robot's own stack has found is taken over, and where robots were in the same place is searched.

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/fleet/fleet.hpp"
#include "common/fleet/fleet_drawing.hpp"
#include "common/fleet/fleet_marks.hpp"
#include "services/base/path_lock.hpp"
#include "services/base/usage_error.hpp"
#include "services/bus/service.hpp"
#include "services/fleet_mapper/fleet_view.hpp"
#include "services/fleet_mapper/robot_finder.hpp"
#include "services/fleet_mapper/robot_link.hpp"
#include "services/journal/journal.hpp"
#include "services/journal/map_parameters.hpp"
#include "services/replica/request_limiter.hpp"
#include "services/wire/conversions.hpp"
#include "services/wire/graph_messages.hpp"

namespace crsm {
namespace {

constexpr const char* kAuto = "auto";
constexpr std::size_t kMostRobots = 64;
constexpr auto kHeardWithin = std::chrono::seconds(10);

class FleetMapper {
 public:
  FleetMapper(const CommandLine& command_line, const std::vector<std::string>& robots)
      : settings_(command_line.settings()),
        service_(command_line),
        subject_{false, ListMapParameters(command_line.parameters())},
        fleet_(command_line.parameters().loops, command_line.parameters().update),
        view_(fleet_, clock_, marks_, command_line.parameters().update) {
    service_.TakeRole(kMapOwnerRole);
    OpenJournal();
    for (const std::string& robot : robots) {
      if (robot == kAuto) {
        finder_.emplace(settings_.lcm_url);
      } else {
        Follow(robot);
      }
    }
    service_.bus().Subscribe<map_request_t>(kMapRequestChannel,
                                            [this](const map_request_t& request) { Answer(request); });
  }

  void Run() {
    service_.Run([this] {
      const auto now = Clock::now();
      if (finder_) {
        for (const std::string& robot : finder_->Find()) Follow(robot);
      }
      const bool has_worked = TakeKeyframe();
      for (Robot& robot : robots_) {
        if (const auto request = robot.link.NextRequest(now)) {
          service_.counters().Add("keyframe_requests");
          service_.bus().PublishOf(robot.link.prefix(), kKeyframeRequestChannel, *request);
        }
      }
      SolveNowAndThen(now, has_worked);
      for (const map_page_t& page : view_.Answer(options_)) service_.bus().Publish(kWholeMapChannel, page);
      if (now >= next_poses_) PublishPoses(now);
      return !has_worked && !view_.is_asked();
    });
    Finish();
  }

 private:
  struct Robot {
    explicit Robot(const std::string& prefix, const Fleet& fleet) : link(prefix, fleet) {}
    RobotLink link;
    Clock::time_point last_heard{};
    bool was_joined = false;

    bool IsHeard(Clock::time_point now) const {
      return last_heard != Clock::time_point{} && now - last_heard < kHeardWithin;
    }
  };

  Robot* Find(const std::string& prefix) {
    const auto found = std::ranges::find_if(robots_, [&](const Robot& robot) { return robot.link.prefix() == prefix; });
    return found == robots_.end() ? nullptr : &*found;
  }

  /// Listens to a robot from now on. Those of the journal are followed, too.
  Robot* Follow(const std::string& prefix) {
    if (Robot* robot = Find(prefix)) return robot;
    if (prefix == settings_.channel_prefix) {
      throw UsageError(
          fmt::format("--robots {}: is the prefix of the fleet itself: choose another --channel-prefix", prefix));
    }
    if (robots_.size() == kMostRobots) {
      service_.Complain("robots_refused",
                        fmt::format("fleet_mapper: there are {} robots already: {} is left out", kMostRobots, prefix));
      return nullptr;
    }
    CheckPrefix(prefix);
    robots_.emplace_back(prefix, fleet_);
    Robot* robot = &robots_.back();
    Bus& bus = service_.bus();
    bus.SubscribeToOneOf<keyframe_t>(prefix, kKeyframeChannel, kMapOwnerRole, [this, robot](const keyframe_t& message) {
      Hear(*robot);
      robot->link.Take(message, Clock::now(), UtimeNow());
    });
    bus.SubscribeToOneOf<pose_graph_t>(prefix, kPoseGraphChannel, kLoopCloserRole,
                                       [this, robot](const pose_graph_t& message) {
                                         Hear(*robot);
                                         robot->link.Take(message);
                                       });
    bus.SubscribeToOneOf<robot_marks_t>(prefix, kRobotMarksChannel, kMapOwnerRole,
                                        [this, robot](const robot_marks_t& message) {
                                          Hear(*robot);
                                          TakeMarks(*robot, message);
                                        });
    bus.SubscribeOf<service_status_t>(prefix, ServiceStatusChannel("map_updater"),
                                      [this, robot](const service_status_t&) { Hear(*robot); });
    Say(fmt::format("fleet_mapper: listens to {}", prefix));
    return robot;
  }

  void Hear(Robot& robot) { robot.last_heard = Clock::now(); }

  void TakeMarks(Robot& robot, const robot_marks_t& message) {
    const auto marks = robot.link.Take(message, Clock::now());
    if (!marks) return;
    SetMarks(robot, *marks);
    if (journal_) Keep(*marks);
    if (marks_.Count() > PlacedMark::kMostOnMap) {
      service_.Complain("marks_left_out",
                        fmt::format("fleet_mapper: the robots have {} places: the common map shows {}", marks_.Count(),
                                    PlacedMark::kMostOnMap));
    }
  }

  void SetMarks(Robot& robot, const fleet_marks_t& marks) {
    std::string name = robot.link.prefix();
    if (name.ends_with('/')) name.pop_back();
    marks_.Set(marks.map, name, FromMessage(marks.marks));
  }

  /// One keyframe, of the robots in turn. Whether there was any.
  bool TakeKeyframe() {
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      Robot& robot = robots_[next_robot_++ % robots_.size()];
      const auto told = robot.link.Next(Clock::now());
      if (!told) continue;
      const auto start = Clock::now();
      fleet_keyframe_t kept{};
      kept.robot = robot.link.prefix();
      kept.heard_utime = told->heard_utime;
      kept.solved = std::exchange(has_solved_, false) ? 1 : 0;
      kept.num_keyframes = 1;
      kept.keyframes = {told->message};
      if (!Add(robot, told->map, kept, false)) return true;
      service_.counters().Add("handled");
      service_.RecordLatency(start);
      if (journal_) Keep(kept);
      SayJoins();
      return true;
    }
    return false;
  }

  /// message: gets what was found, unless it is told already. map: none for a new one. False, and nothing is done,
  /// where it does not fit what is there.
  bool Add(Robot& robot, std::optional<int> map, fleet_keyframe_t& message, bool is_told) {
    const keyframe_t& told = message.keyframes.front();
    Keyframe keyframe = FromMessage(told);
    const auto search = FindSearch(told);
    const auto own = search ? search->finding : std::nullopt;
    const bool is_first = FromMessage(told.id) == KeyframeId{} && !keyframe.constraint && !keyframe.as_of && !own;
    if (!map && !is_first) return Refuse(robot);
    const int number = map ? *map : fleet_.BeginMap();
    const std::int64_t utime = keyframe.utime;
    if (!fleet_.Fits(number, keyframe, own)) return Refuse(robot);
    std::optional<EarlierFleetSearch> earlier;
    if (is_told) {
      earlier.emplace();
      for (const fleet_finding_t& finding : message.findings) {
        const KeyframeGraph& graph = fleet_.graph().map(number);
        const FleetFinding found{{finding.map, FromMessage(finding.keyframe)},
                                 {number, NextOf(graph, keyframe.begins)},
                                 FromMessage(finding.T_keyframe_this),
                                 finding.score,
                                 finding.by == loop_finding_t::ANYWHERE};
        if (!fleet_.Fits(number, found)) return false;
        earlier->finding = found;
      }
    }
    const auto found = fleet_.Add(number, std::move(keyframe), own, earlier);
    clock_.Add(fleet_.graph().newest(number), utime, message.heard_utime);
    robot.link.Begin(number, told.epoch);
    if (!is_told && found) {
      message.num_findings = 1;
      message.findings = {{found->older.map, ToMessage(found->older.id), ToMessage(found->T_older_newer), found->score,
                           found->anywhere ? loop_finding_t::ANYWHERE : loop_finding_t::DRIFT}};
    }
    return true;
  }

  static KeyframeId NextOf(const KeyframeGraph& graph, bool begins) {
    const auto newest = graph.newest();
    if (!newest) return {};
    return begins ? KeyframeId{newest->trajectory + 1, 0} : KeyframeId{newest->trajectory, newest->number + 1};
  }

  bool Refuse(const Robot& robot) {
    service_.Complain(
        "keyframes_refused",
        fmt::format("fleet_mapper: {}KEYFRAME does not fit those before it: is there another program that "
                    "sends it? It is left out",
                    robot.link.prefix()));
    return false;
  }

  /// At once where there is time for it; and while there is none, for no more than a fifth of it.
  void SolveNowAndThen(Clock::time_point now, bool is_busy) {
    constexpr int kShare = 5;
    if (!fleet_.graph().needs_solving() || (is_busy && now < next_solve_)) return;
    const auto start = Clock::now();
    Solve();
    const auto end = Clock::now();
    next_solve_ = end + kShare * (end - start);
  }

  void Solve() {
    fleet_.Solve();
    has_solved_ = true;
    SayJoins();
  }

  /// Robots that hang together with what is shown, and those that do not any more.
  void SayJoins() {
    view_.Look();
    for (Robot& robot : robots_) {
      const bool is_joined = IsOnMap(robot);
      if (is_joined == robot.was_joined) continue;
      robot.was_joined = is_joined;
      Say(is_joined ? fmt::format("fleet_mapper: {} is on the common map", robot.link.prefix())
                    : fmt::format("fleet_mapper: {} is on a piece of its own", robot.link.prefix()));
    }
  }

  bool IsOnMap(const Robot& robot) const {
    const auto map = robot.link.map();
    return map && fleet_.graph().piece(fleet_.graph().newest(*map)) == view_.pieces().front();
  }

  void PublishPoses(Clock::time_point now) {
    next_poses_ = now + std::chrono::seconds(1);
    std::int64_t num_heard = 0;
    std::string waiting;
    for (const Robot& robot : robots_) {
      const bool is_heard = robot.IsHeard(now);
      num_heard += is_heard;
      if (robot.link.waits_for_loop_closer())
        waiting += fmt::format("; {} waits for its loop_closer", robot.link.prefix());
      if (robot.link.map()) service_.bus().Publish(kFleetPoseChannel, MakePose(robot, *robot.link.map(), is_heard));
    }
    service_.counters().Set("robots", std::ssize(robots_));
    service_.counters().Set("robots_heard", num_heard);
    service_.counters().Set("robots_behind",
                            std::ranges::count_if(robots_, [](const Robot& robot) { return robot.link.is_behind(); }));
    service_.counters().Set("keyframes", std::ssize(fleet_.keyframes()));
    service_.counters().Set("keyframes_searched", fleet_.num_searched());
    service_.counters().Set("marks", static_cast<std::int64_t>(marks_.Count()));
    service_.counters().Set("pieces", std::ssize(view_.pieces()));
    service_.counters().Set("loops_between_robots", std::ssize(fleet_.graph().loops()));
    service_.counters().Set("loops_rejected", std::ssize(fleet_.graph().rejected()));
    service_.SetState(fmt::format("{} of {} robots heard{}{}", num_heard, robots_.size(), waiting,
                                  journal_ || settings_.journal.empty() ? "" : "; the journal cannot be written"));
  }

  fleet_pose_t MakePose(const Robot& robot, int map, bool is_heard) {
    constexpr std::size_t kMostTrajectories = 1024;
    view_.Look();
    const FleetGraph& graph = fleet_.graph();
    const FleetKeyframeId newest = graph.newest(map);
    fleet_pose_t message{};
    message.utime = UtimeNow();
    message.robot = robot.link.prefix();
    message.epoch = robot.link.epoch();
    message.scan_utime = graph.map(map).keyframe(newest.id).utime;
    message.num_keyframes = graph.map(map).size();
    message.T_common_map = ToMessage(graph.FindFrame(map));
    std::ranges::copy(graph.covariance(map), message.covariance);
    const auto piece = std::ranges::find(view_.pieces(), graph.piece(newest));
    message.piece = static_cast<std::int32_t>(piece - view_.pieces().begin()) + 1;
    message.floating = message.piece == 1 ? 0 : 1;
    message.heard = is_heard ? 1 : 0;
    for (std::size_t i = 0; i < graph.trajectories().size(); ++i) {
      const bool is_its = std::ranges::count(robot.link.maps(), graph.trajectories()[i].first) > 0;
      if (is_its) message.trajectories.push_back(static_cast<std::int32_t>(i));
    }
    if (message.trajectories.size() > kMostTrajectories) {
      message.trajectories.erase(message.trajectories.begin(),
                                 message.trajectories.end() - static_cast<std::ptrdiff_t>(kMostTrajectories));
    }
    message.num_trajectories = static_cast<std::int32_t>(message.trajectories.size());
    return message;
  }

  void Answer(const map_request_t& request) {
    service_.counters().Add("map_requests");
    if (request.whole == 0) return;  // there is no map to match to
    if (!request_limiter_.Admit(service_.bus().sender(), request.requester, Clock::now())) {
      return service_.Complain(
          "map_requests_refused",
          "fleet_mapper: MAP_REQUEST comes more often than anybody needs: most of them get no answer");
    }
    if (request.settled == 1 && !IsSettled()) return;  // it will be asked again
    view_.Ask(request, service_.bus().sender());
  }

  /// Whether all that the robots have is on the common map, where they can be heard.
  bool IsSettled() {
    const auto now = Clock::now();
    bool is_settled = !fleet_.graph().needs_solving();
    for (Robot& robot : robots_) {
      if (!robot.IsHeard(now)) continue;
      const bool has_told_marks = robot.link.HasToldMarks(now);  // all are asked at the same time
      is_settled = is_settled && has_told_marks && !robot.link.is_behind();
    }
    return is_settled;
  }

  void OpenJournal() {
    if (settings_.journal.empty()) {
      if (settings_.resume) throw UsageError("--resume needs --journal DIR, the folder of the fleet's journal");
      return;
    }
    if (!settings_.resume || !std::filesystem::exists(JournalPath(settings_.journal))) {
      journal_.emplace(settings_.journal, subject_);
      LockJournal();
    } else {
      LockJournal();
      const OnDamage on_damage = settings_.until_damage ? OnDamage::kTakeWhatIsBefore : OnDamage::kRefuse;
      VisitJournal visit{[this](const CriticalRays*, const ScanMatch&) {
        throw std::runtime_error(
            fmt::format("{}: is the journal of one robot, and not of a fleet: choose another folder",
                        JournalPath(settings_.journal).string()));
      }};
      visit.fleet_keyframe = [this](const fleet_keyframe_t& keyframe) { return Restore(keyframe); };
      visit.fleet_marks = [this](const fleet_marks_t& marks) { return Restore(marks); };
      journal_.emplace(settings_.journal, subject_, on_damage, visit);
      fleet_.Solve();
      has_solved_ = true;
      if (!journal_->notice().empty()) Say(fmt::format("fleet_mapper: {}", journal_->notice()));
      Say(fmt::format("fleet_mapper: continues after {} keyframes of {} robots from {}", fleet_.keyframes().size(),
                      robots_.size(), settings_.journal));
    }
    service_.SetIdentity(FormatIdentity(journal_->epoch()));
    options_.epoch = IdentityOfThisBoot(journal_->epoch());
  }

  void LockJournal() { journal_lock_.emplace("--journal", JournalPath(settings_.journal)); }

  /// A keyframe of the journal: in its map, or the first of a new one.
  bool Restore(const fleet_keyframe_t& kept) {
    Robot* robot = Follow(kept.robot);
    if (!robot) return false;
    if (kept.solved == 1) fleet_.Solve();
    const bool begins = FromMessage(kept.keyframes.front().id) == KeyframeId{};
    if (!begins && !robot->link.map()) return false;
    fleet_keyframe_t message = kept;
    return Add(*robot, begins ? std::nullopt : robot->link.map(), message, true);
  }

  /// The places of a map of the journal.
  bool Restore(const fleet_marks_t& marks) {
    const auto robot = std::ranges::find_if(
        robots_, [&](const Robot& one) { return std::ranges::count(one.link.maps(), marks.map) > 0; });
    if (robot == robots_.end() || !FleetMarks::Fits(fleet_.graph(), marks.map, FromMessage(marks.marks))) return false;
    robot->link.Hold(marks);
    SetMarks(*robot, marks);
    return true;
  }

  template <class Message>
  void Keep(const Message& message) {
    try {
      journal_->Append(message);
    } catch (const std::runtime_error& error) {
      Say(fmt::format("fleet_mapper: {}; the common map goes on without a journal", error.what()));
      service_.counters().Add("journal_failed");
      journal_.reset();
      service_.SetIdentity("");
    }
  }

  /// What was heard is on the common map.
  void Finish() {
    while (TakeKeyframe()) {
    }
    fleet_.Solve();
    if (journal_) journal_->Finish();
  }

  const Settings& settings_;
  Service service_;
  JournalSubject subject_;
  Fleet fleet_;
  FleetClock clock_;
  FleetMarks marks_;
  FleetView view_;
  std::deque<Robot> robots_;
  std::optional<RobotFinder> finder_;
  std::size_t next_robot_ = 0;
  AnswerOptions options_{DrawIdentity(), static_cast<std::size_t>(settings_.part_bytes)};
  RequestLimiter request_limiter_{[](const Sender&) { return false; }};
  std::optional<PathLock> journal_lock_;
  std::optional<Journal> journal_;
  bool has_solved_ = false;  ///< since the last keyframe
  Clock::time_point next_solve_{};
  Clock::time_point next_poses_{};
};

}  // namespace
}  // namespace crsm

int main(int argc, char** argv) {
  crsm::CommandLine command_line(
      "fleet_mapper",
      "Makes one map of several robots, each of which maps for itself: KEYFRAME, POSE_GRAPH, "
      "ROBOT_MARKS -> WHOLE_MAP, FLEET_POSE.",
      crsm::FlagsOfFleetMapper());
  std::vector<std::string> robots;
  command_line.AddOption("--robots", robots,
                         "channel prefixes of the robots: robot1/ robot2/; auto: of all that are heard");
  if (const auto exit_code = command_line.Parse(argc, argv)) return *exit_code;
  return crsm::RunMain(command_line.program(), [&] {
    if (robots.empty()) throw crsm::UsageError("--robots: is missing: give the robots' channel prefixes, or auto");
    crsm::FleetMapper(command_line, robots).Run();
  });
}
