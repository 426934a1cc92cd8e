#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "services/run_stack/member.hpp"
#include "services/run_stack/signals.hpp"

namespace crsm {

/// The map_viewer of a stack. It shows the live robot from before the first scan on, and at the end the finished run.
/// Its port and its token stay the same, so that an open page finds it again.
class StackViewer {
 public:
  /// Starts it and says where the map is to be seen. Waits until it is ready or has ended, 10 s at most.
  explicit StackViewer(const PlannedService& plan);

  /// To be watched and, if need be, started again.
  Member& member() { return member_; }

  /// Says the addresses that it has said since it was started last, if they are others than before. The next start
  /// takes the same port.
  void SayAddresses();

  /// Whether a page can have been opened.
  bool has_address() const { return !said_.empty(); }

  /// Starts it on the finished run in `out`, in the place of the live robot. Returns at the next signal that asks this
  /// process to end, or when the viewer has ended, and why was said.
  void ShowFinished(const std::filesystem::path& out, Signals& signals);

 private:
  std::string& http();

  Member member_;
  std::string address_;         ///< the first of those that were said last
  std::set<std::string> said_;  ///< addresses
};

}  // namespace crsm
