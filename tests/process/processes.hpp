#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/scan/laser_scan.hpp"
#include "services/bus/bus.hpp"
#include "wire_messages.hpp"

namespace crsm {

/// Longest wait for anything, many times what the slowest build on a busy machine takes: a test that fails is late, a
/// test that passes is not.
inline constexpr auto kPatience = std::chrono::seconds(120);
inline constexpr auto kLongRun = std::chrono::hours(2);  ///< for the end of a run, which may be of 100,000 scans

/// Looks every now and then whether `condition` holds. False if it did not within kPatience.
bool WaitUntil(const std::function<bool()>& condition, std::chrono::microseconds period = std::chrono::milliseconds(5),
               std::chrono::seconds patience = kPatience);

/// The whole file; empty if there is none.
std::string ReadFile(const std::filesystem::path& path);

/// The name, seen from the folder, and the content of every file in a folder and below.
std::map<std::string, std::string> ReadFolder(const std::filesystem::path& folder);

std::size_t CountLines(const std::string& text);

/// How often a text stands in another.
std::size_t CountOf(const std::string& wanted, const std::string& text);

/// Memory of a process [MB].
double ResidentMb(pid_t pid);

/// The process that runs below `parent` with this name; 0 if there is none.
pid_t FindChild(pid_t parent, const std::string& name);

/// A program that runs; killed at the end, if it still does. Its output goes to files in `logs`.
class Process {
 public:
  /// program: a name in the folder of the executables, or a path. network: a namespace to run in; -1: that of the test.
  Process(const std::string& program, const std::vector<std::string>& arguments, const std::filesystem::path& logs,
          int network = -1);
  ~Process();
  Process(const Process&) = delete;

  /// Whether the program has said that it is ready; false if it ended before.
  bool AwaitReady();
  void Signal(int signal) const;
  pid_t pid() const { return pid_; }
  bool IsRunning();
  /// The exit code, or 128 and the number of the signal that ended the program; -1 if it does not end.
  int AwaitExit(std::chrono::seconds patience = kPatience);
  /// Asks the program to finish, and waits for its exit code.
  int Interrupt();

  std::string output() const { return ReadFile(output_); }
  std::string errors() const { return ReadFile(errors_); }
  /// Whether it has said this on stderr, or says it before it ends.
  bool AwaitSaid(const std::string& text);
  double ResidentMb() const { return crsm::ResidentMb(pid_); }

 private:
  std::filesystem::path output_;
  std::filesystem::path errors_;
  std::string name_;
  pid_t pid_ = -1;
  std::optional<int> exit_code_;
};

/// How a program ended, and what it said.
struct Ended {
  int exit_code = 0;
  std::string output;
  std::string errors;
};

inline const std::vector<std::string> kMapFiles{"map.png", "map.yaml", "trajectory.tum"};

/// A new folder, the runs of programs whose files are in it, and a look at these. Removed with all that is in it at the
/// end, but for CRSM_KEEP_IN=DIR in the environment: then it is in there, and stays.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

  /// Writes scans to an LCM log that plays at the pace of their utimes. Its path.
  std::string Write(const std::vector<LaserScan>& scans, const std::string& name) const;
  /// Runs a program to its end. What it says is also in files in log/.
  Ended Run(const std::string& program, const std::vector<std::string>& arguments) const;
  /// Maps a log or a world in one process, or in the processes of run_stack on a bus of their own; the results are in
  /// `out`. The test fails where that does. With --view, the finished map is shown no longer than until it is there.
  Ended Map(const std::string& source, const std::string& out, std::vector<std::string> flags = {}) const;
  Ended MapWithStack(const std::string& source, const std::string& out, std::vector<std::string> flags = {}) const;
  /// run_stack, while it runs.
  Process StartStack(const std::string& source, const std::string& out, const std::string& url,
                     std::vector<std::string> flags = {}, int network = -1) const;

  nlohmann::json Summary(const std::string& out) const;
  /// Checks that the files of a run are there, and those of another to the last byte.
  void CheckSame(const std::string& out, const std::string& expected,
                 const std::vector<std::string>& files = kMapFiles) const;
  /// Checks that a program ends with this exit code and one line, which begins with its name and has `expected`.
  void CheckRefused(const std::string& program, const std::vector<std::string>& arguments, const std::string& expected,
                    int exit_code = 2) const;

 private:
  std::filesystem::path path_;
};

/// A bus of LCM that no other test has, also of other processes: a port of its own, because in LCM 1.3.1 another
/// address on the same port does not isolate. Messages do not leave the machine, unless `ttl` is more than 0.
std::string MakeBusUrl(int ttl = 0);

/// The test's own place on a bus.
class TestBus {
 public:
  explicit TestBus(const std::string& url, const std::string& channel_prefix = "");

  Bus& operator*() { return bus_; }
  Bus* operator->() { return &bus_; }

  /// Handles messages until `condition` holds. False if it does not within kPatience.
  bool Await(const std::function<bool()>& condition);

  /// A counter of a process, as "map_updater.handled", as the process told it last; 0 before.
  std::int64_t Count(const std::string& name) const;

 private:
  Counters counters_;
  Bus bus_;
  std::map<std::string, std::int64_t> told_;
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
    std::vector<std::string> flags = {};  ///< for all of them
    bool lockstep = true;
    std::filesystem::path logs = {};  ///< empty: log/ in `out`
    std::map<std::string, std::vector<std::string>> own_flags = {};
    std::map<std::string, std::string> urls = {};  ///< of those that are on a bus of their own
    std::map<std::string, int> networks = {};      ///< of those that are not in the test's own
  };
  explicit Stack(Options options);

  /// Starts a service, or starts it anew after a kill that leaves it no time for anything. False if it does not get
  /// ready.
  bool Start(const std::string& service, std::vector<std::string> arguments = {});
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

/// Every `step`-th of the first scans of a source, `count` of them or what there is.
std::vector<LaserScan> TakeScans(const std::string& source, std::size_t count, std::size_t step = 1,
                                 std::uint64_t seed = 1);

}  // namespace crsm
