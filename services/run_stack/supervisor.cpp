#include "services/run_stack/supervisor.hpp"

#include <fmt/core.h>
#include <signal.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <utility>

#include "common/math/format_number.hpp"
#include "services/base/process.hpp"
#include "services/diagnosis/break_news.hpp"
#include "services/diagnosis/left_out_news.hpp"
#include "services/diagnosis/lost_news.hpp"
#include "services/run_stack/outcome.hpp"

namespace crsm {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds kLookEvery(100);
constexpr seconds kPatience(10);           // with a service that starts, ...
constexpr seconds kEndPatience(60);        // ... and with one that is asked to end, or is needed at the end
constexpr milliseconds kHurryAfter(1000);  // with the same, after a Ctrl-C
constexpr int kMostDeaths = 5;             // while no scan is mapped: there is a reason that stays

/// For the map of a journal is made before all else: of 200 kB a second on the slowest machine.
seconds TimeToMap(std::uintmax_t journal_bytes) { return seconds(journal_bytes / 200'000); }

}  // namespace

Supervisor::Supervisor(StackPlan plan, StackViewer* viewer, ResultsFolder& folder, Signals& signals)
    : plan_(std::move(plan)), folder_(folder), signals_(signals), viewer_(viewer) {
  for (const PlannedService& service : plan_.services) services_.push_back(&planned_.emplace_back(Member{service}));
  if (viewer) services_.push_back(&viewer->member());
  if (plan_.publisher) publisher_ = Member{*plan_.publisher};
  for (const Member* member : All()) {
    const std::filesystem::path& log = member->plan.command.log;
    std::error_code error;
    const auto status = std::filesystem::symlink_status(log, error);
    if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
      throw std::runtime_error(fmt::format("{} is no regular file: remove it", log.string()));
    }
  }
}

bool Supervisor::Run() {
  signals_.Wait(milliseconds(0));
  if (IsInterrupted()) return true;  // before there is anything to finish
  for (Member& service : planned_) {
    Start(service, plan_.resume, plan_.resume ? service.plan.when_resuming_first : std::vector<std::string>());
  }
  is_ready_ = WaitUntilReady(kPatience + TimeToMap(plan_.earlier_journal_bytes));
  if (!is_ready_ && IsInterrupted() && !failed_) Dismiss();
  if (is_ready_ && !IsInterrupted()) {
    if (publisher_) {
      Start(*publisher_, false);
    }
    if (plan_.live) Say(publisher_ ? "run_stack: mapping; Ctrl-C ends" : "run_stack: listening; Ctrl-C ends");
    WaitForEnd();
    if (!failed_) ReviveAll();
  }
  StopAll();
  CheckFolder();
  return !failed_;
}

void Supervisor::Start(Member& member, bool resume, const std::vector<std::string>& own) {
  std::vector<std::string> more = resume ? member.plan.when_resuming : member.plan.when_new;
  more.insert(more.end(), own.begin(), own.end());
  member.Start(more);
}

bool Supervisor::WaitUntilReady(seconds patience) {
  constexpr milliseconds kLookOften(20);
  const auto give_up = Clock::now() + patience;
  for (Member* service : services_) {
    while (!service->IsReady() && service->child) {
      if (!service->IsRunning()) {
        Report(*service, fmt::format("failed ({})", service->child->DescribeEnd()));
        service->child.reset();
      } else if (Clock::now() >= give_up) {
        Report(*service, fmt::format("was not ready within {} s", patience.count()));
        if (!service->plan.is_needed) break;
      }
      if (failed_ || !CheckFolder()) return false;
      if (IsInterrupted() && !is_ready_) return false;
      Wait(kLookOften);
    }
  }
  return true;
}

/// Until the publisher is done, somebody interrupts, or something cannot be mended.
void Supervisor::WaitForEnd() {
  // While other services made their maps, there was no publisher yet: what was said of that is no complaint.
  if (publisher_) passed_on_["ray_selector"] = static_cast<std::streamoff>(SizeOf(LogOf("ray_selector")));
  for (const char* name : {"map_updater", "rrhc_matcher"}) {
    passed_on_[name] = static_cast<std::streamoff>(SizeOf(LogOf(name)));
  }
  while (!IsInterrupted()) {
    if (!CheckFolder()) return;
    PassOnComplaints();
    PassOnNews();
    if (viewer_) viewer_->SayAddresses();
    for (Member* service : services_) {
      if (service->HasEnded() && !StartAgain(*service)) return;
    }
    LookAtDisk();
    if (plan_.live) ShowProgress();
    if (publisher_ && !publisher_->IsRunning()) {
      if (publisher_->child->EndedWell() || !StartAgain(*publisher_)) return;
    }
    Wait(kLookEvery);
  }
}

/// A process has ended while it was needed: it is started again and goes on where it was, the map from its journal, the
/// publisher from its position. Whether that makes sense.
bool Supervisor::StartAgain(Member& member) {
  const auto journal_bytes = folder_.JournalBytes();
  if (journal_bytes != member.journal_bytes_at_death) member.num_deaths = 0;
  member.journal_bytes_at_death = journal_bytes;
  const std::string end = member.child->DescribeEnd();
  if (++member.num_deaths >= kMostDeaths) {
    Report(member, fmt::format("ended unexpectedly for the fifth time ({}), and no scan was mapped in between", end));
    member.child.reset();
    return !member.plan.is_needed;
  }
  Say(fmt::format("run_stack: {} ended unexpectedly ({}): restarted", member.plan.name, end));
  Start(member, journal_bytes.has_value());
  return true;
}

/// At the end every service is needed once more, also one that died a moment ago: the exporter asks the updater for
/// what it lacks.
void Supervisor::ReviveAll() {
  bool all_run = true;
  for (Member* service : services_) {
    if (!service->HasEnded()) continue;
    if (!StartAgain(*service)) return;
    all_run = false;
  }
  if (!all_run ||
      !std::all_of(services_.begin(), services_.end(), [](const Member* member) { return member->IsReady(); })) {
    WaitUntilReady(kEndPatience + TimeToMap(folder_.JournalBytes().value_or(0)));
  }
}

/// Nothing was mapped yet, and nothing is to be finished: what takes long, to make the map of a journal again, ends at
/// once, as by a power cut, which a journal bears.
void Supervisor::Dismiss() {
  for (Member& service : planned_) {
    if (!service.child) continue;
    service.child->Signal(SIGKILL);
    while (service.IsRunning()) signals_.Wait(kLookEvery);
    service.child.reset();
  }
  Say("run_stack: stopped before the first scan was mapped: nothing was written");
}

/// The exporter goes before those that it asks for what it lacks.
void Supervisor::StopAll() {
  if (publisher_) Stop({&*publisher_});
  std::vector<Member*> others;
  for (Member* service : services_) {
    service->plan.name == "map_exporter" ? Stop({service}) : others.push_back(service);
  }
  Stop(others);
  PassOnNews();
}

/// Lets processes finish their work, and waits for them.
void Supervisor::Stop(const std::vector<Member*>& members) {
  for (const Member* member : members) {
    if (member->child) member->child->Signal(SIGINT);
  }
  const auto give_up = Clock::now() + kEndPatience;
  const auto hurry = Clock::now() + kHurryAfter;
  bool is_hurried = !IsInterrupted();  // only who asked to end does not want to wait for loops that are still searched
  for (Member* member : members) {
    if (!member->child) continue;
    while (member->IsRunning()) {
      if (!is_hurried && Clock::now() >= hurry) {
        is_hurried = true;
        for (const Member* other : members) {
          if (other->child) other->child->Signal(SIGINT);
        }
      }
      if (Clock::now() >= give_up) {
        Report(*member, fmt::format("did not end within {} s: killed", kEndPatience.count()));
        member->child->Signal(SIGKILL);
        member->child.reset();
        break;
      }
      Wait(kLookEvery);
    }
    if (member->child && !member->child->EndedWell()) {
      Report(*member, fmt::format("failed ({})", member->child->DescribeEnd()));
    }
    member->child.reset();
  }
}

/// The second Ctrl-C ends everything at once.
void Supervisor::Wait(milliseconds longest) {
  signals_.Wait(longest);
  if (signals_.num_interrupts() == num_interrupts_heeded_) return;
  if (signals_.num_interrupts() > 1) {
    for (const Member* member : All()) {
      if (member->child) member->child->Signal(SIGKILL);
    }
    Say("run_stack: killed");
    std::_Exit(EXIT_FAILURE);
  }
  num_interrupts_heeded_ = signals_.num_interrupts();
  if (is_ready_) Say("run_stack: finishing the map (Ctrl-C again: kill)");
}

bool Supervisor::CheckFolder() {
  if (folder_.IsInPlace()) return true;
  if (!failed_) {
    Say(fmt::format("run_stack: --out {}: this folder or its journal was removed, moved or replaced: the run ends",
                    folder_.path().string()));
  }
  failed_ = true;
  return false;
}

/// Says what went wrong with a process, and the end of its log if it has one. The run fails, if it needs the process.
void Supervisor::Report(const Member& member, const std::string& what) {
  failed_ = failed_ || member.plan.is_needed;
  Say(fmt::format("run_stack: {} {}{}", member.plan.name, what,
                  member.plan.is_needed ? "" : ": the mapping goes on without it"));
  SayLastLines(member.plan.command.log);
}

/// What the processes have to say of a disk that is full, or has become read-only, is in logs on it.
void Supervisor::LookAtDisk() {
  if (Clock::now() < next_look_at_disk_) return;
  next_look_at_disk_ = Clock::now() + seconds(5);
  const std::string why = folder_.WhyNotWritable();
  if (why.empty() == std::exchange(is_writable_, why.empty())) return;
  Say(why.empty()
          ? fmt::format("run_stack: --out {}: can be written again", folder_.path().string())
          : fmt::format("run_stack: --out {}: cannot be written: {}: mapping goes on, but its journal and its results "
                        "may end here",
                        folder_.path().string(), why));
}

/// Of what is live; the publisher of a log shows how far it is itself.
void Supervisor::ShowProgress() {
  if (Clock::now() < next_progress_) return;
  next_progress_ = Clock::now() + seconds(5);
  const auto outcome = ReadOutcome(folder_.summary());
  if (!outcome || outcome->counts == counts_shown_) return;
  counts_shown_ = outcome->counts;
  Say(fmt::format("run_stack: {} mapped, {}", FormatCount(outcome->counts.on_map, "scan"),
                  DescribeOthers(outcome->counts)));
}

/// What the selector says of the laser must not wait in its log until somebody looks there.
void Supervisor::PassOnComplaints() {
  PassOn("ray_selector", [](const std::string& line) { return line != "ray_selector: ready"; });
}

/// The same of breaks and joins, of a robot that is lost, and of scans that are left out.
void Supervisor::PassOnNews() {
  const auto PassOnLines = [this](const std::string& name, std::initializer_list<const char*> parts) {
    PassOn(name, [&](const std::string& line) {
      return std::any_of(parts.begin(), parts.end(),
                         [&](const char* part) { return line.find(part) != std::string::npos; });
    });
  };
  PassOnLines("map_updater", {kNewTrajectory, kMappedFrom, kLostSince, kFoundAgain, kMarkNews});
  PassOnLines("rrhc_matcher", {kUtimeRepeated, kToldBy});
}

void Supervisor::PassOn(const std::string& name, const std::function<bool(const std::string&)>& is_wanted) {
  const std::filesystem::path log = LogOf(name);
  std::streamoff& passed_on = passed_on_[name];
  if (SizeOf(log) <= static_cast<std::uintmax_t>(passed_on)) return;
  std::ifstream file = OpenLog(log);
  file.seekg(passed_on);
  for (std::string line; std::getline(file, line) && !file.eof();) {  // a line that is not whole yet comes later
    passed_on = file.tellg();
    if (line.starts_with(name + ": ") && is_wanted(line)) Say(line);
  }
}

std::filesystem::path Supervisor::LogOf(const std::string& name) const {
  for (const Member* service : services_) {
    if (service->plan.name == name) return service->plan.command.log;
  }
  return {};
}

std::vector<Member*> Supervisor::All() {
  std::vector<Member*> all = services_;
  if (publisher_) all.push_back(&*publisher_);
  return all;
}

}  // namespace crsm
