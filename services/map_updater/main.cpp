// map_updater: CRITICAL_RAYS and SCAN_MATCH -> MAP_DELTA. The owner of the map: draws each matched scan into it and
// tells the replicas what changed. It sends what it draws to a loop closer, and corrects the map by what comes back:
// KEYFRAME -> POSE_GRAPH, but for --no-loops.

#include <fmt/core.h>

#include "common/diagnosis/changes.hpp"
#include "common/graph/mapper.hpp"
#include "common/logs/left_out.hpp"
#include "common/math/format_number.hpp"
#include "common/scan/deskew.hpp"
#include "services/base/held_by_utime.hpp"
#include "services/base/path_lock.hpp"
#include "services/base/stall_watch.hpp"
#include "services/base/usage_error.hpp"
#include "services/bus/service.hpp"
#include "services/diagnosis/break_news.hpp"
#include "services/diagnosis/lost_news.hpp"
#include "services/journal/journal.hpp"
#include "services/journal/map_parameters.hpp"
#include "services/map_updater/delta_parts.hpp"
#include "services/map_updater/loop_closer_link.hpp"
#include "services/map_updater/mark_keeper.hpp"
#include "services/map_updater/whole_view.hpp"
#include "services/replica/request_limiter.hpp"
#include "services/stages/scan_queue.hpp"
#include "services/wire/conversions.hpp"

namespace crsm {
namespace {

class MapUpdaterService {
 public:
  explicit MapUpdaterService(const CommandLine& command_line)
      : settings_(command_line.settings()),
        service_(command_line),
        matches_(service_.counters()),
        map_parameters_(ListMapParameters(command_line.parameters())),
        mapper_(command_line.parameters().update, command_line.parameters().loops),
        whole_(service_.bus(), command_line.parameters().update),
        marks_(service_, mapper_, answered_, [this](const FixedMark& mark) {
          if (journal_) Keep([&] { journal_->Append(mark); });
        }) {
    service_.TakeRole(kMapOwnerRole);
    LoadFinishedMap();
    OpenJournal();
    service_.counters().Set(kScansBefore, answered_.size());
    news_.Skip(mapper_);
    if (mapper_.closes_loops()) LinkToLoopCloser();
    Bus& bus = service_.bus();
    bus.SubscribeToOne<critical_rays_t>(kCriticalRaysChannel, kSelectorRole,
                                        [this](const critical_rays_t& message) { Hold(FromMessage(message)); });
    bus.SubscribeToOne<scan_match_t>(kScanMatchChannel, kMatcherRole,
                                     [this](const scan_match_t& message) { matches_.Push(FromMessage(message)); });
    bus.Subscribe<map_request_t>(kMapRequestChannel, [this](const map_request_t& request) { AnswerRequest(request); });
    bus.Subscribe<scan_request_t>(kScanRequestChannel, [this](const scan_request_t& request) {
      service_.counters().Add("scan_requests");
      if (Admit(request.requester, "scan_requests_refused", kScanRequestChannel)) AnswerAbout(request);
    });
  }

  void Run() {
    service_.Run([this] {
      if (settings_.lockstep) stall_watch_.Look(Awaited(), Clock::now());
      if (link_) link_->Poll(Clock::now());
      LookAtJournal();
      for (const std::string& line : news_.Look(mapper_, Clock::now())) Say(fmt::format("map_updater: {}", line));
      PublishChanges();
      marks_.Poll(Clock::now());
      whole_.Show(mapper_, {answered_, tracking_, nullptr, {}, [this] { return marks_.Place(); }}, options_);
      if (matches_.empty() || !Answer(matches_.front())) return !whole_.is_asked();
      matches_.Pop();
      return matches_.empty() && !whole_.is_asked();
    });
    marks_.Finish();
  }

