// map_exporter: WHOLE_MAP -> pictures and files. Asks for what is new of the map now and then, and writes it, and at
// the end. The matches wait on the disk: their number has no end. What is written in a run costs the same however long
// it is.

#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include "common/logs/left_out.hpp"
#include "common/map/byte_map.hpp"
#include "common/metrics/path_sketch.hpp"
#include "common/results/results.hpp"
#include "common/results/summary.hpp"
#include "services/base/path_lock.hpp"
#include "services/base/version.hpp"
#include "services/bus/known_statuses.hpp"
#include "services/bus/service.hpp"
#include "services/diagnosis/laser_silence.hpp"
#include "services/diagnosis/lost_news.hpp"
#include "services/journal/match_store.hpp"
#include "services/map_exporter/results_writer.hpp"
#include "services/replica/map_follower.hpp"
#include "services/wire/conversions.hpp"
#include "services/wire/graph_messages.hpp"

namespace crsm {
namespace {

constexpr const char* kGone = "this folder was removed, moved or replaced: no results are written";

std::optional<std::int64_t> FindIfThere(const service_status_t& status, const char* name) {
  const auto found = std::ranges::find(status.counter_name, name);
  if (found == status.counter_name.end()) return std::nullopt;
  return status.counter_value[static_cast<std::size_t>(found - status.counter_name.begin())];
}

std::int64_t FindCounter(const service_status_t& status, const char* name) {
  return FindIfThere(status, name).value_or(0);
}

/// What a counter has grown by; one that was larger before is of a process that has ended.
std::int64_t CountSince(const service_status_t& before, const service_status_t& now, const char* name) {
  const std::int64_t num = FindCounter(now, name);
  const std::int64_t num_before = FindCounter(before, name);
  return num - (num_before > num ? 0 : num_before);
}

constexpr const char* kPublished = "published";

class MapExporter {
 public:
  explicit MapExporter(const CommandLine& command_line)
      : command_line_(command_line),
        service_(command_line),
        map_follower_(service_, MapFollower::View::kWhole,
                      {[this](double cell_size_m) { Begin(cell_size_m); },
                       [this](std::span<const TileChange> changes) { return Apply(changes); },
                       [this](const ScanMatch& match) { Add(match); }}) {
    Bus& bus = service_.bus();
    bus.SubscribeToOne<critical_rays_t>(kCriticalRaysChannel, kSelectorRole, [this](const critical_rays_t& message) {
      if (matches_.Find(message.utime)) return;  // of an earlier session, or sent again
      last_scan_ = FromMessage(message);
      statistics_.Add(last_scan_.utime, last_scan_.rays);
    });
    // Of an earlier session nobody sends other rays.
    bus.SubscribeToOne<keyframe_t>(kKeyframeChannel, kMapOwnerRole, [this](const keyframe_t& message) {
      statistics_.Add(message.utime, FromMessage(message).rays.Unpack());
    });
    bus.SubscribeToOne<scan_answer_t>(kScanAnswerChannel, kMapOwnerRole,
                                      [this](const scan_answer_t& answer) { Forget(answer); });
    bus.SubscribeToOne<changes_t>(kChangesChannel, kMapOwnerRole,
                                  [this](const changes_t& message) { changes_ = FromMessage(message); });
    bus.Subscribe<service_status_t>(kEveryServiceStatus, [this](const service_status_t& status) { Keep(status); });
  }

  void Run() {
    PrepareFolder(command_line_.settings().out);
    const PathLock lock("--out", command_line_.settings().out);
    lock_ = &lock;
    writer_.emplace(command_line_.settings().out);
    service_.Run([this] {
      map_follower_.Poll();
      WriteNowAndThen();
      Gather();
      return true;
    });
    CatchUp();
    writer_.reset();  // when it has ended
    Write();
  }

