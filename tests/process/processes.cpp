#include "processes.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sched.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>

#include "catch.hpp"
#include "services/sources/open_laser_source.hpp"
#include "services/wire/conversions.hpp"
#include "services/wire/event_log_writer.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// A number that this process has not used yet.
int NextNumber() {
  static std::atomic<int> number = 0;
  return number++;
}

/// Whether no other test on this machine has the port; then it is this process's until its end.
bool LockPort(int port) {
  const fs::path folder = fs::temp_directory_path() / fmt::format("crsm_test_ports_{}", getuid());
  fs::create_directories(folder);
  const int descriptor = open((folder / std::to_string(port)).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (descriptor < 0) throw std::runtime_error(folder.string() + ": no file can be opened there");
  if (flock(descriptor, LOCK_EX | LOCK_NB) == 0) return true;
  close(descriptor);
  return false;
}

[[noreturn]] void Execute(const char* path, char* const* arguments, const char* output, const char* errors,
                          int network) {
  if (network >= 0 && setns(network, CLONE_NEWNET) != 0) _exit(127);
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // a test run that is killed leaves nothing behind
  signal(SIGINT, SIG_DFL);           // ignored, where the tests run in the background
  dup2(open("/dev/null", O_RDONLY), STDIN_FILENO);
  dup2(open(output, O_WRONLY | O_CREAT | O_TRUNC, 0666), STDOUT_FILENO);
  dup2(open(errors, O_WRONLY | O_CREAT | O_TRUNC, 0666), STDERR_FILENO);
  close_range(3, ~0u, 0);  // a socket of the test's would live on in the program
  execv(path, arguments);
  _exit(127);
}

}  // namespace

bool WaitUntil(const std::function<bool()>& condition, std::chrono::microseconds period,
               std::chrono::seconds patience) {
  const auto give_up = Clock::now() + patience;
  while (!condition()) {
    if (Clock::now() >= give_up) return false;
    std::this_thread::sleep_for(period);
  }
  return true;
}

std::string ReadFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::map<std::string, std::string> ReadFolder(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files[fs::relative(entry.path(), folder).string()] = ReadFile(entry.path());
  }
  return files;
}

std::size_t CountLines(const std::string& text) { return CountOf("\n", text); }

std::size_t CountOf(const std::string& wanted, const std::string& text) {
  std::size_t count = 0;
  for (auto at = text.find(wanted); at != std::string::npos; at = text.find(wanted, at + 1)) ++count;
  return count;
}