 private:
  void LinkToLoopCloser() {
    Bus& bus = service_.bus();
    link_.emplace(mapper_, service_.counters(),
                  LoopCloserLink::Owner{
                      [&bus](const keyframe_t& keyframe) { bus.Publish(kKeyframeChannel, keyframe); },
                      [this](const GraphUpdate& update) { Keep(update); },
                      [this](KeyframeId keyframe) { KeepSearched(keyframe); },
                      [this](std::int64_t held) { TellMarks(held); },
                      [&bus](const Sender& sender) { return bus.HasRole(sender, kLoopCloserRole); },
                  });
    link_->SetEpoch(options_.epoch);
    bus.SubscribeToOne<pose_graph_t>(kPoseGraphChannel, kLoopCloserRole,
                                     [this](const pose_graph_t& message) { link_->Take(message, Clock::now()); });
    bus.Subscribe<keyframe_request_t>(kKeyframeRequestChannel, [this, &bus](const keyframe_request_t& request) {
      link_->Answer(request, bus.sender(), Clock::now());
    });
  }

  void TellMarks(std::int64_t held) {
    robot_marks_t marks = ToMessage(marks_.Anchor(), options_.epoch);
    if (marks.checksum == held) {
      marks.num_marks = 0;
      marks.marks.clear();
    }
    service_.bus().Publish(kRobotMarksChannel, marks);
  }

  /// What waits for its match. One of a scan that was answered long ago waits in vain, and gives way to newer ones.
  void Hold(CriticalRays scan) {
    if (tracking_.FindRecent(scan.utime)) return;
    held_utime_ = scan.utime;
    scans_.Hold(std::move(scan));
  }

  /// In lockstep: what the next version of the map takes that is not here.
  StallWatch::Awaited Awaited() const {
    if (MustWaitForLoops()) return {"loop_closer to search for loops in {} keyframes", link_->num_awaited()};
    if (match_without_scan_) return {"CRITICAL_RAYS of scan {}", *match_without_scan_};
    if (held_utime_) return {"SCAN_MATCH of scan {}", *held_utime_};
    if (tracking_.empty()) return {};
    return {"CRITICAL_RAYS and SCAN_MATCH after those of scan {}", tracking_.recent().back().utime};
  }

  bool Admit(std::int64_t requester, const char* counter, const char* channel) {
    if (request_limiter_.Admit(service_.bus().sender(), requester, Clock::now())) return true;
    service_.Complain(counter, fmt::format("map_updater: {} comes more often than anybody needs: most of them get no "
                                           "answer",
                                           channel));
    return false;
  }

  /// Whether a scan is in the map. requester: 0 where a match of it came once more.
  void AnswerAbout(const scan_request_t& request) {
    scan_answer_t answer{request.utime, options_.epoch, request.requester, answered_.FindNext(request.utime), 0, {}};
    if (const auto match = answered_.Find(request.utime)) answer.matches.push_back(ToMessage(*match));
    answer.num_matches = static_cast<std::int32_t>(answer.matches.size());
    service_.bus().Publish(kScanAnswerChannel, answer);
  }

  void AnswerRequest(const map_request_t& request) {
    service_.counters().Add("map_requests");
    if (!Admit(request.requester, "map_requests_refused", kMapRequestChannel)) return;
    if (request.whole == 0) {
      return service_.bus().Publish(kMapPageChannel, MakePage(request, local(), {answered_, tracking_}, options_));
    }
    if (request.settled == 1 && link_ && !link_->IsSettled()) return;  // it will be asked again
    whole_.Ask(request, service_.bus().sender());
  }

  /// In lockstep, what a loop has brought takes effect at its keyframe, however long the search takes.
  bool MustWaitForLoops() const { return settings_.lockstep && link_ && !link_->IsReadyForNext(); }

  /// Every match is answered by exactly one version of the map. A match that comes again gets its answer again. False
  /// if it cannot be answered yet.
  bool Answer(const ScanMatch& match) {
    if (!tracking_.empty() && tracking_.recent().back().utime == match.utime) {
      service_.counters().Add("resent");
      // The map may have been corrected after it, and the match with it.
      const bool same = tracking_.recent().back() == match || answered_.At(answered_.size() - 1) == match;
      if (!same) CountContradiction(match);
      PublishLastAnswer();
      return true;
    }
    if (match.utime <= tracking_.newest_utime() && answered_.Find(match.utime)) {
      service_.counters().Add("utime_repeated");
      AnswerAbout({match.utime, 0});
      return true;
    }
    if (MustWaitForLoops()) return false;
    const CriticalRays* scan = scans_.Find(match.utime);
    if (!scan && settings_.lockstep) {
      match_without_scan_ = match.utime;
      service_.counters().Add("scan_awaited");  // it will be sent again, and the match with it
      return true;
    }
    AnswerNew(scan, match);
    return true;
  }