 private:
  /// Rays that came before all matches did are of a scan that was in the map already: it may be another one than that
  /// which has its utime there.
  void Forget(const scan_answer_t& answer) {
    if (answer.num_matches == 0 || matches_.Find(answer.utime)) return;
    statistics_.ForgetRays(answer.utime);
    if (last_scan_.utime == answer.utime) last_scan_ = CriticalRays();
  }

  void Keep(const service_status_t& status) {
    if (!MayKeepStatus(statuses_, status.name, "the summary", service_)) return;
    service_status_t& kept = statuses_[status.name];
    for (auto& [counter, total] : totals_) total += CountSince(kept, status, counter.c_str());
    if (const auto before = FindIfThere(status, kScansBefore)) {
      scans_before_ = std::min(*before, scans_before_.value_or(*before));
    }
    const std::int64_t num_left_out = std::max(kept.num_left_out, status.num_left_out);
    kept = status;
    kept.num_left_out = num_left_out;  // who says less later, takes nothing back
    if (status.name == "fleet_mapper") statistics_.BeOfKeyframes();
    const bool is_owner = status.name == "map_updater" || status.name == "fleet_mapper";
    if (is_owner) last_change_ = Clock::now();  // it is there, and may wait for a loop closer
  }

  /// Lets messages gather, none of which is urgent: to wake up for each alone costs more than to handle it. A replica
  /// that is not whole waits for each page of the map.
  void Gather() const {
    constexpr auto kGatherFor = std::chrono::milliseconds(10);
    if (map_follower_.replica().synced()) std::this_thread::sleep_for(kGatherFor);
  }

  void Begin(double cell_size_m) {
    if (piece_) {
      *piece_ = OtherPiece();
      piece_->map.emplace(cell_size_m);
      return;
    }
    statistics_.ForgetMatches();
    map_.emplace(cell_size_m);
    map_begun_ = true;
    changed_tiles_.clear();
    matches_ = MatchStore();
    trajectory_text_ = std::make_shared<TrajectoryText>();
    path_ = PathSketch();
    written_version_ = 0;
  }

  void Add(const ScanMatch& match) {
    if (piece_) return piece_->matches.Append(match);
    matches_.Append(match);
    statistics_.Add(match);
    if (!match.floating) trajectory_text_->Add(match);
    path_.Add(match);
  }

  bool Apply(std::span<const TileChange> changes) {
    last_change_ = Clock::now();
    if (piece_) return piece_->map->Apply(changes, [](const TileChange&) {});
    return map_->Apply(changes, [this](const TileChange& change) { changed_tiles_.insert(change.index); });
  }

  void WriteNowAndThen() {
    constexpr double kNothingNew_s = 0.5;
    const MapReplica& replica = map_follower_.replica();
    if (const auto outcome = writer_->TakeOutcome()) NoteOutcome(*outcome);
    const auto now = Clock::now();
    if (now < next_write_ || writer_->busy()) return;
    if (!std::exchange(asked_, true)) map_follower_.RequestUpdate();  // there will be more by now
    if (!replica.synced()) return;
    was_whole_ = true;
    asked_ = false;
    const bool is_new = replica.version() != written_version_ || written_marks_ != replica.marks();
    const double period_s = command_line_.settings().export_period_s;
    Pause(now, is_new ? period_s : std::min(period_s, kNothingNew_s));
    if (!is_new) return;
    if (!lock_->IsInPlace()) return NoteGone();
    written_marks_ = replica.marks();
    writer_->Start(MakeSnapshot());
    service_.RecordLatency(now);  // so long messages waited
  }

  void Pause(Clock::time_point since, double pause_s) {
    const auto pause = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(pause_s));
    next_write_ = std::max(next_write_, since + pause);
  }

