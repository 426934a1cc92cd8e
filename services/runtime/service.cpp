#include "services/runtime/service.hpp"

#include <fmt/core.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <regex>
#include <stdexcept>

#include "services/runtime/usage_error.hpp"
#include "services/runtime/version.hpp"

namespace crsm {
namespace {

volatile sig_atomic_t stop_requested = 0;

void RequestStop(int) { stop_requested = 1; }

double ResidentMb() {
  std::ifstream statm("/proc/self/statm");
  double total_pages = 0.0;
  double resident_pages = 0.0;
  statm >> total_pages >> resident_pages;
  return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

/// What a process that was killed while it wrote results (WriteResults) has left: .NAME.PID.tmp
void RemoveLeftovers(const std::string& out) {
  static const std::regex kLeftover(R"(\.(?:map|overview|trajectory|truth|summary)\.[a-z]+\.([0-9]{1,9})\.tmp)");
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(out, error)) {
    const std::string name = entry.path().filename().string();
    std::smatch parts;
    if (!std::regex_match(name, parts, kLeftover)) continue;
    if (kill(std::stoi(parts[1]), 0) != 0 && errno == ESRCH) std::filesystem::remove(entry.path(), error);
  }
}

/// What the process uses, as text that fits into a message: a path may be longer.
std::vector<std::pair<std::string, std::string>> DescribeParameters(const CommandLine& command_line) {
  constexpr std::size_t kLongest = 1000;
  std::vector<std::pair<std::string, std::string>> described;
  for (const auto& [name, value] : command_line.UsedValues()) {
    std::string text = FormatValue(value);
    if (text.size() > kLongest) text = text.substr(0, kLongest) + "...";
    described.emplace_back(name, std::move(text));
  }
  return described;
}

}  // namespace

void CatchSignals() {
  struct sigaction action {};
  action.sa_handler = RequestStop;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool StopRequested() { return stop_requested != 0; }

void PrepareFolder(const std::string& out) {
  if (out.empty()) throw UsageError("--out is missing: give the folder for the results");
  std::error_code error;
  std::filesystem::create_directories(out, error);
  if (error || access(out.c_str(), W_OK) != 0) {
    throw std::runtime_error(
        fmt::format("--out {}: cannot be written: {}", out, error ? error.message() : std::strerror(errno)));
  }
  RemoveLeftovers(out);
}

void Say(const std::string& line) { std::fputs((line + '\n').c_str(), stderr); }

std::int64_t DrawIdentity() {
  std::random_device device;
  return (std::int64_t{device()} << 31 | std::int64_t{device() >> 1}) + 1;
}

Service::Service(const CommandLine& command_line)
    : name_(command_line.program()),
      parameters_(DescribeParameters(command_line)),
      address_{command_line.settings().lcm_url, command_line.settings().channel_prefix},
      bus_(address_.lcm_url, address_.channel_prefix, counters_) {}

void Service::Complain(const std::string& counter, const std::string& line) {
  if (counters_.counts().count(counter) == 0) Say(line);
  counters_.Add(counter);
}

void Service::RecordLatency(Clock::time_point start) {
  latency_.Record(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
}

void Service::Run(const std::function<bool()>& step, int period_ms) {
  Say(name_ + ": ready");
  bool idle = true;
  while (!StopRequested()) {
    Spin(idle ? period_ms : 0);
    idle = step();
  }
}

void Service::Spin(int timeout_ms) {
  bus_.Wait(timeout_ms);
  if (Clock::now() >= next_status_) PublishStatus();
}

void Service::PublishStatus() {
  next_status_ = Clock::now() + std::chrono::seconds(1);
  bus_.Publish(ServiceStatusChannel(name_).c_str(), MakeStatus());
  if (role_) role_->DismissVisitors();
}

service_status_t Service::MakeStatus() const {
  using std::chrono::duration_cast;
  using std::chrono::microseconds;
  service_status_t status;
  status.utime = duration_cast<microseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
  status.name = name_;
  status.version = kVersion;
  status.pid = getpid();
  status.state = state_;
  status.num_counters = static_cast<std::int32_t>(counters_.counts().size());
  for (const auto& [name, count] : counters_.counts()) {
    status.counter_name.push_back(name);
    status.counter_value.push_back(count);
  }
  status.num_parameters = static_cast<std::int32_t>(parameters_.size());
  for (const auto& [name, value] : parameters_) {
    status.parameter_name.push_back(name);
    status.parameter_value.push_back(value);
  }
  status.num_latencies = latency_.num_recorded();
  status.latency_p50_ms = latency_.Percentile(0.5);
  status.latency_p95_ms = latency_.Percentile(0.95);
  status.latency_p99_ms = latency_.Percentile(0.99);
  status.latency_max_ms = latency_.max_ms();
  status.resident_mb = ResidentMb();
  return status;
}

int ReportErrors(const std::string& program, const std::function<int()>& body) {
  try {
    return body();
  } catch (const UsageError& error) {
    Say(fmt::format("{}: {}", program, error.what()));
    return 2;
  } catch (const std::exception& error) {
    Say(fmt::format("{}: {}", program, error.what()));
    return 1;
  }
}

int RunMain(const std::string& program, const std::function<void()>& body) {
  CatchSignals();
  return ReportErrors(program, [&] { return body(), 0; });
}

}  // namespace crsm