  void AnswerNew(const CriticalRays* scan, const ScanMatch& match) {
    const auto start = Clock::now();
    if (!scan) service_.counters().Add("scan_missing");
    if (scan && !local().InLimits(scan->rays, match.T_map_laser)) service_.counters().Add("match_out_of_limits");
    const bool drawn = PrepareAnswer(mapper_.Integrate(scan, match), match);
    if (journal_) Keep([&] { journal_->Append(drawn ? scan : nullptr, match); });
    if (changes_ && scan) {
      changes_->Add(Deskew(scan->rays, match.twist), match);
      is_compared_ = true;
    }
    scans_.DropThrough(match.utime);
    match_without_scan_.reset();
    if (held_utime_ == match.utime) held_utime_.reset();
    service_.counters().Add("handled");
    const std::string work = settings_.localize.empty() ? "mapping" : "localising on a finished map";
    service_.SetState(journal_ || settings_.journal.empty() ? work : work + ", but the journal cannot be written");
    service_.RecordLatency(start);
    PublishLastAnswer();
    if (const auto line = lost_news_.Add(match, Clock::now())) Say(fmt::format("map_updater: {}", *line));
    if (link_ && drawn) link_->SendNewest(Clock::now());
  }

  /// Where senders are not known, this is how a second one shows.
  void CountContradiction(const ScanMatch& match) {
    service_.Complain("match_contradicted", fmt::format("map_updater: two different SCAN_MATCH of scan {}: is there "
                                                        "another matcher on this bus? The map may use the wrong one",
                                                        match.utime));
  }

  /// Makes the answer to a match of what became of its scan. Whether that was drawn.
  bool PrepareAnswer(const Mapper::Step& step, const ScanMatch& match) {
    if (const std::int64_t num_cut = local().num_scans_cut(); num_cut > num_cut_) {
      if (num_cut_ == 0) Say(fmt::format("map_updater: {}", kMapIsFull));
      service_.counters().Add("scan_cut", num_cut - num_cut_);
      num_cut_ = num_cut;
    }
    last_answer_ = MakeParts(step.delta, match.utime, local().geometry(), options_, step.after);
    answered_.Append(match);
    tracking_.Add(match, step.after);
    return step.delta.drawn;
  }

  /// Makes the map of --localize, which then stays as it is; what comes now is a history of its own.
  void LoadFinishedMap() {
    if (settings_.localize.empty()) return;
    const std::filesystem::path folder = JournalFolder(settings_.localize);
    mapper_.PutOffDrawing();
    CheckAreOfOneMap(settings_.localize);
    VisitJournal visit = VisitOfJournal(folder);
    std::int64_t epoch = 0;
    visit.head = [&epoch](const JournalHead& head) { epoch = head.epoch; };
    const std::string notice = ReadJournal(folder, {false, map_parameters_}, on_damage_, visit);
    RestoreTail(folder);
    finished_map_name_ = NameMap(epoch, answered_.size());
    if (!notice.empty()) Say(fmt::format("map_updater: {}", notice));
    mapper_.Finish();
    if (local().num_tiles() == 0) {
      throw std::runtime_error(fmt::format("--localize {}: its map is empty", settings_.localize));
    }
    Say(fmt::format("map_updater: localises on the finished map of {} from {}", FormatCount(answered_.size(), "scan"),
                    settings_.localize));
    answered_ = MatchStore();
    tracking_ = TrackingState::OnFinishedMap();
    finished_map_.emplace(local().geometry().cell_size_m());
    local().CopyTo(*finished_map_);
    changes_.emplace(MakeChangeFinder(mapper_, *finished_map_));
  }

  /// More often than once in the time that an exporter waits at the end.
  void PublishChanges() {
    constexpr auto kPause = std::chrono::milliseconds(500);
    if (!changes_ || tracking_.empty() || Clock::now() < next_changes_) return;
    next_changes_ = Clock::now() + kPause;
    if (std::exchange(is_compared_, false)) found_changes_ = changes_->Find();
    service_.bus().Publish(kChangesChannel, ToMessage(found_changes_, tracking_.newest_utime(), options_.epoch));
  }