  /// A large map is written more seldom: to look at it in between is not worth a core.
  void NoteOutcome(const ResultsWriter::Outcome& outcome) {
    constexpr double kShareOfCore = 0.01;
    constexpr double kLongest_s = 60.0;
    Pause(Clock::now(), std::min(outcome.cpu_s / kShareOfCore, kLongest_s));
    if (outcome.error.empty()) {
      if (outcome.text == trajectory_text_) written_version_ = outcome.version;
      return service_.SetState("exporting");
    }
    written_marks_.reset();
    service_.counters().Add("write_failed");
    if (service_.MakeStatus().state != outcome.error) Say(fmt::format("{}: {}", service_.name(), outcome.error));
    service_.SetState(outcome.error);
  }

  /// What has come in the place of the folder is not ours to write to.
  void NoteGone() {
    const std::string why = fmt::format("--out {}: {}", command_line_.settings().out, kGone);
    service_.Complain("write_failed", fmt::format("{}: {}", service_.name(), why));
    service_.SetState(why);
  }

  Snapshot MakeSnapshot() {
    Snapshot snapshot;
    snapshot.version = map_follower_.replica().version();
    if (std::exchange(map_begun_, false)) snapshot.begun_cell_size_m = map_->geometry().cell_size_m();
    for (const TileIndex index : std::exchange(changed_tiles_, {})) {
      if (const ByteMap::Tile* tile = map_->tiles().Find(index)) snapshot.tiles.emplace_back(index, tile->cells);
    }
    snapshot.path = path_.Matches();
    snapshot.text = trajectory_text_;
    snapshot.last_scan = last_scan_;
    snapshot.loops = map_follower_.replica().loops();
    snapshot.pieces = map_follower_.replica().pieces().value_or(MapPieces());
    snapshot.marks = map_follower_.replica().marks();
    snapshot.summary = Summarize();
    snapshot.summary.ended = false;
    return snapshot;
  }

  /// At the end: whatever of the map has not come yet, and the last counts of the other processes.
  void CatchUp() {
    constexpr auto kPatience = std::chrono::seconds(3);
    constexpr auto kOneStatus = std::chrono::milliseconds(1100);
    constexpr auto kHurried = std::chrono::milliseconds(300);
    auto give_up = Clock::now() + 10 * kPatience;
    last_change_ = Clock::now();
    map_follower_.AwaitSettled();
    std::optional<Clock::time_point> whole_since;
    while (Clock::now() < (whole_since ? *whole_since + kOneStatus : std::min(last_change_ + kPatience, give_up))) {
      if (HurryRequested() && !map_follower_.replica().synced() && !std::exchange(is_hurried_, true)) {
        map_follower_.AwaitNoLonger();
        if (!was_whole_) give_up = Clock::now() + kHurried;
      }
      map_follower_.Poll();
      service_.Spin(10);
      if (!whole_since && map_follower_.replica().synced()) whole_since = Clock::now();
    }
    if (!map_follower_.replica().synced() && map_follower_.replica().version() > 0) {
      Say(service_.name() + ": map_updater does not answer; the newest scans may be missing");
    }
  }

  /// At the end: everything once more, from all matches. Where no map ever came, results that are there already are
  /// those of an earlier run, and stay.
  void Write() {
    const std::filesystem::path out = command_line_.settings().out;
    if (!lock_->IsInPlace()) {
      NoteGone();
      throw std::runtime_error(service_.MakeStatus().state);
    }
    if (is_hurried_ && !was_whole_ && !map_follower_.replica().synced()) {
      return Say(
          fmt::format("{}: the map of the earlier run was not there yet: no results are written, and the journal "
                      "has all scans",
                      service_.name()));
    }
    if (is_hurried_) {
      Say(service_.name() + ": loops are still searched: the results are without those that are not found yet");
    }
    if (!map_ && std::filesystem::exists(out / "map.png")) {
      return Say(fmt::format("{}: no map came: the results in {} stay as they were", service_.name(), out.string()));
    }
    Results results;
    if (map_) results.grid = map_->ToDenseGrid();
    results.matches = matches_.Sequence();
    if (trajectory_text_) {
      results.trajectory_text = [this](const Sink& sink) {
        trajectory_text_->Copy(0, trajectory_text_->num_bytes(), sink);
      };
    }
    results.last_scan = last_scan_;
    results.loops = map_follower_.replica().loops();
    const MapPieces pieces = map_follower_.replica().pieces().value_or(MapPieces());
    results.pieces = pieces;
    results.summary = Summarize();
    results.summary->explored_area_m2 = ComputeExploredArea(results.grid);
    results.name = NameOfRun(out);
    results.marks = map_follower_.replica().marks();
    results.team = command_line_.settings().team;
    WriteResults(command_line_.settings().out, results);
    WritePieces(pieces);
  }

