// Disks that are full, cannot be written or lose what was written, and writers that are killed: the path is named,
// older files stay whole, and mapping goes on.

#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <thread>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "faults.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kFiles{"map.png", "trajectory.tum"};

/// A small disk of its own.
class Disk {
 public:
  Disk(const fs::path& path, int size_kb) : path_(path) {
    fs::create_directories(path);
    REQUIRE(mount("tmpfs", path.c_str(), "tmpfs", 0, fmt::format("size={}k", size_kb).c_str()) == 0);
  }
  ~Disk() { umount2(path_.c_str(), MNT_DETACH); }
  Disk(const Disk&) = delete;

  void Remount(unsigned long flags, const std::string& options = "") const {
    REQUIRE(mount(nullptr, path_.c_str(), nullptr, MS_REMOUNT | flags, options.c_str()) == 0);
  }

  /// Takes all the room that is left, also behind the ends of `others`. Returns the file that does.
  fs::path Fill(const std::vector<fs::path>& others = {}) const {
    const auto Append = [](const fs::path& file, const std::string& block) {
      for (std::ofstream out(file, std::ios::app); out.write(block.data(), std::ssize(block)).flush();) continue;
    };
    Append(path_ / "ballast", std::string(4096, '.'));
    for (const fs::path& other : others) Append(other, ".");
    return path_ / "ballast";
  }

 private:
  fs::path path_;
};

/// Whether the results are whole, as WriteResults makes them.
void CheckWhole(const fs::path& out) {
  for (const char* name : {"map.png", "overview.png"}) CHECK(ReadFile(out / name).ends_with("IEND\xae\x42\x60\x82"));
  std::istringstream trajectory(ReadFile(out / "trajectory.tum"));
  for (std::string line; std::getline(trajectory, line);) CHECK(std::count(line.begin(), line.end(), ' ') == 7);
  CHECK(nlohmann::json::accept(ReadFile(out / "summary.json")));
}

using FileNumbers = std::map<std::string, ino_t>;

/// Of the results that are replaced; trajectory.tum grows.
FileNumbers NumbersOf(const fs::path& out) {
  FileNumbers numbers;
  for (const char* name : {"map.png", "map.yaml", "overview.png", "summary.json"}) {
    struct stat status {};
    REQUIRE(stat((out / name).c_str(), &status) == 0);
    numbers[name] = status.st_ino;
  }
  return numbers;
}

std::uintmax_t FolderBytes(const fs::path& folder) {
  std::uintmax_t num = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) num += entry.file_size();
  }
  return num;
}

/// Whether all the results are other files than before, or none, or all but those of a map that is the same.
bool AreWrittenTogether(const FileNumbers& before, const FileNumbers& now) {
  const auto IsNew = [&](const char* name) { return before.at(name) != now.at(name); };
  return IsNew("overview.png") == IsNew("summary.json") && IsNew("map.png") == IsNew("map.yaml") &&
         (!IsNew("map.png") || IsNew("overview.png"));
}

