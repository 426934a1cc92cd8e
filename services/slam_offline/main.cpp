// slam_offline: logs or simulated worlds -> map and trajectory, in one process without messages. The oracle that the
// processes are tested against.

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <sstream>

#include "common/diagnosis/changes.hpp"
#include "common/diagnosis/laser_judge.hpp"
#include "common/graph/g2o.hpp"
#include "common/logs/left_out.hpp"
#include "common/logs/unique_utimes.hpp"
#include "common/match/match_constants.hpp"
#include "common/math/format_number.hpp"
#include "common/results/read_results.hpp"
#include "common/results/results.hpp"
#include "common/results/summary.hpp"
#include "common/scan/deskew.hpp"
#include "common/slam.hpp"
#include "services/base/progress.hpp"
#include "services/base/usage_error.hpp"
#include "services/base/version.hpp"
#include "services/bus/service.hpp"
#include "services/diagnosis/break_news.hpp"
#include "services/diagnosis/changes_over.hpp"
#include "services/diagnosis/lost_news.hpp"
#include "services/journal/earlier_results.hpp"
#include "services/journal/earlier_scans.hpp"
#include "services/journal/journal.hpp"
#include "services/journal/map_parameters.hpp"
#include "services/journal/match_store.hpp"
#include "services/journal/results_lock.hpp"
#include "services/slam_offline/take_marks.hpp"
#include "services/sources/devices/live_laser.hpp"
#include "services/sources/open_laser_source.hpp"
#include "services/sources/study_laser.hpp"

namespace crsm {
namespace {

/// What a log brought.
struct Session {
  std::string path;
  std::string log;               ///< as it is called
  std::int64_t first_match = 0;  ///< of Run::matches
  std::int64_t num_matches = 0;
  std::int64_t num_repeated = 0;  ///< scans that were in the map already
};

/// What a run has come to so far.
struct Run {
  explicit Run(const Parameters& parameters) : slam(parameters) {}

  void Restore(const CriticalRays* scan, const ScanMatch& match) {
    slam.Restore(scan, match);
    Add(match);
    earlier.Add(scan, match);
    utimes.AddTaken(match.utime);
    if (!scan) return;
    last_scan = *scan;
    statistics.Add(scan->utime, scan->rays);
  }

  void Add(const ScanMatch& match) {
    matches.Append(match);
    last_match = match;
    statistics.Add(match);
  }

  /// Whether there were scans in the map before the first log.
  bool IsResumed() const { return !sessions.empty() && sessions.front().first_match > 0; }

  /// All of them, by what is known at the end.
  MatchSequence Matches() const {
    return MatchSequence([this](const MatchSequence::Visit& visit) {
      std::int64_t scan = 0;
      matches.Sequence().ForEach([&](const ScanMatch& match) { visit(ByAllThatIsKnown(scan++, match)); });
    });
  }

  /// One of them, by its number from 0.
  ScanMatch Match(std::int64_t scan) const { return ByAllThatIsKnown(scan, matches.At(scan)); }

  ScanMatch ByAllThatIsKnown(std::int64_t scan, const ScanMatch& match) const {
    return is_final ? slam.mapper().BestMatch(scan, match) : match;
  }