  /// At the end: the pieces that are not joined with the map, one after the other. A piece that does not come is left
  /// out.
  void WritePieces(const MapPieces& pieces) {
    RemovePieces(command_line_.settings().out);
    for (const int number : pieces.OthersWithMap()) {
      if (!Fetch(number)) {
        Say(fmt::format("{}: map_updater does not answer; pieces/{} and those behind it are missing", service_.name(),
                        number));
        return;
      }
      const DenseGrid grid = piece_->map ? piece_->map->ToDenseGrid() : DenseGrid();
      WritePiece(command_line_.settings().out, number, grid, piece_->matches.Sequence());
    }
  }

  /// Asks for a piece. Whether it came.
  bool Fetch(int number) {
    constexpr auto kPatience = std::chrono::seconds(3);
    const auto give_up = Clock::now() + 10 * kPatience;
    piece_.emplace();
    map_follower_.TurnTo(number);
    last_change_ = Clock::now();
    while (!map_follower_.replica().synced() && Clock::now() < std::min(last_change_ + kPatience, give_up)) {
      map_follower_.Poll();
      service_.Spin(10);
    }
    return map_follower_.replica().synced();
  }

  /// Scans that were never tried: of a log, or of another driver.
  std::int64_t CountLeftOut() const {
    std::int64_t num = 0;
    for (const auto& [name, status] : statuses_) num += status.num_left_out;
    return num;
  }

  /// Of these, those that a process was too slow for.
  std::int64_t CountDropped() const {
    std::int64_t num = 0;
    for (const auto& [name, status] : statuses_) num += FindCounter(status, kDroppedOverload);
    return num;
  }

  /// Scans that our publisher has sent and of which nobody knows what became: a process that was stopped or killed has
  /// not heard them, say. Known when the publisher has ended, and not in lockstep, where they come again.
  std::int64_t CountUnheard(std::int64_t num_scans, std::int64_t num_left_out) const {
    const auto publisher = statuses_.find("laser_publisher");
    const bool has_ended = publisher != statuses_.end() && publisher->second.state == kPublisherFinished;
    if (!has_ended || !scans_before_ || IsInLockstep()) return 0;
    std::int64_t num_known = num_scans - *scans_before_ + num_left_out - publisher->second.num_left_out;
    const auto matcher = statuses_.find("rrhc_matcher");
    if (matcher != statuses_.end()) num_known += FindCounter(matcher->second, "utime_repeated");
    return std::max<std::int64_t>(0, totals_.at(kPublished) - num_known);
  }

  bool IsInLockstep() const {
    return std::ranges::any_of(statuses_, [](const auto& named) {
      const service_status_t& status = named.second;
      const auto found = std::ranges::find(status.parameter_name, "lockstep");
      return found != status.parameter_name.end() &&
             status.parameter_value[static_cast<std::size_t>(found - status.parameter_name.begin())] == "true";
    });
  }