double ResidentMb(pid_t pid) {
  std::ifstream statm(fmt::format("/proc/{}/statm", pid));
  double total_pages = 0.0;
  double resident_pages = 0.0;
  statm >> total_pages >> resident_pages;
  return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

pid_t FindChild(pid_t parent, const std::string& name) {
  std::ifstream children(fmt::format("/proc/{0}/task/{0}/children", parent));
  for (pid_t pid = 0; children >> pid;) {
    std::ifstream stat(fmt::format("/proc/{}/stat", pid));
    std::string state;  // "pid (name) state ..."; empty where the child has just ended
    std::getline(stat, state);
    if (state.find(fmt::format("({}) ", name.substr(0, 15))) != std::string::npos &&
        state.find(") Z ") == std::string::npos) {
      return pid;
    }
  }
  return 0;
}

Process::Process(const std::string& program, const std::vector<std::string>& arguments, const fs::path& logs,
                 int network) {
  const fs::path path = program.find('/') == std::string::npos ? fs::path(CRSM_BIN_DIR) / program : fs::path(program);
  name_ = path.filename().string();
  const int number = NextNumber();
  fs::create_directories(logs);
  output_ = logs / fmt::format("{}.{}.out", name_, number);
  errors_ = logs / fmt::format("{}.{}.err", name_, number);

  std::vector<char*> argv{const_cast<char*>(path.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  // Once: other threads may read the environment. A freed block that AddressSanitizer keeps would look like a leak.
  static const bool is_set =
      setenv("ASAN_OPTIONS", "quarantine_size_mb=1", 0) == 0 && setenv("CRSM_BIN_DIR", CRSM_BIN_DIR, 1) == 0;
  if (!is_set) throw std::runtime_error("the environment cannot be set");
  pid_ = fork();
  if (pid_ == 0) Execute(path.c_str(), argv.data(), output_.c_str(), errors_.c_str(), network);
  if (pid_ < 0) throw std::runtime_error("no process can be started");
}

Process::~Process() {
  if (!IsRunning()) return;
  Signal(SIGKILL);
  AwaitExit();
}

bool Process::AwaitReady() { return AwaitSaid(name_ + ": ready\n"); }

void Process::Signal(int signal) const { kill(pid_, signal); }

bool Process::IsRunning() {
  int status = 0;
  if (!exit_code_ && waitpid(pid_, &status, WNOHANG) == pid_) {
    exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  return !exit_code_;
}

int Process::AwaitExit(std::chrono::seconds patience) {
  WaitUntil([this] { return !IsRunning(); }, std::chrono::milliseconds(5), patience);
  return exit_code_.value_or(-1);
}

bool Process::AwaitSaid(const std::string& text) {
  const auto HasSaid = [&] { return errors().find(text) != std::string::npos; };
  return WaitUntil([&] { return HasSaid() || !IsRunning(); }) && HasSaid();
}

int Process::Interrupt() {
  Signal(SIGINT);
  return AwaitExit();
}

TemporaryFolder::TemporaryFolder() {
  const char* keep = std::getenv("CRSM_KEEP_IN");
  path_ = (keep ? fs::absolute(keep) : fs::temp_directory_path()) /
          fmt::format("crsm_process_tests_{}_{}", getpid(), NextNumber());
  fs::remove_all(path_);
  fs::create_directories(path_);
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  if (!std::getenv("CRSM_KEEP_IN")) fs::remove_all(path_, ignored);
}

std::string TemporaryFolder::Write(const std::vector<LaserScan>& scans, const std::string& name) const {
  EventLogWriter log(path_ / name);
  for (const LaserScan& scan : scans) log.Write(kLaserChannel, ToMessage(scan));
  log.Flush();
  return path_ / name;
}

Ended TemporaryFolder::Run(const std::string& program, const std::vector<std::string>& arguments) const {
  Process process(program, arguments, path_ / "log");
  const int exit_code = process.AwaitExit(kLongRun);
  return {exit_code, process.output(), process.errors()};
}

Ended TemporaryFolder::Map(const std::string& source, const std::string& out, std::vector<std::string> flags) const {
  flags.insert(flags.begin(), {source, "--out", path_ / out});
  Ended ended = Run("slam_offline", flags);
  INFO(ended.errors);
  REQUIRE(ended.exit_code == 0);
  return ended;
}

Ended TemporaryFolder::MapWithStack(const std::string& source, const std::string& out,
                                    std::vector<std::string> flags) const {
  const bool view = std::find(flags.begin(), flags.end(), "--view") != flags.end();
  Process stack = StartStack(source, out, MakeBusUrl(), std::move(flags));
  if (view && stack.AwaitSaid("run_stack: the map stays at ")) stack.Signal(SIGINT);
  const int exit_code = stack.AwaitExit(kLongRun);
  INFO(stack.errors());
  REQUIRE(exit_code == 0);
  return {exit_code, stack.output(), stack.errors()};
}

Process TemporaryFolder::StartStack(const std::string& source, const std::string& out, const std::string& url,
                                    std::vector<std::string> flags, int network) const {
  flags.insert(flags.begin(), {source, "--out", path_ / out, "--lcm-url", url});
  return Process("run_stack", flags, path_ / "log", network);
}

nlohmann::json TemporaryFolder::Summary(const std::string& out) const {
  return nlohmann::json::parse(ReadFile(path_ / out / "summary.json"));
}

void TemporaryFolder::CheckSame(const std::string& out, const std::string& expected,
                                const std::vector<std::string>& files) const {
  for (const std::string& file : files) {
    INFO(path_ / out / file);
    const std::string content = ReadFile(path_ / out / file);
    CHECK_FALSE(content.empty());
    CHECK((content == ReadFile(path_ / expected / file)));  // without printing them
  }
}

void TemporaryFolder::CheckRefused(const std::string& program, const std::vector<std::string>& arguments,
                                   const std::string& expected, int exit_code) const {
  const Ended ended = Run(program, arguments);
  INFO(program << ' ' << Catch::Detail::stringify(arguments) << '\n' << ended.errors);
  CHECK(ended.exit_code == exit_code);
  CHECK(CountLines(ended.errors) == 1);
  CHECK(ended.output.empty());
  CHECK(ended.errors.find(fs::path(program).filename().string() + ": ") == 0);
  CHECK(ended.errors.find(expected) != std::string::npos);
}

std::string MakeBusUrl(int ttl) {
  constexpr int kFirstPort = 20000;
  constexpr int kNumPorts = 12000;  // up to where the system takes ports from for others
  for (int i = 0; i < kNumPorts; ++i) {
    const int port = kFirstPort + (getpid() * 64 + NextNumber()) % kNumPorts;
    if (LockPort(port)) return fmt::format("udpm://239.255.76.67:{}?ttl={}", port, ttl);
  }
  throw std::runtime_error("all ports for tests are taken");
}

TestBus::TestBus(const std::string& url, const std::string& channel_prefix)
    : bus_(url, channel_prefix, counters_, Reception::kByThread) {  // a test handles messages now and then
  bus_.Subscribe<service_status_t>(kEveryServiceStatus, [this](const service_status_t& status) {
    for (std::size_t i = 0; i < status.counter_name.size(); ++i) {
      told_[status.name + "." + status.counter_name[i]] = status.counter_value[i];
    }
  });
}

std::int64_t TestBus::Count(const std::string& name) const {
  const auto found = told_.find(name);
  return found == told_.end() ? 0 : found->second;
}

bool TestBus::Await(const std::function<bool()>& condition) {
  const auto give_up = Clock::now() + kPatience;
  while (!condition()) {
    if (Clock::now() >= give_up) return false;
    bus_.Wait(5);
  }
  return true;
}

MapWatcher::MapWatcher(const std::string& url, const std::string& channel_prefix) : bus_(url, channel_prefix) {
  bus_->Subscribe<map_delta_t>(kMapDeltaChannel, [this](const map_delta_t& delta) {
    version_ = delta.version;
    utime_ = delta.utime;
  });
}

bool MapWatcher::AwaitVersion(std::int64_t version) {
  return bus_.Await([&] { return version_ >= version; });
}

bool MapWatcher::AwaitScan(std::int64_t utime) {
  return bus_.Await([&] { return utime_ == utime; });
}

Stack::Stack(Options options) : options_(std::move(options)) {
  if (options_.logs.empty()) options_.logs = options_.out / "log";
}

bool Stack::Start(const std::string& service, std::vector<std::string> arguments) {
  const auto Append = [&](const std::vector<std::string>& more) {
    arguments.insert(arguments.end(), more.begin(), more.end());
  };
  Append(options_.flags);
  Append(options_.own_flags[service]);
  const std::string& own_url = options_.urls[service];
  Append({"--lcm-url", own_url.empty() ? options_.url : own_url});
  if (options_.lockstep && (service == "map_updater" || service == "rrhc_matcher")) Append({"--lockstep"});
  if (service == "map_exporter") Append({"--out", options_.out.string()});
  const auto network = options_.networks.find(service);
  processes_.erase(service);
  processes_[service] = std::make_unique<Process>(service, arguments, options_.logs,
                                                  network == options_.networks.end() ? -1 : network->second);
  return processes_[service]->AwaitReady();
}

bool Stack::StartServices() {
  return Start("map_updater") && Start("loop_closer") && Start("rrhc_matcher") && Start("ray_selector") &&
         Start("map_exporter");
}

bool Stack::StartPublisher(const std::string& source, const std::string& rate) {
  return Start("laser_publisher", {source, "--rate", rate});
}

bool Stack::Finish() {
  bool success = true;
  if (processes_.count("laser_publisher")) success = processes_["laser_publisher"]->AwaitExit(kLongRun) == 0;
  if (processes_.count("map_exporter")) success = processes_["map_exporter"]->Interrupt() == 0 && success;
  for (const auto& [service, process] : processes_) {
    if (service == "laser_publisher" || service == "map_exporter") continue;
    success = process->Interrupt() == 0 && success;
  }
  return success;
}

std::vector<LaserScan> TakeScans(const std::string& source_name, std::size_t count, std::size_t step,
                                 std::uint64_t seed) {
  const auto source = OpenLaserSource(source_name, {seed});
  std::vector<LaserScan> scans;
  for (std::size_t i = 0; scans.size() < count; ++i) {
    auto scan = source->Next();
    if (!scan) break;
    if (i % step == 0) scans.push_back(std::move(*scan));
  }
  return scans;
}

}  // namespace crsm
