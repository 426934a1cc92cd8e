#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "services/runtime/bus.hpp"
#include "services/runtime/bus_role.hpp"
#include "services/runtime/command_line.hpp"
#include "services/runtime/status.hpp"

namespace crsm {

using Clock = std::chrono::steady_clock;

/// From now on SIGINT and SIGTERM only ask the process to finish.
void CatchSignals();
bool StopRequested();

/// Makes the folder for the results, if need be. What cannot be written is said before the work, not after it: throws
/// std::runtime_error that names --out, UsageError if there is none. Removes files that a killed process left half
/// written.
void PrepareFolder(const std::string& out);

/// Says a line on stderr. A log that cannot be written, on a full disk say, is no reason to stop.
void Say(const std::string& line);

/// A number that no other process draws, not 0. Nothing that is computed depends on it.
std::int64_t DrawIdentity();

/// What to say when the map has no room for more tiles.
inline constexpr const char* kMapIsFull =
    "the map has its largest size; everything beyond it is left out; larger cells (--cell-size-m) cover more";

/// What every process is around its own work: a bus, counters, a status once a second, an end on request.
class Service {
 public:
  explicit Service(const CommandLine& command_line);

  Bus& bus() { return bus_; }
  Counters& counters() { return counters_; }

  /// Counts a trouble, and says a line about it the first time.
  void Complain(const std::string& counter, const std::string& line);

  /// From now on no other process on this machine has this role on the bus and with the channel prefix of this one.
  /// Throws std::runtime_error that names the one that has it.
  void TakeRole(const std::string& role) { role_.emplace(address_, role); }

  /// What the process does or waits for, in words, for SERVICE_STATUS.
  void SetState(const std::string& state) { state_ = state; }
  /// One message was worked on since `start`.
  void RecordLatency(Clock::time_point start);

  /// Handles messages, and calls `step` after each batch, until a signal asks to end. A step that returns true has no
  /// work left and is called again when messages have come, or after `period_ms`; else at once, after the messages that
  /// have come meanwhile.
  void Run(const std::function<bool()>& step, int period_ms = 50);

  /// One turn of Run, for those with a loop of their own.
  void Spin(int timeout_ms);
  void PublishStatus();

  const std::string& name() const { return name_; }
  crsm::service_status_t MakeStatus() const;

 private:
  std::string name_;
  std::vector<std::pair<std::string, std::string>> parameters_;  ///< name and value, as they are published
  Counters counters_;
  Latency latency_;
  std::string state_ = "waiting for messages";
  BusAddress address_;
  Bus bus_;
  std::optional<BusRole> role_;
  Clock::time_point next_status_;
};

/// With --strict, where the map is not to be trusted.
inline constexpr int kUntrustedExitCode = 3;

/// Runs `body` and turns an exception into one line on stderr. Returns the exit code: that of `body`, 2 after a
/// UsageError, 1 after any other exception.
int ReportErrors(const std::string& program, const std::function<int()>& body);

/// The main function of a process: catches signals, and ReportErrors of `body`, whose own exit code is 0.
int RunMain(const std::string& program, const std::function<void()>& body);

}  // namespace crsm
