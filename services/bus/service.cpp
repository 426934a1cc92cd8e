#include "services/bus/service.hpp"

#include <unistd.h>

#include <fstream>

#include "common/logs/left_out.hpp"
#include "services/base/version.hpp"

namespace crsm {
namespace {

double ResidentMb() {
  std::ifstream statm("/proc/self/statm");
  double total_pages = 0.0;
  double resident_pages = 0.0;
  statm >> total_pages >> resident_pages;
  return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
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
  CatchSignals();
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
  service_status_t status;
  status.utime = UtimeNow();
  status.name = name_;
  status.version = kVersion;
  status.pid = getpid();
  status.state = state_;
  status.num_left_out = num_left_out_ + FindCount(counters_.counts(), kDroppedOverload);
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
  if (!identity_.empty()) {
    ++status.num_parameters;
    status.parameter_name.emplace_back(kIdentityParameter);
    status.parameter_value.push_back(identity_);
  }
  status.num_latencies = latency_.num_recorded();
  status.latency_p50_ms = latency_.Percentile(0.5);
  status.latency_p95_ms = latency_.Percentile(0.95);
  status.latency_p99_ms = latency_.Percentile(0.99);
  status.latency_max_ms = latency_.max_ms();
  status.resident_mb = ResidentMb();
  return status;
}

}  // namespace crsm
