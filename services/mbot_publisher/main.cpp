// mbot_publisher: SCAN_MATCH, WHOLE_MAP -> SLAM_POSE, SLAM_MAP, in the types of the University of Michigan's mbot, so
// that its programs, its web app for one, run on our map as on that of its own SLAM.

#include <fmt/core.h>

#include <optional>
#include <utility>

#include "common/map/byte_map.hpp"
#include "services/bus/service.hpp"
#include "services/mbot_publisher/mbot_map.hpp"
#include "services/replica/map_follower.hpp"
#include "services/wire/conversions.hpp"

namespace crsm {
namespace {

constexpr const char* kMbotPoseChannel = "SLAM_POSE";
constexpr const char* kMbotMapChannel = "SLAM_MAP";

class MbotPublisher {
 public:
  explicit MbotPublisher(const CommandLine& command_line)
      : service_(command_line),
        map_follower_(service_, MapFollower::View::kWhole,
                      {[this](double cell_size_m) { map_.emplace(cell_size_m); },
                       [this](std::span<const TileChange> changes) { return Apply(changes); }}) {
    service_.bus().SubscribeToOne<scan_match_t>(kScanMatchChannel, kMatcherRole, [this](const scan_match_t& message) {
      if (std::exchange(utime_, message.utime) == message.utime) return;  // sent again
      const auto start = Clock::now();
      service_.bus().Publish(kMbotPoseChannel, ToMbotPose(FromMessage(message)));
      service_.counters().Add("poses_published");
      service_.RecordLatency(start);
    });
  }

  void Run() {
    service_.Run([this] {
      map_follower_.Poll();
      PublishMapNowAndThen();
      return true;
    });
  }

 private:
  bool Apply(std::span<const TileChange> changes) {
    return map_->Apply(changes, [](const TileChange&) {});
  }

  /// Once a second what is new, and now and then what is not: a program that starts later hears it, and those that take
  /// a silent channel for dead do not.
  void PublishMapNowAndThen() {
    constexpr auto kPause = std::chrono::seconds(1);
    constexpr auto kLongestPause = std::chrono::seconds(5);
    const auto now = Clock::now();
    if (now < next_map_) return;
    if (!std::exchange(asked_, true)) map_follower_.RequestUpdate();  // there will be more by now
    const MapReplica& replica = map_follower_.replica();
    if (!replica.synced()) return;
    asked_ = false;
    next_map_ = now + kPause;
    const std::pair newest(replica.epoch(), replica.version());
    if (!map_ || map_->empty() || (newest == published_ && now < published_at_ + kLongestPause)) return;
    published_ = newest;
    published_at_ = now;
    PublishMap(map_->ToDenseGrid());
  }

  /// In one message, as mbots have it.
  void PublishMap(const DenseGrid& grid) {
    constexpr std::size_t kMostCells = 16'000'000;  // 200 m x 200 m of 0.05 m
    if (grid.cells.size() > kMostCells) {
      return service_.Complain("map_too_large",
                               fmt::format("{}: the map has {} x {} cells, too many for one SLAM_MAP: it is not sent; "
                                           "larger cells (--cell-size-m) make it smaller",
                                           service_.name(), grid.width_cells, grid.height_cells));
    }
    service_.bus().Publish(kMbotMapChannel, ToMbotMap(utime_, grid));
    service_.counters().Add("maps_published");
    service_.SetState("publishing");
  }

  Service service_;
  std::optional<ByteMap> map_;  ///< none before the map's owner was heard
  MapFollower map_follower_;
  std::int64_t utime_ = -1;                            ///< of the last scan
  std::pair<std::int64_t, std::int64_t> published_{};  ///< epoch and version
  bool asked_ = false;                                 ///< for what is to be published next
  Clock::time_point next_map_{};
  Clock::time_point published_at_{};
};

}  // namespace
}  // namespace crsm

int main(int argc, char** argv) {
  crsm::CommandLine command_line(
      "mbot_publisher",
      "Publishes pose and map in the types of the University of Michigan's mbot: SCAN_MATCH, WHOLE_MAP -> SLAM_POSE "
      "(pose2D_t, formerly pose_xyt_t), SLAM_MAP (occupancy_grid_t).",
      crsm::FlagsOfMbotPublisher());
  if (const auto exit_code = command_line.Parse(argc, argv)) return *exit_code;
  return crsm::RunMain(command_line.program(), [&] { crsm::MbotPublisher(command_line).Run(); });
}