  void OpenJournal() {
    if (settings_.journal.empty()) {
      if (settings_.resume) throw UsageError("--resume needs --journal DIR, the folder of the map's journal");
      if (settings_.new_session)
        throw UsageError("--new-session needs --resume: it begins a session on an earlier map");
      return;
    }
    const JournalSubject subject{!settings_.localize.empty(), map_parameters_, finished_map_name_};
    if (!settings_.resume) {
      journal_.emplace(settings_.journal, subject);
      LockJournal();
      return SetEpoch(IdentityOfThisBoot(journal_->epoch()));
    }
    LockJournal();
    mapper_.PutOffDrawing();
    journal_.emplace(settings_.journal, subject, on_damage_, VisitOfJournal(settings_.journal));
    mapper_.DrawPutOff();
    RestoreTail(settings_.journal);
    SetEpoch(IdentityOfThisBoot(journal_->epoch()));
    BeginSession();
    if (!journal_->notice().empty()) Say(fmt::format("map_updater: {}", journal_->notice()));
    Say(fmt::format("map_updater: continues after {} from {}", FormatCount(answered_.size(), "scan"),
                    settings_.journal));
  }

  void BeginSession() {
    if (!settings_.new_session) return;
    const auto start = ParseStart(settings_.start);
    start ? tracking_.BeginSessionNear(*start) : tracking_.BeginSession(Onset::kResumed);
  }

  /// The last scan of a journal, and what was learned of loops since. All before it is drawn at once in the end. What
  /// the scan itself has changed may be asked for again.
  struct Tail {
    std::optional<CriticalRays> scan;
    ScanMatch match;
    std::vector<std::function<bool()>> updates = {};
  };

  /// Makes the map of a journal, but for its tail.
  VisitJournal VisitOfJournal(const std::filesystem::path& folder) {
    VisitJournal visit;
    visit.match = [this, folder](const CriticalRays* scan, const ScanMatch& match) {
      RestoreTail(folder);
      tail_ = {scan ? std::optional(*scan) : std::nullopt, match};
    };
    visit.update = [this](const GraphUpdate& update) {
      return Hold([this, update] { return mapper_.Accept(update); });
    };
    visit.searched = [this](KeyframeId keyframe) {
      return Hold([this, keyframe] { return mapper_.NoteSearched(keyframe); });
    };
    visit.mark = [this](const FixedMark& mark) { return Hold([this, mark] { return marks_.Restore(mark); }); };
    return visit;
  }

  /// False where there is no scan yet.
  bool Hold(std::function<bool()> update) {
    if (tail_) tail_->updates.push_back(std::move(update));
    return tail_.has_value();
  }

  /// folder: of the journal.
  void RestoreTail(const std::filesystem::path& folder) {
    const auto tail = std::exchange(tail_, std::nullopt);
    if (!tail) return;
    PrepareAnswer(mapper_.Restore(tail->scan ? &*tail->scan : nullptr, tail->match), tail->match);
    const bool fit = std::ranges::all_of(tail->updates, [](const auto& update) { return update(); });
    if (!fit) ThrowLoopsDoNotFit(JournalPath(folder));
  }

  /// Also against an owner of another bus.
  void LockJournal() { journal_lock_.emplace("--journal", JournalPath(settings_.journal)); }

  /// What goes on in a file that was removed, or whose place another one has taken, nobody will find.
  void LookAtJournal() {
    if (!journal_ || Clock::now() < next_look_at_journal_) return;
    next_look_at_journal_ = Clock::now() + std::chrono::seconds(1);
    if (journal_lock_->IsInPlace()) return;
    Keep([this] {
      throw std::runtime_error(
          fmt::format("{}: was removed, moved or replaced", JournalPath(settings_.journal).string()));
    });
  }

  /// The last answer may be asked for again.
  void SetEpoch(std::int64_t epoch) {
    if (journal_) service_.SetIdentity(FormatIdentity(journal_->epoch()));
    options_.epoch = epoch;
    for (map_delta_t& part : last_answer_) part.epoch = epoch;
    if (link_) link_->SetEpoch(epoch);
  }

  /// From now on the map is made of this, too.
  void Keep(const GraphUpdate& update) {
    const Keyframe& keyframe = mapper_.graph().keyframe(update.keyframe);
    if (journal_) Keep([&] { journal_->Append(update, keyframe.utime); });
  }

