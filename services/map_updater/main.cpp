// map_updater: CRITICAL_RAYS and SCAN_MATCH -> MAP_DELTA. The owner of the map: draws each matched scan into it and
// tells the replicas what changed.

#include <fmt/core.h>

#include "common/map/map_updater.hpp"
#include "services/map_updater/answers.hpp"
#include "services/map_updater/request_limiter.hpp"
#include "services/runtime/conversions.hpp"
#include "services/runtime/held_by_utime.hpp"
#include "services/runtime/path_lock.hpp"
#include "services/runtime/scan_queue.hpp"
#include "services/runtime/service.hpp"
#include "services/runtime/stall_watch.hpp"
#include "services/runtime/usage_error.hpp"
#include "services/sources/journal.hpp"
#include "services/sources/map_parameters.hpp"

namespace crsm {
namespace {

class MapUpdaterService {
 public:
  explicit MapUpdaterService(const CommandLine& command_line)
      : settings_(command_line.settings()),
        service_(command_line),
        matches_(service_.counters()),
        map_parameters_(ListMapParameters(command_line.parameters())),
        updater_(command_line.parameters().update) {
    service_.TakeRole(kMapOwnerRole);
    LoadFinishedMap();
    OpenJournal();
    Bus& bus = service_.bus();
    bus.SubscribeToOne<critical_rays_t>(kCriticalRaysChannel,
                                        [this](const critical_rays_t& message) { Hold(FromMessage(message)); });
    bus.SubscribeToOne<scan_match_t>(
        kScanMatchChannel, [this](const scan_match_t& message) { matches_.Push(FromMessage(message)); },
        SoleSender::kProbationOfAnswers);
    bus.Subscribe<map_request_t>(kMapRequestChannel, [this](const map_request_t& request) { AnswerRequest(request); });
  }

  void Run() {
    service_.Run([this] {
      if (settings_.lockstep) stall_watch_.Look(Awaited(), Clock::now());
      if (matches_.empty()) return true;
      Answer(matches_.front());
      matches_.Pop();
      return matches_.empty();
    });
  }

 private:
  /// What waits for its match. One of a scan that was answered long ago waits in vain, and gives way to newer ones.
  void Hold(CriticalRays scan) {
    if (tracking_.FindRecent(scan.utime)) return;
    held_utime_ = scan.utime;
    scans_.Hold(std::move(scan));
  }

  /// In lockstep: what the next version of the map takes that is not here.
  StallWatch::Awaited Awaited() const {
    if (match_without_scan_) return {"CRITICAL_RAYS of scan {}", *match_without_scan_};
    if (held_utime_) return {"SCAN_MATCH of scan {}", *held_utime_};
    if (tracking_.empty()) return {};
    return {"CRITICAL_RAYS and SCAN_MATCH after those of scan {}", tracking_.recent().back().utime};
  }

  void AnswerRequest(const map_request_t& request) {
    Counters& counters = service_.counters();
    counters.Add("map_requests");
    if (!request_limiter_.Admit(service_.bus().sender(), request.requester, Clock::now())) {
      if (counters.counts().count("map_requests_refused") == 0) {
        Say("map_updater: more MAP_REQUEST than any replica needs: most of them are not answered");
      }
      return counters.Add("map_requests_refused");
    }
    service_.bus().Publish(kMapDeltaChannel, MakePage(request, updater_, {answered_, tracking_}, options_));
  }

  /// Every match is answered by exactly one version of the map. A match that comes again gets its answer again.
  void Answer(const ScanMatch& match) {
    const auto start = Clock::now();
    if (!tracking_.empty() && tracking_.recent().back().utime == match.utime) {
      service_.counters().Add("resent");
      if (tracking_.recent().back() != match) CountContradiction(match);
      return PublishLastAnswer();
    }
    if (match.utime <= tracking_.newest_utime() && answered_.Find(match.utime)) {
      service_.counters().Add("utime_repeated");
      return service_.bus().Publish(kMapDeltaChannel, MakeEmptyAnswer(match.utime, updater_, options_));
    }
    const CriticalRays* scan = scans_.Find(match.utime);
    if (!scan && settings_.lockstep) {
      match_without_scan_ = match.utime;
      return service_.counters().Add("scan_awaited");  // it will be sent again, and the match with it
    }
    if (!scan) service_.counters().Add("scan_missing");
    if (scan && !updater_.InLimits(scan->rays, match.T_map_laser)) service_.counters().Add("match_out_of_limits");
    const bool drawn = Draw(scan, match);
    if (journal_) Keep(drawn ? scan : nullptr, match);
    scans_.DropThrough(match.utime);
    match_without_scan_.reset();
    if (held_utime_ == match.utime) held_utime_.reset();
    service_.counters().Add("handled");
    const std::string work = settings_.localize.empty() ? "mapping" : "localising on a finished map";
    service_.SetState(journal_ || settings_.journal.empty() ? work : work + ", but the journal cannot be written");
    service_.RecordLatency(start);
    PublishLastAnswer();
  }

  /// Where senders are not known, this is how a second one shows.
  void CountContradiction(const ScanMatch& match) {
    constexpr const char* kCounter = "match_contradicted";
    if (service_.counters().counts().count(kCounter) == 0) {
      Say(fmt::format(
          "map_updater: two different SCAN_MATCH of scan {}: is there another matcher on this bus? Which of "
          "them is in the map is not known; it may be wrong",
          match.utime));
    }
    service_.counters().Add(kCounter);
  }

