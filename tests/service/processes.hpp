#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/parameters.hpp"
#include "common/scan/laser_scan.hpp"
#include "services/bus/bus.hpp"

namespace crsm {

/// Longest wait for anything, many times what the slowest build on a busy machine takes: a test that fails is late, a
/// test that passes is not.
inline constexpr auto kPatience = std::chrono::seconds(120);

/// Looks every now and then whether `condition` holds. False if it did not within kPatience.
bool WaitUntil(const std::function<bool()>& condition, std::chrono::microseconds period = std::chrono::milliseconds(5));

/// A new folder, removed with all that is in it at the end.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// The whole file; empty if there is none.
std::string ReadFile(const std::filesystem::path& path);

/// A program that runs; killed at the end, if it still does. Its output goes to files in `logs`.
class Process {
 public:
  /// program: a name in the folder of the executables, or a path.
  Process(const std::string& program, const std::vector<std::string>& arguments, const std::filesystem::path& logs);
  ~Process();
  Process(const Process&) = delete;

  /// Whether the program has said that it is ready; false if it ended before.
  bool AwaitReady();
  void Signal(int signal) const;
  pid_t pid() const { return pid_; }
  bool IsRunning();
  /// The exit code, or 128 and the number of the signal that ended the program; -1 if it does not end.
  int AwaitExit();
  /// Asks the program to finish, and waits for its exit code.
  int Interrupt();

  std::string output() const { return ReadFile(output_); }
  std::string errors() const { return ReadFile(errors_); }
  double ResidentMb() const;

 private:
  std::filesystem::path output_;
  std::filesystem::path errors_;
  std::string name_;
  pid_t pid_ = -1;
  std::optional<int> exit_code_;
};

/// Runs a program to its end. Returns its exit code.
int Run(const std::string& program, const std::vector<std::string>& arguments, const std::filesystem::path& logs);

/// A bus of LCM that no other test has, also of other processes: a port of its own, because in LCM 1.3.1 another
/// address on the same port does not isolate. Messages do not leave the machine.
std::string MakeBusUrl();

/// The test's own place on a bus.
class TestBus {
 public:
  explicit TestBus(const std::string& url, const std::string& channel_prefix = "");

  Bus& operator*() { return bus_; }
  Bus* operator->() { return &bus_; }

  /// Handles messages until `condition` holds. False if it does not within kPatience.
  bool Await(const std::function<bool()>& condition);

 private:
  Counters counters_;
  Bus bus_;
};

/// Follows the map's version on a bus.
class MapWatcher {
 public:
  explicit MapWatcher(const std::string& url, const std::string& channel_prefix = "");
  bool AwaitVersion(std::int64_t version);
  bool AwaitScan(std::int64_t utime);

 private:
  TestBus bus_;
  std::int64_t version_ = 0;
  std::int64_t utime_ = -1;
};

/// The processes on one bus.
class Stack {
 public:
  struct Options {
    std::string url;
    std::filesystem::path out;
    std::vector<std::string> flags;  ///< for all of them
    bool lockstep = true;
  };
  explicit Stack(Options options);

  /// Starts a service, or starts it anew after a kill that leaves it no time for anything. False if it does not get
  /// ready.
  bool Start(const std::string& service);
  /// All but the publisher.
  bool StartServices();
  bool StartPublisher(const std::string& source, const std::string& rate);

  Process& operator[](const std::string& service) { return *processes_.at(service); }

  /// Waits for the publisher, if there is one, and ends all others, the exporter first. Whether all ended with success.
  bool Finish();

 private:
  Options options_;
  std::map<std::string, std::unique_ptr<Process>> processes_;
};

template <class Message>
std::vector<std::uint8_t> Encode(const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

/// Every `step`-th of the first scans of a source, `count` of them or what there is.
std::vector<LaserScan> TakeScans(const std::string& source, std::size_t count, std::size_t step = 1);

/// Writes scans to an LCM log that plays at the pace of their utimes.
void WriteScans(const std::vector<LaserScan>& scans, const std::filesystem::path& path);

/// What the programs compute with when they are started with these flags.
Parameters ParametersOf(const std::vector<std::string>& flags);

}  // namespace crsm