  /// All but the explored area.
  Summary Summarize() {
    Summary summary;
    summary.values = statistics_.values();
    const std::int64_t num_unheard = CountUnheard(summary.values.counts.scans(), CountLeftOut());
    summary.left_out = CountLeftOut() + num_unheard;
    if (num_unheard > 0) summary.counts["map_exporter.unheard"] = num_unheard;
    summary.version = kVersion;
    summary.origin = {command_line_.settings().made_from, FormatUtc(UtimeNow())};
    summary.wall_s = std::chrono::duration<double>(Clock::now() - begun_).count();
    summary.map_version = map_follower_.replica().version();
    const ByteMap no_map(1.0);
    summary.pieces = map_follower_.replica().pieces();
    summary.wheels = map_follower_.replica().tracking().wheels().Learned();
    summary.changes = changes_;
    Verdict verdict = Judge(statistics_, map_ ? *map_ : no_map, summary.pieces.value_or(MapPieces()));
    if (summary.wheels) JudgeWheels(*summary.wheels, verdict);
    JudgeLeftOut({summary.left_out, CountDropped() + num_unheard}, verdict);
    if (is_hurried_) JudgeUnsearched(verdict);
    if (verdict.values.finished_map) JudgeToldStarts(totals_.at(kStartTold), verdict);
    summary.verdict = std::move(verdict);
    statuses_[service_.name()] = service_.MakeStatus();
    for (const auto& [name, status] : statuses_) {
      for (std::size_t i = 0; i < status.counter_name.size(); ++i) {
        summary.counts[name + "." + status.counter_name[i]] = status.counter_value[i];
      }
      summary.timings[name] = {status.latency_p50_ms, status.latency_p95_ms, status.latency_p99_ms,
                               status.latency_max_ms};
      NamedValues& parameters = summary.parameters[name];
      for (std::size_t i = 0; i < status.parameter_name.size(); ++i) {
        const std::string& key = status.parameter_name[i];
        if (key == kIdentityParameter) {
          summary.identity = status.parameter_value[i];
          continue;
        }
        parameters.emplace_back(key, ReadValue(key, status.parameter_value[i]));
      }
    }
    return summary;
  }

  /// A piece that is not joined with the map.
  struct OtherPiece {
    std::optional<ByteMap> map;
    MatchStore matches;
  };

  const CommandLine& command_line_;
  Service service_;
  std::optional<OtherPiece> piece_;  ///< that is asked for, at the end
  std::optional<ByteMap> map_;       ///< none before the map's owner was heard
  MatchStore matches_;
  std::shared_ptr<TrajectoryText> trajectory_text_;  ///< of the matches that do not float
  PathSketch path_;                                  ///< of the matches
  bool map_begun_ = false;                           ///< since the last snapshot
  std::set<TileIndex> changed_tiles_;                ///< since the last snapshot
  const PathLock* lock_ = nullptr;                   ///< on the folder, from the beginning of Run on
  std::optional<ResultsWriter> writer_;
  RunStatistics statistics_;
  MapFollower map_follower_;
  CriticalRays last_scan_;
  std::optional<std::vector<MapChange>> changes_;  ///< since the finished map was made, where there is one
  std::map<std::string, service_status_t> statuses_;
  bool was_whole_ = false;   ///< the map has come once: there are results of this run
  bool is_hurried_ = false;  ///< the end is not to wait for loops
  /// Of counters, also of processes that have ended since.
  std::map<std::string, std::int64_t> totals_{{kStartTold, 0}, {kPublished, 0}};
  std::optional<std::int64_t> scans_before_;  ///< this run, in the map
  std::int64_t written_version_ = 0;
  std::optional<std::vector<PlacedMark>> written_marks_{std::in_place};
  bool asked_ = false;  ///< for what is to be written next
  const Clock::time_point begun_ = Clock::now();
  Clock::time_point next_write_{};
  Clock::time_point last_change_{};
};

}  // namespace
}  // namespace crsm

int main(int argc, char** argv) {
  crsm::CommandLine command_line("map_exporter",
                                 "Writes the map, the trajectory and pictures to a folder, regularly and at the end: "
                                 "WHOLE_MAP -> map.png, map.yaml, overview.png, trajectory.tum, summary.json.",
                                 crsm::FlagsOfExporter());
  if (const auto exit_code = command_line.Parse(argc, argv)) return *exit_code;
  return crsm::RunMain(command_line.program(), [&] { crsm::MapExporter(command_line).Run(); });
}
