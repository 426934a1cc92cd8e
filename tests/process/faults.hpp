#pragma once

#include <fmt/core.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "processes.hpp"
#include "real_logs.hpp"

namespace crsm {

// What scripts/fault runs: hidden tests, each with the tag of its name.

/// How thorough: as CRSM_FAULT_EFFORT in the environment says, which is quick, long or nothing.
template <class Value>
Value ByEffort(Value quick, Value usual, Value long_) {
  const char* effort = std::getenv("CRSM_FAULT_EFFORT");
  const std::string said = effort ? effort : "";
  return said == "quick" ? quick : said == "long" ? long_ : usual;
}
inline std::size_t ByEffort(std::size_t quick, std::size_t usual) { return ByEffort(quick, usual, usual); }

/// Says why a test cannot run here; the test is to return.
void Skip(const std::string& reason);

/// A log, and the flags to map it with.
struct FaultCourse {
  std::string name;
  std::string log;
  std::vector<std::string> flags = {};
};

enum class Courses {
  kPlain,      ///< a simulated one and, where it is there, a real one
  kWithLoops,  ///< also one on which loops are closed
  kAll         ///< also one of a robot that is carried, and later goes on after a gap: trajectories that are joined
};
std::vector<FaultCourse> WriteCourses(const TemporaryFolder& folder, Courses which);

/// A log of a robot that drives to and fro on its course, so that it jumps nowhere; its path. One scan is that of a
/// robot that stands.
std::string WriteToAndFro(const TemporaryFolder& folder, const std::vector<LaserScan>& course, std::size_t num_scans);

std::uintmax_t JournalBytes(const std::filesystem::path& out);

/// Files that are not whole yet, of the process with this ending, or of any.
std::size_t CountHalfFiles(const std::filesystem::path& out, const std::string& ending = ".tmp");

/// Kills a process when a share of a run's journal is written.
struct Kill {
  double share = 0.0;
  std::string program;
};

/// Maps a course with the stack, and kills processes as the journal grows to `end_bytes`. None is killed twice while no
/// scan is mapped: run_stack gives up one that dies five times so. The log waits for a process that is to be killed and
/// is not there again, or it would end before the last are killed.
void MapAndKill(const TemporaryFolder& folder, const FaultCourse& course, const std::string& out,
                std::vector<Kill> kills, std::uintmax_t end_bytes);

/// A host with a network of its own while this lives.
class Host {
 public:
  explicit Host(const TemporaryFolder& folder);
  ~Host();
  Host(const Host&) = delete;

  int network() const { return network_; }
  pid_t pid() const { return idle_->pid(); }  ///< of a process in there
  /// What a shell's command prints there. The test fails where that does.
  std::string Run(const std::string& command) const;

 private:
  const TemporaryFolder& folder_;
  int network_ = -1;
  std::unique_ptr<Process> idle_;
};

/// Hosts on one bridge, each of which loses a share of the multicast packets that reach it: of single fragments, where
/// a message is larger than a packet of 1500 bytes.
class Hosts {
 public:
  Hosts(const TemporaryFolder& folder, std::size_t count, double lost_share = 0.0);

  const Host& operator[](std::size_t i) const { return *members_[i]; }
  /// Packets so far.
  std::int64_t CountLost() const;

 private:
  Host bridge_;
  std::vector<std::unique_ptr<Host>> members_;
};

/// Whether hosts can be made here, and where `lossy` ones that lose packets; says why not.
bool MayMakeHosts(bool lossy = false);

/// The `share` of values is below this.
double Percentile(std::vector<double> values, double share);

}  // namespace crsm
