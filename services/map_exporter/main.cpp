// map_exporter: MAP_DELTA -> pictures and files. Holds a replica of the map and writes it now and then, and at the end.
// The matches wait on the disk: their number has no end.

#include <fmt/core.h>

#include <thread>

#include "common/logs/temporary_file.hpp"
#include "common/map/byte_map.hpp"
#include "common/metrics/trajectory.hpp"
#include "common/results/results.hpp"
#include "common/results/summary.hpp"
#include "services/runtime/conversions.hpp"
#include "services/runtime/map_follower.hpp"
#include "services/runtime/match_store.hpp"
#include "services/runtime/service.hpp"
#include "services/runtime/version.hpp"

namespace crsm {
namespace {

class MapExporter {
 public:
  explicit MapExporter(const CommandLine& command_line)
      : command_line_(command_line),
        service_(command_line),
        map_follower_(service_, {[this](double cell_size_m) { Begin(cell_size_m); },
                                 [this](std::span<const TileChange> changes) { return Apply(changes); },
                                 [this](const ScanMatch& match) { Add(match); }}) {
    Bus& bus = service_.bus();
    bus.SubscribeToOne<critical_rays_t>(kCriticalRaysChannel,
                                        [this](const critical_rays_t& message) { last_scan_ = FromMessage(message); });
    bus.Subscribe<service_status_t>(kServiceStatusChannel, [this](const service_status_t& status) { Keep(status); });
  }

  void Run() {
    PrepareFolder(command_line_.settings().out);
    service_.Run([this] {
      map_follower_.Poll();
      WriteNowAndThen();
      Gather();
      return true;
    });
    CatchUp();
    Write();
  }

 private:
  /// Of a few services only: the names come from the network.
  void Keep(const service_status_t& status) {
    constexpr std::size_t kMostServices = 64;
    if (statuses_.size() == kMostServices && statuses_.count(status.name) == 0) {
      return service_.counters().Add("status_ignored");
    }
    statuses_[status.name] = status;
  }

  /// Lets messages gather, none of which is urgent: to wake up for each alone costs more than to handle it. A replica
  /// that is not whole waits for each page of the map.
  void Gather() const {
    constexpr auto kGatherFor = std::chrono::milliseconds(10);
    if (map_follower_.replica().synced()) std::this_thread::sleep_for(kGatherFor);
  }

  void Begin(double cell_size_m) {
    map_.emplace(cell_size_m);
    matches_ = MatchStore();
    trajectory_text_ = TemporaryFile();
    written_version_ = 0;
  }

  void Add(const ScanMatch& match) {
    matches_.Append(match);
    std::string line;
    AppendPose({match.utime, match.T_map_laser}, line);
    trajectory_text_.Append({reinterpret_cast<const std::uint8_t*>(line.data()), line.size()});
  }

  void CopyTrajectory(const Sink& sink) const {
    std::string piece(std::size_t{1} << 16, '\0');
    for (std::uint64_t at = 0; at < trajectory_text_.size(); at += piece.size()) {
      piece.resize(std::min<std::uint64_t>(piece.size(), trajectory_text_.size() - at));
      trajectory_text_.Read(at, {reinterpret_cast<std::uint8_t*>(piece.data()), piece.size()});
      if (!sink(piece)) return;
    }
  }

  bool Apply(std::span<const TileChange> changes) {
    last_change_ = Clock::now();
    bool all_applied = true;
    for (const TileChange& change : changes) all_applied = map_->Apply(change) && all_applied;
    return all_applied;
  }

  void WriteNowAndThen() {
    const MapReplica& replica = map_follower_.replica();
    if (Clock::now() < next_write_ || !replica.synced() || replica.version() == written_version_) return;
    const auto start = Clock::now();
    try {
      Write();
      service_.SetState("exporting");
    } catch (const std::runtime_error& error) {  // the disk may have room again later
      service_.counters().Add("write_failed");
      if (service_.MakeStatus().state != error.what()) Say(fmt::format("{}: {}", service_.name(), error.what()));
      service_.SetState(error.what());
    }
    service_.RecordLatency(start);
    next_write_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                     std::chrono::duration<double>(command_line_.settings().export_period_s));
  }

  /// At the end: whatever of the map has not come yet, and the last counts of the other processes.
  void CatchUp() {
    constexpr auto kPatience = std::chrono::seconds(3);
    const auto one_status = Clock::now() + std::chrono::milliseconds(1100);
    const auto give_up = Clock::now() + 10 * kPatience;
    last_change_ = Clock::now();
    map_follower_.Doubt();
    while (Clock::now() <
           (map_follower_.replica().synced() ? one_status : std::min(last_change_ + kPatience, give_up))) {
      map_follower_.Poll();
      service_.Spin(10);
    }
    if (!map_follower_.replica().synced() && map_follower_.replica().version() > 0) {
      Say(service_.name() + ": map_updater does not answer; the newest scans may be missing");
    }
  }

  void Write() {
    const MapReplica& replica = map_follower_.replica();
    Results results;
    if (map_) results.grid = map_->ToDenseGrid();
    results.matches = matches_.Sequence();
    results.trajectory_text = [this](const Sink& sink) { CopyTrajectory(sink); };
    results.last_scan = last_scan_;
    results.summary_json = FormatSummary(MakeSummary(results));
    WriteResults(command_line_.settings().out, results);
    written_version_ = replica.version();
  }

  Summary MakeSummary(const Results& results) {
    Summary summary = Summarize(results.matches, results.grid);
    summary.version = kVersion;
    summary.parameters = ListParameters(command_line_.parameters());
    summary.map_version = map_follower_.replica().version();
    statuses_[service_.name()] = service_.MakeStatus();
    for (const auto& [name, status] : statuses_) {
      for (std::size_t i = 0; i < status.counter_name.size(); ++i) {
        summary.counts[name + "." + status.counter_name[i]] = status.counter_value[i];
      }
      summary.timings[name] = {status.latency_p50_ms, status.latency_p95_ms, status.latency_p99_ms,
                               status.latency_max_ms};
    }
    return summary;
  }

  const CommandLine& command_line_;
  Service service_;
  std::optional<ByteMap> map_;  ///< none before the map's owner was heard
  MatchStore matches_;
  TemporaryFile trajectory_text_;  ///< trajectory.tum so far
  MapFollower map_follower_;
  CriticalRays last_scan_;
  std::map<std::string, service_status_t> statuses_;
  std::int64_t written_version_ = 0;
  Clock::time_point next_write_{};
  Clock::time_point last_change_{};
};

}  // namespace
}  // namespace crsm

int main(int argc, char** argv) {
  crsm::CommandLine command_line("map_exporter",
                                 "Writes the map, the trajectory and pictures of them to a folder, now and then and at "
                                 "the end: MAP_DELTA -> map.png, map.yaml, overview.png, trajectory.tum, summary.json.",
                                 {crsm::ParameterGroup::kSeed},
                                 {"lcm_url", "channel_prefix", "out", "export_period_s"});
  if (const auto exit_code = command_line.Parse(argc, argv)) return *exit_code;
  return crsm::RunMain(command_line.program(), [&] { crsm::MapExporter(command_line).Run(); });
}
