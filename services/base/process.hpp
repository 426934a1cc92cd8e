#pragma once

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

/// To be called first: no file of ours takes the place of stdin, stdout or stderr where those are closed, and a file
/// that may grow no further (ulimit -f) is as a full disk.
void PrepareProcess();

/// Makes the folder for the results, if need be. What cannot be written is said before the work, not after it: throws
/// std::runtime_error that names --out, UsageError if there is none. Removes files that a killed process left half
/// written.
void PrepareFolder(const std::string& out);

/// With --strict, where the map is not to be trusted.
inline constexpr int kUntrustedExitCode = 3;

/// Runs `body` and turns an exception into one line on stderr. Returns the exit code: that of `body`, 2 after a
/// UsageError, 1 after any other exception.
int ReportErrors(const std::string& program, const std::function<int()>& body);

/// The main function of a process: catches signals, and ReportErrors of `body`, whose own exit code is 0.
int RunMain(const std::string& program, const std::function<void()>& body);

}  // namespace crsm