  Slam slam;
  MatchStore matches;  ///< as they were found
  MarkBook marks;
  std::optional<ScanMatch> last_match;
  bool is_final = false;  ///< all loops are closed: poses follow the graph
  std::vector<Session> sessions;
  EarlierScans earlier;  ///< those of an earlier run whose map goes on
  UniqueUtimes utimes;   ///< of the scans of all logs, and of those
  RunStatistics statistics;
  CriticalRays last_scan;
  Trajectory truth;
  std::string made_from;  ///< as of RunOrigin
  Clock::time_point begun = Clock::now();
  std::map<std::string, std::int64_t> counts;  ///< of all logs
  std::int64_t num_left_out = 0;               ///< scans of all logs that could not be used
  Latency latency;
  LostNews lost_news;
  std::optional<ChangeFinder> changes;  ///< since the finished map was made, where there is one
};

void Keep(const std::vector<GraphUpdate>& updates, const Run& run, Journal& journal) {
  const auto UtimeOf = [&](KeyframeId keyframe) { return run.slam.graph().keyframe(keyframe).utime; };
  for (const GraphUpdate& update : updates) journal.Append(update, UtimeOf(update.keyframe));
  const Mapper& mapper = run.slam.mapper();
  if (const auto searched = mapper.searched()) {
    journal.AppendSearched(*searched, mapper.last_update(), UtimeOf(*searched));
  }
}

void SayNotice(const CommandLine& command_line, const std::string& notice) {
  if (!notice.empty()) Say(fmt::format("{}: {}", command_line.program(), notice));
}

void SayNews(const CommandLine& command_line, const Run& run, BreakNews& news) {
  for (const std::string& line : news.Look(run.slam.mapper(), Clock::now())) {
    Say(fmt::format("{}: {}", command_line.program(), line));
  }
}

void SayIfLost(const CommandLine& command_line, Run& run) {
  const auto line = run.lost_news.Add(*run.last_match, Clock::now());
  if (line) Say(fmt::format("{}: {}", command_line.program(), *line));
}

/// Ends the process while loops are searched in the map of an earlier run. What was searched is in the journal, and
/// need not be searched once more. The search at one keyframe, which may take long, is not waited for.
[[noreturn]] void LeaveSearch(const CommandLine& command_line, const std::string& resume, const Run& run,
                              std::unique_ptr<Journal> journal) {
  const KeyframeGraph& graph = run.slam.graph();
  const auto searched = run.slam.mapper().searched();
  const auto num_keyframes = std::ssize(graph.ids());
  const std::int64_t num_left = searched ? graph.CountAfter(*searched) : num_keyframes;
  journal.reset();
  Say(fmt::format(
      "{}: stopped while the map of {} was made again: {} scans are read, and loops searched at {} of their {} "
      "keyframes, which is kept; there is nothing new to write",
      command_line.program(), resume, run.matches.size(), num_keyframes - num_left, num_keyframes));
  std::_Exit(EXIT_SUCCESS);
}

/// Makes the map of an earlier run, where there is one to begin with, and opens the journal of this one, for which
/// there is room.
std::unique_ptr<Journal> Begin(const CommandLine& command_line, const std::string& resume, Run& run) {
  const Settings& settings = command_line.settings();
  JournalSubject subject{!settings.localize.empty(), ListMapParameters(command_line.parameters())};
  const OnDamage on_damage = settings.until_damage ? OnDamage::kTakeWhatIsBefore : OnDamage::kRefuse;
  std::int64_t epoch = 0;
  VisitJournal restore;
  restore.match = [&](const CriticalRays* scan, const ScanMatch& match) { run.Restore(scan, match); };
  restore.update = [&](const GraphUpdate& update) { return run.slam.Restore(update); };
  restore.searched = [&](KeyframeId keyframe) { return run.slam.RestoreSearched(keyframe); };
  restore.head = [&epoch](const JournalHead& head) { epoch = head.epoch; };
  restore.mark = [&](const FixedMark& mark) { return run.marks.Add(mark, run.slam.mapper()); };
  std::optional<EndsAtOnce> ends_at_once(
      std::in_place, fmt::format("{}: stopped while the map of {} was made again: there is nothing new to write",
                                 command_line.program(), resume.empty() ? settings.localize : resume));
  if (!resume.empty()) {
    auto journal = std::make_unique<Journal>(JournalFolder(settings.out), subject, on_damage, restore);
    ends_at_once.reset();
    SayNotice(command_line, journal->notice());
    Keep(run.slam.AwaitLoops(StopRequested), run, *journal);
    if (StopRequested()) LeaveSearch(command_line, resume, run, std::move(journal));
    run.utimes.BeginDrive();
    run.slam.Resume(command_line.parameters().match.start);
    Say(fmt::format("{}: continues after {} from {}", command_line.program(), FormatCount(run.matches.size(), "scan"),
                    resume));
    return journal;
  }
  if (subject.finished_map) {
    SayNotice(command_line,
              ReadJournal(JournalFolder(settings.localize), {false, subject.parameters}, on_damage, restore));
    subject.finished_map_name = NameMap(epoch, run.matches.size());
    run.slam.FinishMap();
    run.changes.emplace(MakeChangeFinder(run.slam.mapper(), run.slam.map()));
    if (run.slam.map().empty()) {
      throw std::runtime_error(fmt::format("--localize {}: its map is empty", settings.localize));
    }
    Say(fmt::format("{}: localises on the finished map of {} from {}", command_line.program(),
                    FormatCount(run.matches.size(), "scan"), settings.localize));
    run.matches = MatchStore();
    run.last_match.reset();
    run.earlier = EarlierScans();
    run.utimes = UniqueUtimes();
    run.statistics = RunStatistics();
  }
  return std::make_unique<Journal>(JournalFolder(settings.out), subject);
}

void SayOfAnotherDrive(const CommandLine& command_line, const Session& session) {
  Say(
      fmt::format("{}: {}: the map has other scans of the same times: another drive, whose times are moved by some "
                  "microseconds",
                  command_line.program(), session.log));
}

/// What of the log is not in the map, or not as it was meant.
void SayWhatWasLeftOut(const CommandLine& command_line, const Session& session, const LaserSource& source) {
  const std::string& program = command_line.program();
  for (const std::string& line : DescribeComplaints(session.log, source)) Say(fmt::format("{}: {}", program, line));
  if (command_line.settings().odometry) {
    for (const std::string& line : DescribeOdometry(session.log, source)) Say(fmt::format("{}: {}", program, line));
  }
  if (session.num_repeated > 0) {
    Say(fmt::format("{}: {}: {} scans were in the map already and were skipped (utime_repeated)", program, session.log,
                    session.num_repeated));
  }
  const std::string cut = DescribeCut(session.log, source);
  if (!cut.empty()) Say(fmt::format("{}: {}", program, cut));
}

/// What was seen belongs elsewhere where loops were closed: map, poses and what is said of them follow the graph.
Results Correct(Run& run, Summary& summary) {
  const Slam::Outcome outcome = run.slam.Finalize({});
  run.is_final = true;
  run.statistics.ForgetMatches();
  run.Matches().ForEach([&](const ScanMatch& match) { run.statistics.Add(match); });
  Results results;
  results.grid = outcome.map.ToDenseGrid();
  results.loops = outcome.loops;
  results.graph_g2o = FormatG2o(outcome.graph.MakePoseGraph());
  results.pieces = run.slam.mapper().FindPiecesAndError();
  summary.pieces = results.pieces;
  summary.verdict = Judge(run.statistics, outcome.map, results.pieces);
  return results;
}

Results Finalize(Run& run, Summary& summary) {
  if (run.slam.closes_loops()) return Correct(run, summary);
  Results results;
  results.grid = run.slam.map().ToDenseGrid();
  summary.verdict = Judge(run.statistics, run.slam.map());
  return results;
}

/// Writes the pieces that are not joined with the map, after Finalize.
void WritePieces(const std::string& out, const Run& run, const MapPieces& pieces) {
  RemovePieces(out);
  for (const int number : pieces.OthersWithMap()) {
    const MatchSequence matches([&](const MatchSequence::Visit& visit) {
      for (const auto& [first, end] : run.slam.mapper().FindScans(run.slam.mapper().FindComponent(number))) {
        for (std::int64_t scan = first; scan < end; ++scan) visit(run.Match(scan));
      }
    });
    WritePiece(out, number, run.slam.DrawPiece(number).ToDenseGrid(), matches);
  }
}

/// Which logs have a place on the map, where it has others too: the poses of the rest are not known there.
void PrintSessions(const Run& run) {
  if (run.sessions.size() < 2 && !run.IsResumed()) return;
  for (const Session& session : run.sessions) {
    if (session.num_matches == 0) {
      fmt::print("{}: none of its scans is new\n", session.log);
      continue;
    }
    ScanCounts counts;
    for (std::int64_t scan = session.first_match; scan < session.first_match + session.num_matches; ++scan)
      counts.Add(run.Match(scan));
    fmt::print("{}: {} of {} scans are on the map\n", session.log, counts.on_map, session.num_matches);
  }
}

/// What a run came to.
struct Outcome {
  Trust trust;
  double changed_m2;  ///< the largest thing that has come or gone
  bool is_mapped;     ///< whether there is a map
};

/// Writes the results, and says whether the map is to be trusted. identity: of the map, as of its journal.
Outcome WriteRun(const CommandLine& command_line, std::int64_t identity, Run& run) {
  Summary summary;
  Results results = Finalize(run, summary);
  results.matches = run.Matches();
  results.last_scan = run.last_scan;
  results.marks = run.marks.Place(run.slam.mapper());
  results.team = command_line.settings().team;
  results.truth = run.truth;
  summary.values = run.statistics.values();
  summary.left_out = run.num_left_out;
  summary.explored_area_m2 = ComputeExploredArea(results.grid);
  summary.version = kVersion;
  summary.identity = FormatIdentity(identity);
  summary.origin = {run.made_from, FormatUtc(UtimeNow())};
  summary.parameters[command_line.program()] = command_line.UsedValues();
  summary.map_version = run.slam.map_version();
  summary.wheels = run.slam.tracking().wheels().Learned();
  summary.wall_s = std::chrono::duration<double>(Clock::now() - run.begun).count();
  summary.counts = run.counts;
  if (run.slam.closes_loops()) summary.counts["keyframes_searched"] = run.slam.num_searched();
  summary.counts["scan_cut"] = run.slam.num_scans_cut();
  summary.timings[command_line.program()] = {run.latency.Percentile(0.5), run.latency.Percentile(0.95),
                                             run.latency.Percentile(0.99), run.latency.max_ms()};
  Verdict& verdict = *summary.verdict;
  if (summary.wheels) JudgeWheels(*summary.wheels, verdict);
  JudgeLeftOut({run.num_left_out}, verdict);
  if (run.changes) summary.changes = run.changes->Find();
  results.summary = summary;
  const std::string& out = command_line.settings().out;
  results.name = NameOfRun(out);
  WriteResults(out, results);
  WritePieces(out, run, results.pieces);
  fmt::print("{}, map of {:.0f} m2 in {}\n", FormatCount(summary.values.counts.scans(), "scan"),
             summary.explored_area_m2, out);
  if (const auto& pieces = summary.pieces) {
    fmt::print("{} closed between {}, {} rejected\n", FormatCount(pieces->num_closed, "loop"),
               FormatCount(pieces->num_keyframes, "keyframe"), pieces->num_rejected);
  }
  PrintSessions(run);
  const std::vector<MapChange> changes = summary.changes.value_or(std::vector<MapChange>());
  if (summary.changes) {
    for (const std::string& line : FormatChanges(changes)) fmt::print("{}\n", line);
  }
  if (!results.marks.empty())
    fmt::print("{} in marks.csv and marks.geojson\n", FormatCount(std::ssize(results.marks), "place"));
  for (const std::string& line : FormatVerdict(verdict)) fmt::print("{}\n", line);
  const bool is_mapped = summary.explored_area_m2 > 0.0 || StopRequested();
  if (!is_mapped) {
    Say(fmt::format("{}: no scan was mapped: {}", command_line.program(), fmt::join(verdict.warnings, "; ")));
  }
  return {verdict.trust, LargestArea(changes), is_mapped};
}

/// What one robot recorded.
struct Drive {
  std::string log;
  std::string channel;  ///< of its laser; empty: the only one
};

/// Of each log and each of the channels that --laser-channel names, "A,B".
std::vector<Drive> ListDrives(const std::vector<std::string>& logs, const std::string& channels) {
  std::vector<Drive> drives;
  for (const std::string& log : logs) {
    std::istringstream names(channels);
    std::string channel;
    do {
      std::getline(names, channel, ',');
      drives.push_back({log, channel});
    } while (names.good());
  }
  return drives;
}

std::unique_ptr<LaserSource> Open(CommandLine& command_line, const std::vector<Drive>& drives, std::size_t number) {
  command_line.ChooseLaserChannel(drives[number].channel);
  SourceOptions options = SourceOptionsOf(command_line);
  options.seed += number;  // a world that is simulated twice has other noise the second time, as on another day
  return OpenLaserSource(drives[number].log, options);
}

/// What cannot be meant for several logs.
void CheckSeveral(const CommandLine& command_line, const std::vector<std::string>& logs) {
  const Settings& settings = command_line.settings();
  if (settings.localize.empty() && !command_line.parameters().loops.loops) {
    throw UsageError("several logs are joined by loops: remove --no-loops, or give one log");
  }
  if (!settings.localize.empty() && !settings.start.empty()) {
    throw UsageError("--start: is the start of one log: give one log, or remove it");
  }
  for (std::size_t i = 0; i < logs.size(); ++i) {
    if (ParseDevice(logs[i])) throw UsageError(fmt::format("{}: a laser can only be mapped alone", logs[i]));
    const auto IsSame = [&](const std::string& other) {
      std::error_code error;
      return std::filesystem::equivalent(other, logs[i], error);
    };
    if (std::any_of(logs.begin(), logs.begin() + static_cast<std::ptrdiff_t>(i), IsSame)) {
      throw UsageError(fmt::format("{}: is given twice", logs[i]));
    }
  }
}

/// Throws if one of several logs cannot be mapped, before any of them is.
void CheckDrives(CommandLine& command_line, const std::vector<Drive>& drives) {
  for (std::size_t i = 0; i < drives.size(); ++i) {
    const auto source = Open(command_line, drives, i);
    if (!source->Next()) ThrowNoScans(drives[i].log, *source);
  }
}

void MapScan(const LaserScan& scan, const std::optional<Pose2>& T_odom_robot, Run& run, Journal& journal) {
  const auto start = Clock::now();
  Slam::Step step = run.slam.Process(scan, T_odom_robot);
  run.latency.Record(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
  journal.Append(step.drawn ? &step.scan : nullptr, step.match);
  Keep(step.updates, run, journal);
  run.statistics.Add(scan.utime, step.scan.rays);
  run.Add(step.match);
  if (run.changes) run.changes->Add(Deskew(step.scan.rays, step.match.twist), step.match);
  run.last_scan = std::move(step.scan);
}

/// Whether a log whose first scan has this utime is the next part of the drive before it: recorders split long logs.
bool GoesOn(const Run& run, std::int64_t utime) {
  const double gap_max_s = MatchConstants::Break{}.gap_max_s;  // of a trajectory
  if (!run.last_match) return false;
  const std::int64_t last = run.last_match->utime;
  return utime > last && static_cast<double>(utime - last) < gap_max_s * 1e6;
}

/// One log of several. show: called after each scan. Throws std::runtime_error if the log has no scan.
void MapLog(const CommandLine& command_line, LaserSource& source, Run& run, Journal& journal,
            const std::function<void()>& show) {
  const ScanParameters& parameters = command_line.parameters().scan;
  Session& session = run.sessions.back();
  session.first_match = run.matches.size();
  constexpr std::int64_t kToFindOut = 5;  // scans: a log that does not go on where the last one ended is lost at once
  bool is_first_scan = run.sessions.size() > 1;  // the first log goes on where an earlier run ended
  bool goes_on = false;
  const ScanCorrection correction =
      run.sessions.size() > 1 ? StudyFurtherLog(session.path, command_line) : ScanCorrection();
  LaserJudge judge(parameters);
  run.earlier.BeginLog();
  bool has_scans = false;
  while (auto scan = source.Next()) {
    if (StopRequested()) break;
    has_scans = true;
    *scan = correction.Apply(*std::move(scan));
    if (is_first_scan && GoesOn(run, scan->utime)) {
      Say(fmt::format("{}: {}: goes on where the log before it ends: the same drive", command_line.program(),
                      session.log));
      is_first_scan = false;
      goes_on = true;
    }
    if (is_first_scan) run.utimes.BeginDrive();
    for (const std::string& complaint : judge.Look(*scan)) {
      Say(fmt::format("{}: {}: {}", command_line.program(), session.log, complaint));
    }
    const bool was_another_drive = run.earlier.is_another_drive();
    const bool is_in_map = run.IsResumed() && run.earlier.Has(scan->utime, FindValidRays(*scan, parameters));
    if (!was_another_drive && run.earlier.is_another_drive()) SayOfAnotherDrive(command_line, session);
    const auto utime = is_in_map ? std::nullopt : run.utimes.Add(scan->utime);
    if (utime) {
      scan->utime = *utime;
      if (is_first_scan) run.slam.BeginDrive();
      MapScan(*scan, command_line.settings().odometry ? source.Odometry() : std::nullopt, run, journal);
      SayIfLost(command_line, run);
      goes_on = goes_on && run.matches.size() - session.first_match < kToFindOut;
      if (goes_on && run.last_match->state == MatchState::kLost) {
        Say(fmt::format("{}: {}: is not where the log before it ends: a drive of its own", command_line.program(),
                        session.log));
        run.slam.BeginDrive();
        goes_on = false;
      }
    } else {
      ++session.num_repeated;
    }
    is_first_scan = false;
    if (const auto T_map_laser = source.TruePose()) run.truth.push_back({scan->utime, *T_map_laser});
    show();
  }
  if (!has_scans && !StopRequested()) ThrowNoScans(session.log, source);
  session.num_matches = run.matches.size() - session.first_match;
  SayWhatWasLeftOut(command_line, session, source);
  run.num_left_out += CountLeftOut(source.Counts());
  for (const auto& [name, count] : source.Counts()) run.counts[name] += count;
  run.counts["utime_repeated"] += session.num_repeated;
}

/// Says whether the map is to be trusted. A log after the first one is a session of its own.
Outcome MapLogs(CommandLine& command_line, const std::vector<std::string>& logs, const EarlierResults& earlier,
                const MarksOfFile& marks) {
  const Settings& settings = command_line.settings();
  for (const std::string& log : logs) CheckEarlierResults(earlier, log, settings);
  const std::string channels = settings.laser_channel;
  const std::vector<Drive> drives = ListDrives(logs, channels);
  if (drives.size() > 1) CheckSeveral(command_line, logs);
  AdoptEarlierMapParameters(earlier.resume, command_line);
  if (drives.size() > 1) CheckDrives(command_line, drives);
  auto source = Open(command_line, drives, 0);
  for (const std::string& folder : {earlier.resume, settings.localize}) {
    if (!folder.empty()) CheckAreOfOneMap(folder);
  }
  PrepareFolder(settings.out);
  ResultsLock lock("--out", settings.out);
  MakeRoom(command_line.program(), settings.out, earlier);
  StudyLaser(logs.front(), command_line);
  source = Open(command_line, drives, 0);

  Run run(command_line.parameters());
  run.made_from =
      JoinOrigins(earlier.resume.empty() ? "" : ReadMadeFrom(earlier.resume), command_line.DescribeRun(logs));
  const std::unique_ptr<Journal> journal = Begin(command_line, earlier.resume, run);
  lock.Renew();
  BreakNews news;
  news.Skip(run.slam.mapper());
  Progress progress(command_line.program());
  for (std::size_t i = 0; i < drives.size() && !StopRequested(); ++i) {
    if (i > 0) source = Open(command_line, drives, i);
    const std::string of_channel = drives.size() > logs.size() ? fmt::format(" ({})", drives[i].channel) : "";
    run.sessions.push_back({drives[i].log, drives[i].log + of_channel});
    MapLog(command_line, *source, run, *journal, [&] {
      SayNews(command_line, run, news);
      const auto Share = [&] {
        return (static_cast<double>(i) + source->Progress()) / static_cast<double>(drives.size());
      };
      progress.Show(Share, run.latency.num_recorded());
    });
  }
  progress.Finish(run.latency.num_recorded());
  if (StopRequested()) Say(fmt::format("{}: finishing the map", command_line.program()));
  Keep(run.slam.AwaitLoops(), run, *journal);
  SayNews(command_line, run, news);
  for (const std::string& line : TakeMarks(marks, run.slam.mapper(), run.matches, run.marks,
                                           [&](const FixedMark& mark) { journal->Append(mark); })) {
    Say(fmt::format("{}: {}", command_line.program(), line));
  }
  if (run.slam.num_scans_cut() > 0) Say(fmt::format("{}: {}", command_line.program(), kMapIsFull));
  lock.CheckIsInPlace();
  command_line.ChooseLaserChannel(channels);
  return WriteRun(command_line, journal->epoch(), run);
}

}  // namespace
}  // namespace crsm

int main(int argc, char** argv) {
  using enum crsm::ParameterGroup;
  crsm::CommandLine command_line(
      "slam_offline",
      "Maps logs or simulated worlds in one process. Several logs are drives of their own, whose starts are unknown: "
      "they are joined to one map where they come to the same places. Exit codes: 0 done, 1 failed or no scan mapped, "
      "2 usage, 3 with --strict: the map is not to be trusted, 4 with --changes-over: the building has changed.",
      {kSeed, kLaser, kScan, kSelection, kUpdate, kLoops, kAlgorithm},
      {"lcm_url", "channel_prefix", "out", "laser_channel", "laser_frame", "odometry", "odometry_topic",
       "botlab_clockwise", "mirrored", "until_damage", "localize", "start", "team"});
  std::vector<std::string> logs;
  command_line.AddWord("SOURCE", logs, crsm::DescribeSources());
  crsm::EarlierResults earlier;
  crsm::AddFlags(command_line, earlier);
  crsm::MarksOfFile marks;
  command_line.AddOption(
      "--marks", marks.path,
      "CSV file of places with names: a header, then a line for each; columns: kind, and x_m and y_m "
      "in the map's frame, or time_s",
      {crsm::kOptionsHeading, "FILE"});
  bool strict = false;
  command_line.AddFlag("--strict", strict, "exit with 3 if the map is not to be trusted");
  crsm::ChangesOver changes_over;
  changes_over.AddFlag(command_line);
  if (const auto exit_code = command_line.Parse(argc, argv)) return *exit_code;
  crsm::CatchSignals();
  return crsm::ReportErrors(command_line.program(), [&] {
    changes_over.Check(command_line.settings());
    if (!marks.path.empty()) marks.marks = crsm::ReadMarkList(marks.path);
    const crsm::Outcome outcome = crsm::MapLogs(command_line, logs, earlier, marks);
    if (strict && outcome.trust == crsm::Trust::kBad) return crsm::kUntrustedExitCode;
    if (changes_over.IsExceededBy(outcome.changed_m2)) return crsm::kChangedExitCode;
    return outcome.is_mapped ? EXIT_SUCCESS : EXIT_FAILURE;
  });
}
