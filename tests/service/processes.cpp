#include "processes.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <set>
#include <stdexcept>
#include <thread>

#include "services/settings/command_line.hpp"
#include "services/sources/open_laser_source.hpp"
#include "services/wire/conversions.hpp"

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

[[noreturn]] void Execute(const char* path, char* const* arguments, const char* output, const char* errors) {
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

bool WaitUntil(const std::function<bool()>& condition, std::chrono::microseconds period) {
  const auto give_up = Clock::now() + kPatience;
  while (!condition()) {
    if (Clock::now() >= give_up) return false;
    std::this_thread::sleep_for(period);
  }
  return true;
}

TemporaryFolder::TemporaryFolder()
    : path_(fs::temp_directory_path() / fmt::format("crsm_service_tests_{}_{}", getpid(), NextNumber())) {
  fs::remove_all(path_);
  fs::create_directories(path_);
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::string ReadFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

Process::Process(const std::string& program, const std::vector<std::string>& arguments, const fs::path& logs) {
  const fs::path path = program.find('/') == std::string::npos ? fs::path(CRSM_BIN_DIR) / program : fs::path(program);
  name_ = path.filename().string();
  const int number = NextNumber();
  fs::create_directories(logs);
  output_ = logs / fmt::format("{}.{}.out", name_, number);
  errors_ = logs / fmt::format("{}.{}.err", name_, number);

  std::vector<char*> argv{const_cast<char*>(path.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  // A freed block that AddressSanitizer keeps for a while would look like a leak.
  setenv("ASAN_OPTIONS", "quarantine_size_mb=1", 0);
  setenv("CRSM_BIN_DIR", CRSM_BIN_DIR, 1);
  pid_ = fork();
  if (pid_ == 0) Execute(path.c_str(), argv.data(), output_.c_str(), errors_.c_str());
  if (pid_ < 0) throw std::runtime_error("no process can be started");
}

Process::~Process() {
  if (!IsRunning()) return;
  Signal(SIGKILL);
  AwaitExit();
}

bool Process::AwaitReady() {
  const std::string ready = name_ + ": ready\n";
  const auto IsReady = [&] { return errors().find(ready) != std::string::npos; };
  WaitUntil([&] { return IsReady() || !IsRunning(); });
  return IsReady();
}

void Process::Signal(int signal) const { kill(pid_, signal); }

bool Process::IsRunning() {
  int status = 0;
  if (!exit_code_ && waitpid(pid_, &status, WNOHANG) == pid_) {
    exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  return !exit_code_;
}

int Process::AwaitExit() {
  WaitUntil([this] { return !IsRunning(); });
  return exit_code_.value_or(-1);
}

int Process::Interrupt() {
  Signal(SIGINT);
  return AwaitExit();
}

double Process::ResidentMb() const {
  std::ifstream statm(fmt::format("/proc/{}/statm", pid_));
  double total_pages = 0.0;
  double resident_pages = 0.0;
  statm >> total_pages >> resident_pages;
  return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

int Run(const std::string& program, const std::vector<std::string>& arguments, const fs::path& logs) {
  return Process(program, arguments, logs).AwaitExit();
}

std::string MakeBusUrl() {
  constexpr int kFirstPort = 20000;
  constexpr int kNumPorts = 12000;  // up to where the system takes ports from for others
  for (int i = 0; i < kNumPorts; ++i) {
    const int port = kFirstPort + (getpid() * 64 + NextNumber()) % kNumPorts;
    if (LockPort(port)) return fmt::format("udpm://239.255.76.67:{}?ttl=0", port);
  }
  throw std::runtime_error("all ports for tests are taken");
}

TestBus::TestBus(const std::string& url, const std::string& channel_prefix)
    : bus_(url, channel_prefix, counters_, Reception::kByThread) {}  // a test handles messages now and then

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
    if (delta.num_requests != 0) return;
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
  options_.flags.insert(options_.flags.end(), {"--lcm-url", options_.url});
}

bool Stack::Start(const std::string& service) {
  std::vector<std::string> arguments = options_.flags;
  const std::set<std::string> with_lockstep{"map_updater", "rrhc_matcher"};
  if (options_.lockstep && with_lockstep.count(service)) arguments.push_back("--lockstep");
  if (service == "map_exporter") arguments.insert(arguments.end(), {"--out", options_.out.string()});
  processes_.erase(service);
  processes_[service] = std::make_unique<Process>(service, arguments, options_.out / "log");
  return processes_[service]->AwaitReady();
}

bool Stack::StartServices() {
  return Start("map_updater") && Start("loop_closer") && Start("rrhc_matcher") && Start("ray_selector") &&
         Start("map_exporter");
}

bool Stack::StartPublisher(const std::string& source, const std::string& rate) {
  std::vector<std::string> arguments = options_.flags;
  arguments.insert(arguments.end(), {source, "--rate", rate});
  processes_["laser_publisher"] = std::make_unique<Process>("laser_publisher", arguments, options_.out / "log");
  return processes_["laser_publisher"]->AwaitReady();
}

bool Stack::Finish() {
  bool success = true;
  if (processes_.count("laser_publisher")) success = processes_["laser_publisher"]->AwaitExit() == 0;
  if (processes_.count("map_exporter")) success = processes_["map_exporter"]->Interrupt() == 0 && success;
  for (const auto& [service, process] : processes_) {
    if (service == "laser_publisher" || service == "map_exporter") continue;
    success = process->Interrupt() == 0 && success;
  }
  return success;
}

std::vector<LaserScan> TakeScans(const std::string& source_name, std::size_t count, std::size_t step) {
  const auto source = OpenLaserSource(source_name, {ParametersOf({}).match.seed});
  std::vector<LaserScan> scans;
  for (std::size_t i = 0; scans.size() < count; ++i) {
    auto scan = source->Next();
    if (!scan) break;
    if (i % step == 0) scans.push_back(std::move(*scan));
  }
  return scans;
}

void WriteScans(const std::vector<LaserScan>& scans, const fs::path& path) {
  lcm::LogFile log(path.string(), "w");
  std::int64_t number = 0;
  for (const LaserScan& scan : scans) {
    std::vector<std::uint8_t> bytes = Encode(ToMessage(scan));
    lcm::LogEvent event{number++, scan.utime, kLaserChannel, static_cast<std::int32_t>(bytes.size()), bytes.data()};
    if (!log.good() || log.writeEvent(&event) != 0) throw std::runtime_error("no log can be written");
  }
}

Parameters ParametersOf(const std::vector<std::string>& flags) {
  using enum ParameterGroup;
  CommandLine command_line("test", "", {kSeed, kScan, kSelection, kMatch, kUpdate}, {});
  std::vector<const char*> argv{"test"};
  for (const std::string& flag : flags) argv.push_back(flag.c_str());
  if (command_line.Parse(static_cast<int>(argv.size()), argv.data())) throw std::runtime_error("bad flags");
  return command_line.parameters();
}

}  // namespace crsm