  /// scan: nullptr where there is none to draw; the match is answered all the same. Whether the scan was drawn.
  bool Draw(const CriticalRays* scan, const ScanMatch& match) {
    const std::int64_t num_cut_before = updater_.num_scans_cut();
    const MapDelta delta = scan ? updater_.Update(*scan, match) : updater_.UpdateWithoutScan();
    if (updater_.num_scans_cut() > num_cut_before) {
      if (num_cut_before == 0) Say(fmt::format("map_updater: {}", kMapIsFull));
      service_.counters().Add("scan_cut");
    }
    last_answer_ = MakeParts(delta, match, updater_.geometry(), options_);
    answered_.Append(match);
    tracking_.Add(match);
    return delta.drawn;
  }

  /// Makes the map of --localize, which then stays as it is; what comes now is a history of its own.
  void LoadFinishedMap() {
    if (settings_.localize.empty()) return;
    const std::string notice =
        ReadJournal(JournalFolder(settings_.localize), {false, map_parameters_}, on_damage_,
                    [this](const CriticalRays* scan, const ScanMatch& match) { Draw(scan, match); });
    if (!notice.empty()) Say(fmt::format("map_updater: {}", notice));
    if (updater_.num_tiles() == 0) {
      throw std::runtime_error(fmt::format("--localize {}: its map is empty", settings_.localize));
    }
    Say(fmt::format("map_updater: a finished map of {} scans from {}", answered_.size(), settings_.localize));
    updater_.Finish();
    answered_ = MatchStore();
    tracking_ = TrackingState::OnFinishedMap();
  }

  void OpenJournal() {
    if (settings_.journal.empty()) {
      if (settings_.resume) throw UsageError("--resume needs --journal DIR: where the map is to come from");
      return;
    }
    const JournalSubject subject{!settings_.localize.empty(), map_parameters_};
    if (!settings_.resume) {
      journal_.emplace(settings_.journal, subject);
      LockJournal();
      return SetEpoch(journal_->epoch());
    }
    LockJournal();
    journal_.emplace(settings_.journal, subject, on_damage_,
                     [this](const CriticalRays* scan, const ScanMatch& match) { Draw(scan, match); });
    SetEpoch(journal_->epoch());
    if (!journal_->notice().empty()) Say(fmt::format("map_updater: {}", journal_->notice()));
    Say(fmt::format("map_updater: went on from {} scans in {}", answered_.size(), settings_.journal));
  }

  /// Also against an owner of another bus.
  void LockJournal() { journal_lock_.emplace("--journal", JournalPath(settings_.journal)); }

  /// The last answer may be asked for again.
  void SetEpoch(std::int64_t epoch) {
    options_.epoch = epoch;
    for (map_delta_t& part : last_answer_) part.epoch = epoch;
  }

  /// A journal that cannot be written is no reason to stop mapping, but it ends there: no map is made from one with a
  /// hole. The map is another one from here on than the one that the journal will give.
  void Keep(const CriticalRays* scan, const ScanMatch& match) {
    try {
      journal_->Append(scan, match);
    } catch (const std::runtime_error& error) {
      Say(fmt::format("map_updater: {}; mapping goes on without a journal", error.what()));
      service_.counters().Add("journal_failed");
      journal_.reset();
      SetEpoch(DrawIdentity());
    }
  }

  void PublishLastAnswer() {
    for (const map_delta_t& part : last_answer_) service_.bus().Publish(kMapDeltaChannel, part);
  }

  const Settings& settings_;
  Service service_;
  ScanQueue<ScanMatch> matches_;
  ParameterTexts map_parameters_;
  OnDamage on_damage_ = settings_.until_damage ? OnDamage::kTakeWhatIsBefore : OnDamage::kRefuse;
  MapUpdater updater_;
  AnswerOptions options_{DrawIdentity(), static_cast<std::size_t>(settings_.part_bytes)};
  /// Whose match has not come yet: as many as the matcher may lag behind, and those that come meanwhile of a laser that
  /// is ten times too fast.
  HeldByUtime<CriticalRays, 2048> scans_;
  RequestLimiter request_limiter_;
  MatchStore answered_;
  TrackingState tracking_;  ///< after those
  std::vector<map_delta_t> last_answer_;
  std::optional<PathLock> journal_lock_;
  std::optional<Journal> journal_;
  std::optional<std::int64_t> match_without_scan_;  ///< utime of a match that waits for its rays
  std::optional<std::int64_t> held_utime_;          ///< of the last rays that came, which wait for their match
  StallWatch stall_watch_{service_.name(), Say};
};

/// Of the map that is there already. Whoever makes the scans must have been told the same.
void TakeOverParameters(CommandLine& command_line) {
  const Settings& settings = command_line.settings();
  RefuseLoops({}, command_line);
  std::vector<std::filesystem::path> journals;
  if (!settings.localize.empty()) journals.push_back(JournalFolder(settings.localize));
  if (settings.resume && !settings.journal.empty()) journals.emplace_back(settings.journal);
  for (const auto& folder : journals) {
    CheckLaserParameters(folder, command_line);
    AdoptMapParameters(folder, command_line);
    RefuseLoops(folder, command_line);
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
