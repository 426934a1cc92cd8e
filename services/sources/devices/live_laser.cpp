#include "services/sources/devices/live_laser.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <thread>

#include "common/math/parse_number.hpp"
#include "common/math/trigonometry.hpp"
#include "services/base/process.hpp"
#include "services/base/usage_error.hpp"
#include "services/sources/devices/serial_ports.hpp"

namespace crsm {
namespace {

using std::chrono::milliseconds;

constexpr std::string_view kTcp = "tcp://";

template <class Duration>
std::int64_t Microseconds(Duration duration) {
  return std::chrono::duration_cast<std::chrono::microseconds>(duration).count();
}

[[noreturn]] void RefuseAddress(const std::string& name, const std::string& expected) {
  throw UsageError(fmt::format("{}: {}", name, expected));
}

void ParseTcp(const std::string& name, std::string_view text, DeviceAddress& address) {
  const std::size_t colon = text.rfind(':');
  const bool bracketed = text.ends_with(']');  // an IPv6 address without port
  address.host = std::string(bracketed ? text : text.substr(0, colon));
  address.port =
      colon == std::string_view::npos || bracketed ? address.kind->tcp_port : std::string(text.substr(colon + 1));
  if (address.host.starts_with('[') && address.host.ends_with(']')) {
    address.host = address.host.substr(1, address.host.size() - 2);
  }
  const auto port = ParseNumber<int>(address.port);
  if (address.host.empty() || !port || *port < 1 || *port > 65535) {
    RefuseAddress(name, fmt::format("is not {}:tcp://HOST:PORT with a port from 1 to 65535", address.kind->name));
  }
}

void ParseSerialPort(const std::string& name, std::string_view text, DeviceAddress& address) {
  constexpr int kFastest = 4000000;
  const std::size_t colon = text.rfind(':');
  // There may be none, and colons all the same, as in paths by-path.
  const auto baud = colon == std::string_view::npos ? std::nullopt : ParseNumber<int>(text.substr(colon + 1));
  address.path = std::string(baud ? text.substr(0, colon) : text);
  address.baud = baud.value_or(0);
  if (baud && (*baud < 50 || *baud > kFastest)) RefuseAddress(name, "its baud rate is not from 50 to 4000000");
  if (!address.path.starts_with('/')) throw UsageError(DescribeWrongPort(*address.kind, text, FindSerialPorts()));
  if (address.kind->bauds.empty()) {
    RefuseAddress(name, fmt::format("a serial port of this laser is not supported: use {}:tcp://HOST:{}",
                                    address.kind->name, address.kind->tcp_port));
  }
}

}  // namespace

const std::vector<DeviceKind>& DeviceKinds() {
  static const std::vector<DeviceKind> kinds{
      {"hokuyo",
       {115200, 19200, 57600, 500000, 750000},
       "10940",
       1e-3,
       "it answers, but does not scan: does it get enough power?",
       MakeHokuyo},
      {"rplidar",
       {115200, 256000, 460800, 1000000},
       "",
       0.1,
       "it answers, but its motor does not turn: is the motor's power plugged in, and can its head turn freely?",
       MakeRplidar},
      {"sick", {}, "2111", 1e-3, "it answers, but does not scan: is it in standby (SOPAS ET)?", MakeSick}};
  return kinds;
}

std::string DescribeDevices() {
  return "a laser: hokuyo:/dev/ttyACM0, hokuyo:tcp://HOST, rplidar:/dev/ttyUSB0, sick:tcp://HOST";
}

std::optional<DeviceAddress> ParseDevice(const std::string& name) {
  for (const DeviceKind& kind : DeviceKinds()) {
    if (!name.starts_with(kind.name + ':')) continue;
    const std::string_view where = std::string_view(name).substr(kind.name.size() + 1);
    if (where.empty()) throw UsageError(DescribeMissingPort(kind, FindSerialPorts()));
    DeviceAddress address{&kind, "", 0, "", ""};
    if (where.starts_with(kTcp)) {
      ParseTcp(name, where.substr(kTcp.size()), address);
    } else {
      ParseSerialPort(name, where, address);
    }
    return address;
  }
  return std::nullopt;
}

LiveLaser::LiveLaser(const DeviceAddress& address, std::function<void(const std::string&)> say)
    : address_(address),
      say_(std::move(say)),
      clock_(address.kind->clock_error),
      clock_offset_us_(Microseconds(std::chrono::system_clock::now().time_since_epoch()) -
                       Microseconds(Clock::now().time_since_epoch())) {
  std::signal(SIGPIPE, SIG_IGN);  // a laser that ends its connection must not end the process
}

LiveLaser::~LiveLaser() {
  try {
    if (connection_) device_->Stop(*connection_);
  } catch (const DeviceError&) {  // it is gone, and rests
  }
}

std::optional<LaserScan> LiveLaser::Next() {
  while (!StopRequested()) {
    if (auto scan = Poll(milliseconds(50))) return scan;
  }
  return std::nullopt;
}

std::optional<LaserScan> LiveLaser::Poll(milliseconds longest) {
  if (waiting_.empty()) {
    try {
      if (connection_) {
        Receive(longest);
      } else if (Clock::now() >= next_try_) {
        Connect();
      } else {
        std::this_thread::sleep_for(std::min<Clock::duration>(longest, next_try_ - Clock::now()));
      }
    } catch (const DeviceError& error) {
      if (!StopRequested()) Disconnect(error.what());
    }
    SayNews();
  }
  if (waiting_.empty()) return std::nullopt;
  LaserScan scan = std::move(waiting_.front());
  waiting_.pop_front();
  return scan;
}

int LiveLaser::NextBaud() const { return address_.baud > 0 ? address_.baud : address_.kind->bauds[baud_tried_]; }

void LiveLaser::Connect() {
  const bool is_serial = address_.host.empty();
  auto connection = is_serial ? OpenSerialPort(address_.path, NextBaud()) : OpenTcp(address_.host, address_.port);
  device_ = address_.kind->make(report_);
  try {
    description_ = device_->Start(*connection);
  } catch (const NoAnswer& error) {
    // Until a rate has worked, all are tried before anything is said.
    if (is_serial && address_.baud == 0 && !baud_known_) {
      baud_tried_ = (baud_tried_ + 1) % address_.kind->bauds.size();
      if (baud_tried_ != 0) return;
      throw DeviceError(fmt::format("{} (tried at {} baud)", error.what(), fmt::join(address_.kind->bauds, ", ")));
    }
    throw;
  }
  connection_ = std::move(connection);
  clock_.Restart();
  baud_known_ = true;
  had_scans_ = false;
  quiet_since_ = Clock::now();
  ++report_.counts["connected"];
}

void LiveLaser::Receive(milliseconds longest) {
  constexpr milliseconds kFirstPatience(4000);  // motors take seconds to get up to speed
  constexpr milliseconds kPatience(1500);       // the slowest laser takes 0.5 s for a turn
  std::vector<DeviceScan> scans;
  const std::string bytes = connection_->Read(longest);
  const auto arrival = Clock::now();
  std::optional<DeviceError> error;
  try {
    device_->Take(bytes, scans);
  } catch (const DeviceError& refusal) {  // what came before it counts
    error = refusal;
  }
  for (DeviceScan& scan : scans) Keep(std::move(scan), arrival);
  if (!scans.empty()) {
    if (!had_scans_) say_(description_);
    quiet_since_ = arrival;
    had_scans_ = true;
    said_.clear();
  }
  if (error) throw *error;
  // While bytes come, it may be this process that was held up: they are read first.
  const milliseconds patience = (had_scans_ ? kPatience : kFirstPatience) * (bytes.empty() ? 1 : 4);
  if (arrival - quiet_since_ <= patience) return;
  if (!had_scans_) throw DeviceError(address_.kind->no_scans);
  Disconnect("has become silent: is its cable plugged in, and does it have power?");
  next_try_ = arrival;  // it may be back already, and what it sends then is lost
}

void LiveLaser::Keep(DeviceScan scan, Clock::time_point arrival) {
  if (scan.clock_restarted) clock_.Restart();
  scan.scan.utime = clock_offset_us_ + clock_.Fit(scan.device_us, Microseconds(arrival.time_since_epoch()));
  const auto num_steps = static_cast<double>(scan.scan.ranges_m.size() - 1);
  sweep_s_ = scan.turn_s * std::min(1.0, num_steps * std::abs(scan.scan.angle_step_rad) / (2.0 * kPi));
  waiting_.push_back(std::move(scan.scan));
}

/// What is wrong is said once, however often it is tried.
void LiveLaser::Disconnect(const std::string& why) {
  constexpr milliseconds kPause(500);
  if (connection_) {
    ++report_.counts["connection_lost"];
    connection_.reset();
  }
  next_try_ = Clock::now() + kPause;
  if (why != said_) say_(why + "; trying again until it answers");
  said_ = why;
}

void LiveLaser::SayNews() {
  for (const std::string& complaint : report_.complaints) say_(complaint);
  report_.complaints.clear();
}

}  // namespace crsm
