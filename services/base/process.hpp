#pragma once

#include <signal.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

#include "common/logs/stop_request.hpp"
#include "services/base/identity.hpp"
#include "services/base/say.hpp"

namespace crsm {

using Clock = std::chrono::steady_clock;

/// By the clock on the wall [us since 1970].
std::int64_t UtimeNow();

/// From now on SIGINT, SIGTERM and SIGHUP, the end of the terminal, only ask the process to finish: StopRequested.
void CatchSignals();

/// Whether that was asked for more than once, a moment apart: what need not be waited for is left.
bool HurryRequested();

/// While it lives, the same signals end the process at once, whatever it does, with a line on stderr and the exit code
/// 0: for what takes long and would leave nothing behind, such as reading a journal or a name server that is silent.
/// Then they do again what they did before. Ends the process where it was asked for before. Not within another one.
class EndsAtOnce {
 public:
  /// line: at most 1000 bytes of it are said.
  explicit EndsAtOnce(const std::string& line);
  ~EndsAtOnce();
  EndsAtOnce(const EndsAtOnce&) = delete;

 private:
  std::array<struct sigaction, 3> before_;
};

/// To be called first: no file of ours takes the place of stdin, stdout or stderr where those are closed, and a file
/// that may grow no further (ulimit -f) is as a full disk.
void PrepareProcess();

/// Makes the folder for the results, if need be. What cannot be written is said before the work, not after it: throws
/// std::runtime_error that names --out, UsageError if there is none. Removes files that a killed process left half
/// written.
void PrepareFolder(const std::string& out);

/// With --strict, where the map is not to be trusted.
inline constexpr int kUntrustedExitCode = 3;

/// With --changes-over, where something as large has come or gone since the map was made.
inline constexpr int kChangedExitCode = 4;

/// Runs `body` and turns an exception into one line on stderr. Returns the exit code: that of `body`, 0 after Stopped,
/// 2 after a UsageError, 1 after any other exception.
int ReportErrors(const std::string& program, const std::function<int()>& body);

/// The main function of a process: ReportErrors of `body`, whose own exit code is 0. Signals end the process at once
/// until `body` calls CatchSignals, when there is something to finish.
int RunMain(const std::string& program, const std::function<void()>& body);

}  // namespace crsm
