// rrhc_matcher: CRITICAL_RAYS, the map so far and, with --odometry, ODOMETRY -> SCAN_MATCH and POSE.
//
// All that a match depends on comes with messages: the rays, its odometry, the map and the earlier matches with theirs
// from the map's owner, the seed from the command line. A matcher that is started anew goes on where the last one
// stood.

#include <unordered_map>

#include "common/match/rrhc_matcher.hpp"
#include "services/runtime/conversions.hpp"
#include "services/runtime/held_by_utime.hpp"
#include "services/runtime/map_follower.hpp"
#include "services/runtime/scan_queue.hpp"
#include "services/runtime/service.hpp"

namespace crsm {
namespace {

class RrhcMatcherService {
 public:
  explicit RrhcMatcherService(const CommandLine& command_line)
      : parameters_(command_line.parameters().match),
        settings_(command_line.settings()),
        service_(command_line),
        scans_(service_.counters()),
        matcher_(parameters_),
        map_(
            service_, [this](std::span<const TileChange> changes) { return matcher_.ApplyChanges(changes); },
            [this] {
              matcher_ = RrhcMatcher(parameters_);
              last_match_.reset();
            }) {
    service_.bus().Subscribe<critical_rays_t>(
        kCriticalRaysChannel, [this](const critical_rays_t& message) { scans_.Push(FromMessage(message)); });
    if (!parameters_.odometry) return;
    service_.bus().Subscribe<bot_core::pose_t>(
        kOdometryChannel, [this](const bot_core::pose_t& message) { odometry_.Hold(FromMessage(message)); });
  }

  void Run() {
    service_.Run([this] { return Step(); }, 20);
  }

 private:
  bool Step() {
    while (!scans_.empty() && Answer(scans_.front())) scans_.Pop();
    map_.Poll();
    return true;
  }

  /// Answers a scan if it can be answered now.
  bool Answer(const CriticalRays& scan) {
    if (last_match_ && last_match_->utime == scan.utime) {
      service_.counters().Add("resent");
      Publish(*last_match_);
      return true;
    }
    if (!MapIsCurrent()) return false;
    const std::vector<ScanMatch>& history = map_.replica().matches();
    if (!history.empty() && history.back().utime == scan.utime) {  // answered before this process was started
      Publish(history.back());
      return true;
    }
    if (WasAnswered(scan.utime)) {  // in an earlier session, say; POSE does not go back to it
      service_.counters().Add("utime_repeated");
      service_.bus().Publish(kScanMatchChannel, ToMessage(history[known_.at(scan.utime)]));
      return true;
    }
    if (const Odometry* odometry = odometry_.Find(scan.utime)) {
      Match(scan, odometry->T_odom_robot);
    } else if (parameters_.odometry && settings_.lockstep) {
      service_.counters().Add("odometry_awaited");  // it will be sent again, and the scan with it
      service_.SetState("waiting for ODOMETRY: is it on for the publisher?");
    } else {
      if (parameters_.odometry) service_.counters().Add("odometry_missing");
      Match(scan, std::nullopt);
    }
    return true;
  }

  /// Whether the map that the last match made is here, or has been waited for long enough.
  bool MapIsCurrent() {
    const MapReplica& replica = map_.replica();
    const auto now = Clock::now();
    const bool answered = !last_match_ || WasAnswered(last_match_->utime);
    if (replica.synced() && answered) return true;
    if (replica.synced() && now - last_match_time_ > kPatience) map_.Doubt();
    const bool has_map = replica.synced() || replica.version() > 0;  // whole, be it an old one
    if (settings_.lockstep || !has_map) return false;
    if (now - last_match_time_ < std::chrono::duration<double>(settings_.map_wait_s)) return false;
    service_.counters().Add("map_late");
    return true;
  }

  bool WasAnswered(std::int64_t utime) {
    const std::vector<ScanMatch>& history = map_.replica().matches();
    if (map_.replica().epoch() != known_epoch_ || history.size() < num_known_) {  // the owner began a new map
      known_.clear();
      num_known_ = 0;
      known_epoch_ = map_.replica().epoch();
    }
    for (; num_known_ < history.size(); ++num_known_) known_.emplace(history[num_known_].utime, num_known_);
    return known_.count(utime) > 0;
  }

  void Match(const CriticalRays& scan, const std::optional<Pose2>& T_odom_robot) {
    const auto start = Clock::now();
    const MapReplica& replica = map_.replica();
    std::span<const ScanMatch> history = replica.matches();
    std::vector<ScanMatch> with_unanswered;
    if (last_match_ && !WasAnswered(last_match_->utime)) {  // the map is late: the last pose counts all the same
      with_unanswered.assign(history.begin(), history.end());
      with_unanswered.push_back(*last_match_);
      history = with_unanswered;
    }
    last_match_ = matcher_.Match(scan.utime, scan.rays, scan.critical, history, MapGeometry(replica.cell_size_m()),
                                 replica.version(), T_odom_robot);
    last_match_time_ = Clock::now();
    service_.RecordLatency(start);
    service_.counters().Add("handled");
    const MatchState state = last_match_->state;
    if (state == MatchState::kLost) service_.counters().Add("lost");
    if (state == MatchState::kDegenerate) service_.counters().Add("degenerate");
    service_.SetState(state == MatchState::kLost         ? "lost"
                      : state == MatchState::kDegenerate ? "degenerate"
                                                         : "matching");
    Publish(*last_match_);
  }

  void Publish(const ScanMatch& match) {
    service_.bus().Publish(kScanMatchChannel, ToMessage(match));
    service_.bus().Publish(kPoseChannel, ToPoseMessage(match));
  }

  static constexpr auto kPatience = std::chrono::milliseconds(100);

  const MatchParameters& parameters_;
  const Settings& settings_;
  Service service_;
  ScanQueue<CriticalRays> scans_;
  HeldByUtime<Odometry, 64> odometry_;
  RrhcMatcher matcher_;
  MapFollower map_;
  std::optional<ScanMatch> last_match_;  ///< sent once more when its scan comes once more
  Clock::time_point last_match_time_{};
  std::unordered_map<std::int64_t, std::size_t> known_;  ///< of the first num_known_ answered matches, by utime
  std::size_t num_known_ = 0;
  std::int64_t known_epoch_ = 0;
};

}  // namespace
}  // namespace crsm

int main(int argc, char** argv) {
  crsm::CommandLine command_line(
      "rrhc_matcher",
      "Matches each scan to the whole map so far by random restart hill climbing: "
      "CRITICAL_RAYS, MAP_DELTA -> SCAN_MATCH, POSE.",
      {crsm::ParameterGroup::kSeed, crsm::ParameterGroup::kOdometry, crsm::ParameterGroup::kMatch},
      {"lcm_url", "channel_prefix", "lockstep", "map_wait_s", "start"});
  if (const auto exit_code = command_line.Parse(argc, argv)) return *exit_code;
  return crsm::RunMain(command_line.program(), [&] { crsm::RrhcMatcherService(command_line).Run(); });
}
