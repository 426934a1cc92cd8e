// A laser that is too fast, one that never ends, and how long a scan of a live one waits.

#include <algorithm>
#include <cmath>
#include <fstream>
#include <regex>
#include <thread>

#include "catch.hpp"
#include "faults.hpp"
#include "services/wire/conversions.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kAllScans = 1'000'000;
const std::vector<std::string> kServices{"map_updater", "loop_closer", "rrhc_matcher", "ray_selector", "map_exporter"};

/// By how much the memory of a process may grow once it has settled, however long it runs: 1 %, some pages, and LCM's
/// buffer for what it received, whose pages are taken when a queue first gets that long.
double MayGrow_mb(double settled_mb) { return std::max(0.01 * settled_mb, 0.3) + 0.2048; }

std::ptrdiff_t CountOpenFiles(pid_t pid) {
  return std::distance(fs::directory_iterator("/proc/" + std::to_string(pid) + "/fd"), fs::directory_iterator());
}

/// The number behind a word in a file of /proc.
double ReadNumber(const fs::path& file, const std::string& word) {
  std::smatch found;
  const std::string text = ReadFile(file);
  REQUIRE(std::regex_search(text, found, std::regex(word + "\\s*([0-9]+)")));
  return std::stod(found[1]);
}

/// The most memory that a process had so far.
double PeakMb(pid_t pid) { return ReadNumber("/proc/" + std::to_string(pid) + "/status", "VmHWM:") * 1024e-6; }

/// Datagrams that found a receive buffer full, on this machine since it was started. Not those that a filter kept
/// away, which the kernel counts as drops of their socket.
std::int64_t KernelDrops() {
  std::istringstream snmp(ReadFile("/proc/net/snmp"));
  std::vector<std::vector<std::string>> of_udp;  // a line of names, and one of values
  for (std::string line; std::getline(snmp, line);) {
    std::istringstream words(line);
    std::vector<std::string> row{std::istream_iterator<std::string>(words), {}};
    if (row[0] == "Udp:") of_udp.push_back(row);
  }
  const auto name = std::find(of_udp.at(0).begin(), of_udp[0].end(), "RcvbufErrors");
  return std::stoll(of_udp.at(1).at(static_cast<std::size_t>(name - of_udp[0].begin())));
}

constexpr std::ptrdiff_t kFilesOfAnExport = 6;  // that are open while it writes

// ---- soak

// Rooms that a laser of few beams tells apart: what is counted is scans, not beams.
constexpr const char* kRooms = R"(box 0 0 6 4
box 2 1 0.4 1.5
box 4.2 2.2 0.5 0.5
laser 360 90 10 10 0.01
speed 0.5 1
waypoint 1 0.7
waypoint 3.3 0.7
waypoint 3.3 3.3
waypoint 1 3.3
waypoint 1 0.8
)";

void Soak(bool stands, std::size_t num_scans) {
  constexpr double kExporterWrites_mb = 1.0;  // what its writing thread keeps of a picture, or not
  const TemporaryFolder folder;
  std::ofstream(folder / "rooms.world") << kRooms;
  std::vector<LaserScan> course = TakeScans("sim:" + (folder / "rooms.world").string(), kAllScans);
  if (stands) course.resize(1);
  // With loops memory grows with the path: keyframes are kept, each of some kilobytes.
  std::ofstream(folder / "soak.toml") << "export_period_s = 0.5\nloops = " << (stands ? "true" : "false") << '\n';
  Process stack = folder.StartStack(WriteToAndFro(folder, course, num_scans), "out", MakeBusUrl(),
                                    {"--config", folder / "soak.toml"});
  const auto CountMapped = [&] {
    const auto summary = nlohmann::json::parse(ReadFile(folder / "out/summary.json"), nullptr, false);
    return summary.is_object() ? summary.value("scans", std::size_t{0}) : 0;
  };
  struct Sample {
    double resident_mb;
    std::ptrdiff_t num_files;
  };
  std::map<std::string, std::vector<Sample>> samples;
  std::vector<std::string> programs = kServices;
  programs.push_back("laser_publisher");
  if (!stands) std::erase(programs, "loop_closer");
  // The map is complete, and what gathers while results are written has gathered.
  const std::size_t settled = std::max(num_scans * 2 / 5, 2 * course.size());
  for (std::size_t fifth = 0; fifth < 5; ++fifth) {
    const std::size_t at = settled + fifth * (num_scans - settled) / 5;
    REQUIRE(
        WaitUntil([&] { return CountMapped() >= at || !stack.IsRunning(); }, std::chrono::milliseconds(50), kLongRun));
    REQUIRE(stack.IsRunning());
    for (const std::string& program : programs) {
      const pid_t pid = FindChild(stack.pid(), program);
      samples[program].push_back({ResidentMb(pid), CountOpenFiles(pid)});
    }
  }
  CHECK(stack.AwaitExit(kLongRun) == 0);
  CHECK(folder.Summary("out")["scans"] == num_scans);
  fmt::print("{} scans of a robot that {}:\n", num_scans, stands ? "stands" : "drives to and fro");
  for (const auto& [program, of_program] : samples) {
    const Sample& first = of_program.front();
    const Sample& last = of_program.back();
    fmt::print("  {}: {:.2f} to {:.2f} MB, {} to {} files open\n", program, first.resident_mb, last.resident_mb,
               first.num_files, last.num_files);
    INFO(program);
    CHECK(last.resident_mb - first.resident_mb <=
          MayGrow_mb(first.resident_mb) + (program == "map_exporter" ? kExporterWrites_mb : 0.0));
    CHECK(last.num_files <= first.num_files + kFilesOfAnExport);
  }
}

