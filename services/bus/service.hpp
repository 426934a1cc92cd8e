#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "services/base/process.hpp"
#include "services/base/status.hpp"
#include "services/bus/bus.hpp"
#include "services/bus/bus_role.hpp"
#include "services/settings/command_line.hpp"

namespace crsm {

/// The parameter of SERVICE_STATUS that names the map.
inline constexpr const char* kIdentityParameter = "identity";

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
  /// Which map a process owns, as the journal of the map has it (FormatIdentity), for SERVICE_STATUS; empty without
  /// one.
  void SetIdentity(const std::string& identity) { identity_ = identity; }
  /// How many scans the process got and could not use, for SERVICE_STATUS.
  /// But for those that it was too slow for, which are counted anyway.
  void SetNumLeftOut(std::int64_t num) { num_left_out_ = num; }
  /// One message was worked on since `start`.
  void RecordLatency(Clock::time_point start);

  /// Catches signals, handles messages, and calls `step` after each batch, until a signal asks to end. A step that
  /// returns true has no work left and is called again when messages have come, or after `period_ms`; else at once,
  /// after the messages that have come meanwhile.
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
  std::string identity_;
  std::int64_t num_left_out_ = 0;
  BusAddress address_;
  Bus bus_;
  std::optional<BusRole> role_;
  Clock::time_point next_status_;
};

}  // namespace crsm
