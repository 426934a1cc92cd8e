#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/scan/scan_counts.hpp"
#include "services/run_stack/member.hpp"
#include "services/run_stack/results_folder.hpp"
#include "services/run_stack/signals.hpp"
#include "services/run_stack/stack_plan.hpp"
#include "services/run_stack/stack_viewer.hpp"

namespace crsm {

/// Starts the processes of a stack, watches them, starts again those that die, and ends them in their turn.
class Supervisor {
 public:
  /// viewer: was started already, and is watched and ended with the others; null for none.
  Supervisor(StackPlan plan, StackViewer* viewer, ResultsFolder& folder, Signals& signals);

  /// Until the publisher has published all, or somebody asks to end. Whether all went well; if not, why was said.
  bool Run();

 private:
  void Start(Member& member, bool resume, const std::vector<std::string>& own = {});
  bool WaitUntilReady(std::chrono::seconds patience);
  void WaitForEnd();
  bool StartAgain(Member& member);
  void ReviveAll();
  void Dismiss();
  void StopAll();
  void Stop(const std::vector<Member*>& members);

  void Wait(std::chrono::milliseconds longest);
  bool CheckFolder();
  bool IsInterrupted() const { return signals_.num_interrupts() > 0; }
  void Report(const Member& member, const std::string& what);
  void ShowProgress();
  void LookAtDisk();
  void PassOnComplaints();
  void PassOnNews();
  void PassOn(const std::string& name, const std::function<bool(const std::string&)>& is_wanted);
  std::filesystem::path LogOf(const std::string& name) const;
  std::vector<Member*> All();

  StackPlan plan_;
  ResultsFolder& folder_;
  Signals& signals_;
  StackViewer* viewer_;
  std::deque<Member> planned_;
  std::vector<Member*> services_;  ///< those, and the viewer
  std::optional<Member> publisher_;
  bool is_ready_ = false;  ///< all of them are, or were
  bool failed_ = false;
  int num_interrupts_heeded_ = 0;
  ScanCounts counts_shown_;
  std::map<std::string, std::streamoff> passed_on_;  ///< up to where the log of a service was passed on [bytes]
  std::chrono::steady_clock::time_point next_progress_{};
  std::chrono::steady_clock::time_point next_look_at_disk_{};
  bool is_writable_ = true;  ///< the folder, at the last look
};

}  // namespace crsm