// ---- overload

std::int64_t WallClock_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

/// Publishes as a driver does: each scan with the wall clock as its utime. The robot drives as fast as in lockstep, so
/// each of its scans is taken `times`. Returns how many were sent.
std::int64_t DriveLaser(const std::string& url, const std::vector<LaserScan>& scans, int times, double rate_hz,
                        std::chrono::seconds duration) {
  lcm::LCM lcm(url);
  const auto begin = Clock::now();
  std::int64_t num_sent = 0;
  std::int64_t last_utime = 0;
  while (Clock::now() < begin + duration) {
    const double elapsed_s = std::chrono::duration<double>(Clock::now() - begin).count();
    for (; static_cast<double>(num_sent) < elapsed_s * rate_hz; ++num_sent) {
      const std::size_t turn = 2 * scans.size() - 2;  // to and fro
      const std::size_t at = static_cast<std::size_t>(num_sent / times) % turn;
      bot_core::planar_lidar_t message = ToMessage(scans[std::min(at, turn - at)]);
      message.utime = last_utime = std::max(last_utime + 1, WallClock_us());
      lcm.publish(kLaserChannel, &message);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return num_sent;
}

/// A laser ten times as fast as scans are mapped with these keys of a configuration file.
void Overload(const std::string& keys) {
  constexpr int kOverload = 10;
  constexpr double kMostAge_s = 2.0;     // of a pose: when the laser stops, 20 scans still wait
  constexpr double kKeyframeMb = 0.003;  // range and angle of 270 beams, and what the graph knows of it
  constexpr double kLcmMb = 14.0;        // its buffer grows until it has held its longest queue: 10,000 scans of 1.4 KB
  const TemporaryFolder folder;
  const std::vector<std::string> flags{"--config", folder / "keys.toml"};
  std::ofstream(folder / "keys.toml") << keys;
  const std::vector<LaserScan> scans = TakeScans("sim:demo", kAllScans);
  // Of a longer log and a shorter one: a start takes longer than either.
  const auto Map = [&](std::size_t num_scans, const std::string& out) {
    const std::string log =
        folder.Write({scans.begin(), scans.begin() + static_cast<std::ptrdiff_t>(num_scans)}, "run.lcm");
    const auto begin = Clock::now();
    folder.MapWithStack(log, out, flags);
    return std::chrono::duration<double>(Clock::now() - begin).count();
  };
  const double rest_s = Map(3000, "sustained") - Map(1000, "sustained_third");
  REQUIRE(rest_s > 0.0);
  const double rate_hz = kOverload * 2000.0 / rest_s;

  const std::string url = MakeBusUrl();
  Stack stack({.url = url,
               .out = folder / "out",
               .flags = flags,
               .lockstep = false,
               .own_flags = {{"map_exporter", {"--export-period-s", "1"}}}});
  REQUIRE(stack.StartServices());
  TestBus bus(url);
  std::vector<double> ages_s;
  bus->Subscribe<bot_core::pose_t>(kPoseChannel, [&](const bot_core::pose_t& pose) {
    ages_s.push_back(1e-6 * static_cast<double>(WallClock_us() - pose.utime));
  });
  const auto AwaitSeconds = [&](std::chrono::duration<double> duration) {
    const auto end = Clock::now() + duration;
    REQUIRE(bus.Await([&] { return Clock::now() >= end; }));
  };
  struct Settled {
    double peak_mb;
    std::ptrdiff_t num_files;
  };
  std::map<std::string, Settled> settled;
  const std::int64_t drops_before = KernelDrops();
  const std::chrono::seconds duration(ByEffort(10, 60));
  std::int64_t num_sent = 0;
  std::jthread laser([&] { num_sent = DriveLaser(url, scans, kOverload, rate_hz, duration); });
  AwaitSeconds(duration / 2.0);
  for (const std::string& name : kServices) {
    settled[name] = {PeakMb(stack[name].pid()), CountOpenFiles(stack[name].pid())};
  }
  const std::int64_t keyframes_before = bus.Count("loop_closer.keyframes");
  AwaitSeconds(duration / 2.0);
  laser.join();
  std::map<std::string, double> peak_mb;
  for (const std::string& name : kServices) peak_mb[name] = PeakMb(stack[name].pid());
  const std::int64_t num_drops = KernelDrops() - drops_before;
  AwaitSeconds(std::chrono::seconds(3));  // what is under way is finished, and counted in a last status
  const std::int64_t num_keyframes = bus.Count("loop_closer.keyframes") - keyframes_before;

  fmt::print(
      "{} scans sent at {:.0f} Hz, {} mapped; {} packets lost by receive buffers of the kernel; age of the pose "
      "{:.0f} ms in the median, {:.0f} ms at most\n",
      num_sent, rate_hz, bus.Count("map_updater.handled"), num_drops, 1e3 * Percentile(ages_s, 0.5),
      1e3 * Percentile(ages_s, 1.0));
  std::int64_t num_sent_to_it = num_sent;
  for (const char* name : {"ray_selector", "rrhc_matcher", "map_updater"}) {
    const auto Of = [&](const std::string& counter) { return bus.Count(name + ("." + counter)); };
    const std::int64_t num_lost = num_sent_to_it - Of("received");
    fmt::print("  {}: {} sent to it, {} lost on the way, {} handled, {} dropped\n", name, num_sent_to_it, num_lost,
               Of("handled"), Of("dropped_overload"));
    INFO(name);
    CHECK(Of("received") == Of("handled") + Of("dropped_overload"));
    CHECK(num_lost >= 0);
    CHECK(num_lost <= num_drops);
    num_sent_to_it = Of("handled");
  }
  CHECK(num_sent > 3 * bus.Count("map_updater.handled"));  // it was too much
  CHECK(100 * bus.Count("map_updater.scan_missing") <= bus.Count("map_updater.handled"));
  CHECK(Percentile(ages_s, 1.0) <= kMostAge_s);
  for (const auto& [name, at_half] : settled) {
    INFO(name << ": " << at_half.peak_mb << " MB, then " << peak_mb[name] << " MB");
    const bool keeps_keyframes = name == "map_updater" || name == "loop_closer";
    CHECK(peak_mb[name] - at_half.peak_mb <=
          MayGrow_mb(at_half.peak_mb) + kLcmMb +
              (keeps_keyframes ? kKeyframeMb * static_cast<double>(num_keyframes) : 0.0));
    CHECK(CountOpenFiles(stack[name].pid()) <= at_half.num_files + kFilesOfAnExport);
  }
  CHECK(stack.Finish());
}

// ---- latency

/// Publishes scans as a laser of 10 Hz does. When each went out, by its utime.
std::map<std::int64_t, Clock::time_point> PublishLive(const std::string& url, std::span<const LaserScan> scans) {
  lcm::LCM lcm(url);
  std::map<std::int64_t, Clock::time_point> sent;
  auto next = Clock::now();
  for (const LaserScan& scan : scans) {
    std::this_thread::sleep_until(next);
    next += std::chrono::milliseconds(100);
    const bot_core::planar_lidar_t message = ToMessage(scan);
    sent[scan.utime] = Clock::now();
    lcm.publish(kLaserChannel, &message);
  }
  return sent;
}

/// The scans before `first` are mapped at leisure, those up to `end` live: how long each waits for its match, also
/// while a loop moves the poses.
void MeasureLatency(const std::string& name, const std::vector<LaserScan>& scans, std::size_t first, std::size_t end) {
  constexpr double kMostOf99_ms = 5.0;
  constexpr auto kSettled = std::chrono::seconds(1);      // before, the processes make sure whom to believe
  constexpr auto kDrawingAnew = std::chrono::seconds(3);  // after a loop has moved the poses
  constexpr auto kPeriod = std::chrono::milliseconds(100);
  constexpr double kMoved_m = 1e-4;  // how far the local frame goes, beyond rounding, where the map is corrected
  const TemporaryFolder folder;
  std::vector<std::string> flags{"--preset", "sick"};
  if (first > 0) {
    const std::span before = std::span(scans).first(first);
    folder.MapWithStack(folder.Write({before.begin(), before.end()}, "before.lcm"), "before", flags);
    flags.insert(flags.end(), {"--resume", folder / "before"});
  }
  const std::string url = MakeBusUrl();
  Process stack = folder.StartStack("live", "live", url, flags);
  REQUIRE(stack.AwaitSaid("listening"));
  Counters counters;
  Bus bus(url, "", counters);
  std::map<std::int64_t, Clock::time_point> matched;
  std::map<std::int64_t, Pose2> T_map_laser;
  std::optional<Pose2> T_map_local;
  std::vector<Clock::time_point> moved;
  bus.Subscribe<scan_match_t>(kScanMatchChannel,
                              [&](const scan_match_t& match) { matched.try_emplace(match.utime, Clock::now()); });
  bus.Subscribe<bot_core::pose_t>(kPoseChannel, [&](const bot_core::pose_t& pose) {
    T_map_laser[pose.utime] = FromMessage(pose).T_odom_robot.value();
  });
  bus.Subscribe<bot_core::pose_t>(kLocalPoseChannel, [&](const bot_core::pose_t& pose) {
    const auto in_map = T_map_laser.find(pose.utime);
    if (in_map == T_map_laser.end()) return;
    const Pose2 origin = in_map->second * Inverse(FromMessage(pose).T_odom_robot.value());
    if (T_map_local && Length({origin.x_m - T_map_local->x_m, origin.y_m - T_map_local->y_m, 0.0}) > kMoved_m) {
      moved.push_back(Clock::now());
    }
    T_map_local = origin;
  });
  std::map<std::int64_t, Clock::time_point> sent;
  std::atomic<bool> has_ended = false;
  std::jthread driver([&] {
    std::this_thread::sleep_for(std::chrono::seconds(1));  // all listen
    sent = PublishLive(url, std::span(scans).subspan(first, end - first));
    std::this_thread::sleep_for(std::chrono::seconds(1));
    has_ended = true;
  });
  while (!has_ended) bus.Wait(100);
  driver.join();
  CHECK(stack.Interrupt() == 0);

  const auto begin = sent.begin()->second + kSettled;
  std::size_t num_sent = 0;
  std::vector<double> all_ms, moving_ms;
  for (const auto& [utime, at] : sent) {
    if (at < begin) continue;
    ++num_sent;
    if (!matched.count(utime)) continue;
    all_ms.push_back(std::chrono::duration<double, std::milli>(matched[utime] - at).count());
    // The scan whose poses told that the map had moved was matched in the new map, so it went out before.
    if (std::any_of(moved.begin(), moved.end(),
                    [&, at = at](const auto& then) { return at > then - kPeriod && at < then + kDrawingAnew; })) {
      moving_ms.push_back(all_ms.back());
    }
  }
  CHECK(static_cast<double>(all_ms.size()) >= 0.999 * static_cast<double>(num_sent));
  for (const auto& [title, waits_ms] :
       {std::pair("all", all_ms), std::pair("while the map is drawn anew", moving_ms)}) {
    fmt::print(
        "{}, {}: {} scans, from LASER to SCAN_MATCH {:.2f} ms in the median, {:.2f} ms in 99 of 100, {:.2f} ms at "
        "most\n",
        name, title, waits_ms.size(), Percentile(waits_ms, 0.5), Percentile(waits_ms, 0.99), Percentile(waits_ms, 1.0));
    CHECK(Percentile(waits_ms, 0.99) < kMostOf99_ms);
  }
}

}  // namespace

TEST_CASE("soak", "[.][fault][soak]") {
  const std::size_t num_scans = ByEffort<std::size_t>(100'000, 200'000, 1'000'000);
  Soak(false, num_scans);
  Soak(true, 5 * num_scans);  // which take a moment each
}

TEST_CASE("overload", "[.][fault][overload]") {
  Overload("seed = 1\n");                             // as it is shipped
  Overload("cell_size_m = 0.02\nrays_max = 1000\n");  // a heavy match
}

TEST_CASE("latency", "[.][fault][latency]") {
  const std::vector<LaserScan> block = TakeScans("sim:block", kAllScans);
  MeasureLatency("sim:block", block, 0, block.size());
  if (ByEffort(true, false, false)) return;
  // Its last loops are closed after scan 15,700, 1.7 km from its start.
  const auto killian = FindRealLog("radish/killian.clf.gz");
  if (killian) MeasureLatency("killian", TakeScans(*killian, 16200), 15600, 16200);
}