  void KeepSearched(KeyframeId keyframe) {
    const Mapper& mapper = mapper_;
    if (journal_)
      Keep([&] { journal_->AppendSearched(keyframe, mapper.last_update(), mapper.graph().keyframe(keyframe).utime); });
  }

  /// A journal that cannot be written is no reason to stop mapping, but it ends there: no map is made from one with a
  /// hole. The map is another one from here on than the one that the journal will give. Beside a journal of another map
  /// it is still known by its own, so that all who compare them see that they do not belong together.
  void Keep(const std::function<void()>& append) {
    try {
      append();
    } catch (const std::runtime_error& error) {
      Say(fmt::format("map_updater: {}; mapping goes on without a journal", error.what()));
      service_.counters().Add("journal_failed");
      if (!IsOfAnotherMap(settings_.journal, FormatIdentity(journal_->epoch()))) service_.SetIdentity("");
      journal_.reset();
      SetEpoch(DrawIdentity());
    }
  }

  void PublishLastAnswer() {
    service_.bus().Together([this] {
      for (const map_delta_t& part : last_answer_) service_.bus().Publish(kMapDeltaChannel, part);
    });
  }

  const MapUpdater& local() const { return mapper_.local(); }

  const Settings& settings_;
  Service service_;
  ScanQueue<ScanMatch> matches_;
  ParameterTexts map_parameters_;
  std::string finished_map_name_;  ///< as of JournalSubject
  OnDamage on_damage_ = settings_.until_damage ? OnDamage::kTakeWhatIsBefore : OnDamage::kRefuse;
  Mapper mapper_;
  std::optional<ByteMap> finished_map_;   ///< with --localize
  std::optional<ChangeFinder> changes_;   ///< since it was made
  std::vector<MapChange> found_changes_;  ///< that were told last
  bool is_compared_ = false;              ///< more of it since
  Clock::time_point next_changes_{};
  WholeView whole_;
  MatchStore answered_;
  MarkKeeper marks_;
  BreakNews news_;
  LostNews lost_news_;
  std::optional<LoopCloserLink> link_;  ///< with loops, unless the map is finished
  AnswerOptions options_{DrawIdentity(), static_cast<std::size_t>(settings_.part_bytes)};
  /// Whose match has not come yet: as many as the matcher may lag behind, and those that come meanwhile of a laser that
  /// is ten times too fast.
  HeldByUtime<CriticalRays, 2048> scans_;
  RequestLimiter request_limiter_{
      [this](const Sender& sender) { return service_.bus().HasRole(sender, kMatcherRole); }};
  TrackingState tracking_;  ///< after those that were answered
  std::vector<map_delta_t> last_answer_;
  std::optional<Tail> tail_;  ///< while a journal is read
  std::int64_t num_cut_ = 0;  ///< scans for which the map had no room
  std::optional<PathLock> journal_lock_;
  std::optional<Journal> journal_;
  Clock::time_point next_look_at_journal_{};
  std::optional<std::int64_t> match_without_scan_;  ///< utime of a match that waits for its rays
  std::optional<std::int64_t> held_utime_;          ///< of the last rays that came, which wait for their match
  StallWatch stall_watch_{service_.name(), Say};
};

/// Of the map that is there already. Whoever makes the scans must have been told the same.
void TakeOverParameters(CommandLine& command_line) {
  const Settings& settings = command_line.settings();
  std::vector<std::filesystem::path> journals;
  if (!settings.localize.empty()) journals.push_back(JournalFolder(settings.localize));
  if (settings.resume && !settings.journal.empty()) journals.emplace_back(settings.journal);
  for (const auto& folder : journals) {
    CheckLaserParameters(folder, command_line);
    AdoptMapParameters(folder, command_line);
  }
}

}  // namespace
}  // namespace crsm

int main(int argc, char** argv) {
  crsm::CommandLine command_line("map_updater", "Owns the map: CRITICAL_RAYS, SCAN_MATCH -> MAP_DELTA.",
                                 crsm::FlagsOfUpdater());
  if (const auto exit_code = command_line.Parse(argc, argv)) return *exit_code;
  return crsm::RunMain(command_line.program(), [&] {
    crsm::TakeOverParameters(command_line);
    crsm::MapUpdaterService(command_line).Run();
  });
}
