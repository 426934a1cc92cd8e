// map_updater: LASER and SCAN_MATCH -> MAP_DELTA. The owner of the map: draws each matched scan into it and tells the
// replicas what changed.

#include <unordered_set>

#include "common/map_updater.hpp"
#include "services/map_updater/answers.hpp"
#include "services/runtime/conversions.hpp"
#include "services/runtime/scan_queue.hpp"
#include "services/runtime/service.hpp"

namespace crsm {
namespace {

class MapUpdaterService {
 public:
  explicit MapUpdaterService(const CommandLine& command_line)
      : settings_(command_line.settings()),
        service_(command_line),
        matches_(service_.counters()),
        updater_(command_line.parameters().scan, command_line.parameters().update) {
    Bus& bus = service_.bus();
    bus.Subscribe<bot_core::planar_lidar_t>(
        kLaserChannel, [this](const bot_core::planar_lidar_t& message) { Keep(FromMessage(message)); });
    bus.Subscribe<scan_match_t>(kScanMatchChannel,
                                [this](const scan_match_t& message) { matches_.Push(FromMessage(message)); });
    bus.Subscribe<map_request_t>(kMapRequestChannel, [this](const map_request_t& request) {
      service_.counters().Add("map_requests");
      service_.bus().Publish(kMapDeltaChannel, MakePage(request, updater_, history_));
    });
  }

  void Run() {
    service_.Run([this] {
      for (; !matches_.empty(); matches_.Pop()) Answer(matches_.front());
      return true;
    });
  }

 private:
  void Keep(LaserScan scan) {
    constexpr std::size_t kMostScans = 64;
    for (const LaserScan& kept : scans_) {
      if (kept.utime == scan.utime) return;
    }
    if (scans_.size() == kMostScans) scans_.pop_front();
    scans_.push_back(std::move(scan));
  }

  /// Every match is answered by exactly one version of the map. A match that comes again gets its answer again.
  void Answer(const ScanMatch& match) {
    const auto start = Clock::now();
    if (!history_.empty() && history_.back().utime == match.utime) {
      service_.counters().Add("resent");
      return PublishLastAnswer();
    }
    if (answered_utimes_.count(match.utime) > 0) return service_.counters().Add("utime_repeated");

    const auto scan = std::find_if(scans_.begin(), scans_.end(),
                                   [&](const LaserScan& kept) { return kept.utime == match.utime; });
    if (scan == scans_.end() && settings_.lockstep) {
      return service_.counters().Add("scan_awaited");  // it will be sent again, and the match with it
    }
    try {
      if (scan == scans_.end()) service_.counters().Add("scan_missing");
      const MapDelta delta = scan == scans_.end() ? updater_.UpdateWithoutScan() : updater_.Update(*scan, match);
      last_answer_ = MakeParts(delta, match, updater_.geometry());
    } catch (const std::invalid_argument&) {
      return service_.counters().Add("match_out_of_limits");
    }
    history_.push_back(match);
    answered_utimes_.insert(match.utime);
    if (scan != scans_.end()) scans_.erase(scans_.begin(), scan + 1);
    service_.counters().Add("handled");
    service_.SetState("mapping");
    service_.RecordLatency(start);
    PublishLastAnswer();
  }

  void PublishLastAnswer() {
    for (const map_delta_t& part : last_answer_) service_.bus().Publish(kMapDeltaChannel, part);
  }

  const Settings& settings_;
  Service service_;
  ScanQueue<ScanMatch> matches_;
  MapUpdater updater_;
  std::deque<LaserScan> scans_;  ///< whose match has not come yet, in the order in which they came
  std::vector<ScanMatch> history_;
  std::unordered_set<std::int64_t> answered_utimes_;
  std::vector<map_delta_t> last_answer_;
};

}  // namespace
}  // namespace crsm

int main(int argc, char** argv) {
  using enum crsm::ParameterGroup;
  crsm::CommandLine command_line("map_updater", "Owns the map: LASER, SCAN_MATCH -> MAP_DELTA.", {kScan, kUpdate},
                                 {"lcm_url", "channel_prefix", "lockstep"});
  if (const auto exit_code = command_line.Parse(argc, argv)) return *exit_code;
  return crsm::RunMain(command_line.program(), [&] { crsm::MapUpdaterService(command_line).Run(); });
}