/// A log of many scans, its map, and flags with which results are written all the time.
struct LongRun {
  TemporaryFolder folder;
  std::string log =
      WriteToAndFro(folder, TakeScans("sim:demo", 1'000'000), ByEffort<std::size_t>(30'000, 120'000, 120'000));
  std::vector<std::string> flags{"--config", folder / "often.toml"};

  LongRun() {
    std::ofstream(folder / "often.toml") << "export_period_s = 0.1\n";
    folder.MapWithStack(log, "undisturbed");
  }
  Process Start(const std::string& out, const std::string& url = MakeBusUrl()) const {
    return folder.StartStack(log, out, url, flags);
  }
  void AwaitResults(const std::string& out) const {
    REQUIRE(WaitUntil([&] { return fs::exists(folder / out / "summary.json"); }));
  }
};

/// For a second, or until the exporter has met it: it writes as seldom as that is dear.
void FillDiskForAWhile(const LongRun& run) {
  constexpr std::uintmax_t kRoom_bytes = 40'000;  // map.png needs 16,000, the overview 180,000, a new scan 65
  const TemporaryFolder& folder = run.folder;
  const Disk disk(folder / "full", 200'000);
  const std::string url = MakeBusUrl();
  TestBus bus(url);
  Process stack = run.Start("full/out", url);
  run.AwaitResults("full/out");
  const fs::path out = folder / "full/out";
  std::map<std::string, pid_t> pids;
  for (const char* name : {"map_updater", "loop_closer", "rrhc_matcher", "ray_selector", "map_exporter"}) {
    pids[name] = FindChild(stack.pid(), name);
  }
  std::vector<fs::path> logs;
  for (const auto& entry : fs::directory_iterator(out / "log")) {
    if (entry.path().extension() == ".log") logs.push_back(entry.path());
  }
  const fs::path ballast = disk.Fill(logs);
  // When the journal has ended, the room that follows is for some of the results, but not for all.
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  fs::resize_file(ballast, fs::file_size(ballast) - kRoom_bytes);
  FileNumbers numbers = NumbersOf(out);
  for (int i = 0; i < 10 || bus.Count("map_exporter.write_failed") == 0; ++i) {
    REQUIRE(stack.IsRunning());
    const auto next = std::chrono::steady_clock::now() + std::chrono::milliseconds(100);
    REQUIRE(bus.Await([&] { return std::chrono::steady_clock::now() >= next; }));
    CheckWhole(out);
    if (!AreWrittenTogether(numbers, NumbersOf(out))) {  // they were just being replaced: not twice in a row
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      CHECK(AreWrittenTogether(numbers, NumbersOf(out)));
    }
    numbers = NumbersOf(out);
  }
  for (const auto& [name, pid] : pids) CHECK(FindChild(stack.pid(), name) == pid);
  fs::remove(ballast);
  CHECK(stack.AwaitExit(kLongRun) == 0);
  folder.CheckSame("full/out", "undisturbed", kFiles);
  const nlohmann::json counts = folder.Summary("full/out")["counts"];
  CHECK(counts.value("map_exporter.write_failed", 0) > 0);
  CHECK(counts.value("map_updater.journal_failed", 0) == 1);
}

/// The disk of a run that fills up and stays full, at a random scan: the run says so, no verdict is that of a part of
/// it, and what its journal has is gone on from when there is room. Returns whether there was a verdict.
bool FillDiskForGood(const std::string& program, const std::string& log, int size_kb, const TemporaryFolder& folder) {
  const Disk disk(folder / "full", size_kb);
  std::vector<std::string> arguments{log, "--out", folder / "full/out"};
  if (program == "run_stack") arguments.insert(arguments.end(), {"--lcm-url", MakeBusUrl()});
  const std::int64_t num_scans = folder.Summary("undisturbed_short")["scans"];
  const Ended ended = folder.Run(program, arguments);
  INFO(program << " on a disk of " << size_kb << " kB: " << ended.output << ended.errors);
  const bool has_verdict = ended.output.find("the map is ") != std::string::npos;
  if (has_verdict) {
    CHECK(ended.output.find(fmt::format("{} of {} scans", num_scans, num_scans)) != std::string::npos);
    CHECK(folder.Summary("full/out")["scans"] == num_scans);
  }
  const bool is_named = ended.errors.find("No space left") != std::string::npos;
  CHECK((ended.exit_code == 0 ? has_verdict : is_named));
  disk.Remount(0, "size=200m");
  if (!fs::exists(folder / "full/out/journal/journal.lcm")) return has_verdict;  // there was no room for a beginning
  arguments.insert(arguments.end(), {"--resume", folder / "full/out"});
  const Ended resumed = folder.Run(program, arguments);
  INFO("then: " << resumed.output << resumed.errors);
  CHECK(resumed.exit_code == 0);
  CHECK(folder.Summary("full/out")["ended"] == true);
  CHECK(folder.Summary("full/out")["scans"] == num_scans);
  return has_verdict;
}

/// Only the results, or only the journal, are on the full disk: the log says so.
void FillDiskOfOne(const std::string& log, const TemporaryFolder& folder) {
  for (const std::string service : {"map_exporter", "map_updater"}) {
    const std::string path = folder / "small";
    const Disk disk(path, 400);
    const bool of_results = service == "map_exporter";
    fs::remove_all(folder / "results");
    const std::string out = of_results ? "small" : "results";
    Stack stack({.url = MakeBusUrl(),
                 .out = folder / out,
                 .logs = folder / "log",
                 .own_flags = {{"map_exporter", {"--export-period-s", "0.1"}},
                               {"map_updater", {"--journal", of_results ? (folder / "journal").string() : path}}}});
    if (of_results) disk.Fill();
    REQUIRE(stack.StartServices());
    REQUIRE(stack.StartPublisher(log, "max"));
    REQUIRE(stack["laser_publisher"].AwaitExit() == 0);
    if (of_results) {
      fs::remove(path + "/ballast");
      disk.Remount(0, "size=4000k");
    }
    CHECK(stack.Finish());
    folder.CheckSame(out, "undisturbed_short", kFiles);
    const std::string said = stack[service].errors();
    INFO(said);
    const std::size_t at = said.find(path);
    REQUIRE(at != std::string::npos);
    CHECK(said.substr(at, said.find('\n', at) - at).find("No space left") != std::string::npos);
  }
}

void KillWriter(const LongRun& run) {
  const TemporaryFolder& folder = run.folder;
  Process stack = run.Start("interrupted");
  run.AwaitResults("interrupted");
  const fs::path out = folder / "interrupted";
  const pid_t publisher = FindChild(stack.pid(), "laser_publisher");
  const auto AwaitExporter = [&](pid_t other) {
    pid_t pid = 0;
    REQUIRE(WaitUntil([&] { return (pid = FindChild(stack.pid(), "map_exporter")) != 0 && pid != other; }));
    return pid;
  };
  Random random(2);
  std::size_t num_torn = 0;
  pid_t pid = 0;
  for (int i = 0; i < ByEffort(6, 20, 20); ++i) {
    pid = AwaitExporter(pid);
    REQUIRE(FindChild(stack.pid(), "laser_publisher") == publisher);  // the run goes on
    const std::string half = fmt::format(".{}.tmp", pid);
    if (i % 2 == 1) {
      REQUIRE(WaitUntil([&] { return CountHalfFiles(out, half) > 0; }, std::chrono::microseconds(0)));
    } else {
      std::this_thread::sleep_for(std::chrono::duration<double>(random.Uniform(0.0, 0.3)));
    }
    kill(pid, SIGKILL);
    REQUIRE(WaitUntil([&] { return FindChild(stack.pid(), "map_exporter") != pid; }));
    num_torn += CountHalfFiles(out, half) > 0;
    CheckWhole(out);
  }
  CHECK(num_torn > 0);
  CHECK(stack.AwaitExit(kLongRun) == 0);
  folder.CheckSame("interrupted", "undisturbed", kFiles);
  CHECK(CountHalfFiles(out) == 0);
}

void RefuseUnwritable(const TemporaryFolder& folder) {
  const std::string path = folder / "read_only";
  const Disk disk(path, 1000);
  disk.Remount(MS_RDONLY);
  for (const std::string& at : {path, path + "/below"}) {
    folder.CheckRefused("map_exporter", {"--out", at, "--lcm-url", MakeBusUrl()}, at, 1);
    folder.CheckRefused("map_updater", {"--journal", at, "--lcm-url", MakeBusUrl()}, at, 1);
    folder.CheckRefused("run_stack", {"sim:demo", "--out", at, "--lcm-url", MakeBusUrl()}, at, 1);
  }
  const std::string missing = folder / "missing/a/b";
  Process updater("map_updater", {"--journal", missing + "/journal", "--lcm-url", MakeBusUrl()}, folder / "log");
  Process exporter("map_exporter", {"--out", missing + "/out", "--lcm-url", MakeBusUrl()}, folder / "log");
  for (Process* process : {&updater, &exporter}) {
    CHECK(process->AwaitReady());
    CHECK(process->Interrupt() == 0);
  }
  CHECK(fs::exists(missing + "/journal/journal.lcm"));
  CHECK(fs::exists(missing + "/out/map.png"));
}

}  // namespace

TEST_CASE("files", "[.][fault][files]") {
  if (geteuid() != 0) return Skip("needs root, to mount small disks");
  const LongRun run;
  FillDiskForAWhile(run);
  fmt::print("a disk of results, journal and logs that is full for a while: every service lives, same map\n");
  const std::string log = run.folder.Write(TakeScans("sim:demo", 1'000'000), "short.lcm");
  run.folder.MapWithStack(log, "undisturbed_short");
  Random random(7);
  const auto room_kb = static_cast<double>(FolderBytes(run.folder / "undisturbed_short")) / 1000.0;
  int num_verdicts = 0;
  const auto num_disks = static_cast<int>(ByEffort(6, 50));
  for (int i = 0; i < num_disks; ++i) {
    const int size_kb = static_cast<int>(random.Uniform(0.05, 1.1) * room_kb);
    num_verdicts += FillDiskForGood(i % 2 == 0 ? "run_stack" : "slam_offline", log, size_kb, run.folder);
  }
  fmt::print("{} disks that become full for good: {} runs with room for all, no verdict on a part of the others\n",
             num_disks, num_verdicts);
  FillDiskOfOne(log, run.folder);
  fmt::print("a full disk of the results, or of the journal, alone: it is named, same map\n");
  KillWriter(run);
  fmt::print("an exporter that is killed while it writes: files always whole, same map\n");
  RefuseUnwritable(run.folder);
  fmt::print("folders that cannot be written are refused, those that are missing are made\n");
}
