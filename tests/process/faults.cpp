#include "faults.hpp"

#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <regex>
#include <thread>

#include "catch.hpp"
#include "services/wire/channels.hpp"
#include "services/wire/conversions.hpp"
#include "services/wire/event_log_writer.hpp"

namespace crsm {

namespace fs = std::filesystem;

void Skip(const std::string& reason) {
  fmt::print("skipped: {}\n", reason);
  ++num_skipped;
}

std::vector<FaultCourse> WriteCourses(const TemporaryFolder& folder, Courses which) {
  constexpr std::size_t kAllScans = 1'000'000;
  const std::vector<std::string> sick{"--preset", "sick"};
  const std::vector<LaserScan> demo = TakeScans("sim:demo", kAllScans);
  std::vector<FaultCourse> courses{{"demo", folder.Write(demo, "demo.lcm")}};
  if (const auto log = FindRealLog("radish/fr079.clf.gz")) {
    courses.push_back({"fr079", folder.Write(TakeScans(*log, kAllScans), "fr079.lcm"), sick});
  }
  if (which != Courses::kPlain) {
    courses.push_back({"block", folder.Write(TakeScans("sim:block", kAllScans), "block.lcm"), sick});
  }
  if (which == Courses::kAll) {
    const std::vector<LaserScan> other = TakeScans("sim:demo", kAllScans, 1, 2);
    struct Part {
      const std::vector<LaserScan>& drive;
      double begin, end;
      std::int64_t later_us;
    };
    std::vector<LaserScan> scans;
    for (const auto& [drive, begin, end, later_us] :
         {Part{demo, 0.0, 0.55, 0}, Part{other, 0.2, 0.6, 200'000}, Part{demo, 0.4, 1.0, 20'000'000}}) {
      const auto size = static_cast<double>(drive.size());
      const auto first = static_cast<std::size_t>(begin * size);
      const std::int64_t shift_us = scans.empty() ? 0 : scans.back().utime + later_us - drive[first].utime;
      for (std::size_t i = first; i < static_cast<std::size_t>(end * size); i += 3) {
        scans.push_back(drive[i]);
        scans.back().utime += shift_us;
      }
    }
    courses.push_back({"a robot that is carried", folder.Write(scans, "carried.lcm")});
  }
  return courses;
}

std::string WriteToAndFro(const TemporaryFolder& folder, const std::vector<LaserScan>& course, std::size_t num_scans) {
  constexpr std::int64_t kPeriod_us = 100'000;
  const std::string path = folder / "to_and_fro.lcm";
  EventLogWriter log(path);
  const std::size_t last = course.size() - 1;
  for (std::size_t i = 0; i < num_scans; ++i) {
    const std::size_t at = last == 0 ? 0 : i % (2 * last);
    LaserScan scan = course[std::min(at, 2 * last - at)];
    scan.utime = course.front().utime + static_cast<std::int64_t>(i) * kPeriod_us;
    log.Write(kLaserChannel, ToMessage(scan));
  }
  log.Flush();
  return path;
}

std::uintmax_t JournalBytes(const fs::path& out) {
  std::error_code absent;
  const std::uintmax_t size = fs::file_size(out / "journal/journal.lcm", absent);
  return absent ? 0 : size;
}

std::size_t CountHalfFiles(const fs::path& out, const std::string& ending) {
  std::size_t count = 0;
  for (const auto& entry : fs::directory_iterator(out)) count += entry.path().string().ends_with(ending);
  return count;
}

void MapAndKill(const TemporaryFolder& folder, const FaultCourse& course, const std::string& out,
                std::vector<Kill> kills, std::uintmax_t end_bytes) {
  std::sort(kills.begin(), kills.end(), [](const Kill& a, const Kill& b) { return a.share < b.share; });
  fs::remove_all(folder / out);
  Process stack = folder.StartStack(course.log, out, MakeBusUrl(), course.flags);
  std::map<std::string, std::uintmax_t> killed_at_bytes;
  for (const auto& [share, program] : kills) {
    const bool killed = WaitUntil(
        [&, &share = share, &program = program] {
          const std::uintmax_t bytes = JournalBytes(folder / out);
          const bool is_due =
              static_cast<double>(bytes) >= share * static_cast<double>(end_bytes) && bytes != killed_at_bytes[program];
          const pid_t pid = FindChild(stack.pid(), program);
          const pid_t publisher = FindChild(stack.pid(), "laser_publisher");
          if (publisher != 0) kill(publisher, is_due && pid == 0 ? SIGSTOP : SIGCONT);
          if (!is_due || pid == 0) return !stack.IsRunning();
          kill(pid, SIGKILL);
          killed_at_bytes[program] = bytes;
          return true;
        },
        std::chrono::milliseconds(1));
    INFO(program << " at " << share << '\n' << stack.errors());
    REQUIRE(killed);
    REQUIRE(stack.IsRunning());
  }
  const int exit_code = stack.AwaitExit(kLongRun);
  INFO(stack.errors());
  REQUIRE(exit_code == 0);
}

Host::Host(const TemporaryFolder& folder) : folder_(folder) {
  std::thread([this] {  // a thread has a network of its own, too
    if (unshare(CLONE_NEWNET) == 0) network_ = open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC);
  })
      .join();
  REQUIRE(network_ >= 0);
  idle_ = std::make_unique<Process>("/bin/sleep", std::vector<std::string>{"infinity"}, folder / "log", network_);
  Run("ip link set lo up");
}

Host::~Host() { close(network_); }

std::string Host::Run(const std::string& command) const {
  Process process("/bin/sh", {"-ec", "PATH=$PATH:/usr/sbin:/sbin; " + command}, folder_ / "log", network_);
  const int exit_code = process.AwaitExit();
  INFO(command << '\n' << process.errors());
  REQUIRE(exit_code == 0);
  return process.output();
}

Hosts::Hosts(const TemporaryFolder& folder, std::size_t count, double lost_share) : bridge_(folder) {
  bridge_.Run("ip link add br0 type bridge mcast_snooping 0; ip link set br0 up");
  for (std::size_t i = 0; i < count; ++i) {
    members_.push_back(std::make_unique<Host>(folder));
    const Host& member = *members_.back();
    bridge_.Run(fmt::format("ip link add port{0} type veth peer name eth0 netns {1}; ip link set port{0} master br0 up",
                            i, member.pid()));
    member.Run(fmt::format("ip addr add 10.77.0.{}/24 dev eth0; ip link set eth0 up; ip route add 224.0.0.0/4 dev eth0",
                           i + 1));
    if (lost_share == 0.0) continue;
    member.Run(fmt::format(
        "nft 'add table ip faults; add chain ip faults lose {{ type filter hook prerouting priority -450; }}; "
        "add rule ip faults lose ip daddr 239.0.0.0/8 numgen random mod 10000 < {:.0f} counter drop'",
        10000.0 * lost_share));
  }
}

std::int64_t Hosts::CountLost() const {
  std::int64_t count = 0;
  for (const auto& member : members_) {
    const std::string table = member->Run("nft list table ip faults");
    std::smatch found;
    REQUIRE(std::regex_search(table, found, std::regex("packets ([0-9]+)")));
    count += std::stoll(found[1]);
  }
  return count;
}

bool MayMakeHosts(bool lossy) {
  const TemporaryFolder folder;
  const std::string command =
      std::string("PATH=$PATH:/usr/sbin:/sbin; ip link add br0 type bridge") + (lossy ? "; nft list tables" : "");
  const bool may = geteuid() == 0 && folder.Run("/usr/bin/unshare", {"--net", "sh", "-ec", command}).exit_code == 0;
  if (!may) Skip(std::string("needs root and network namespaces with bridges (ip)") + (lossy ? ", and nft" : ""));
  return may;
}

double Percentile(std::vector<double> values, double share) {
  REQUIRE_FALSE(values.empty());
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

}  // namespace crsm
