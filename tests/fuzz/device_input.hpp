#pragma once

#include <cmath>
#include <vector>

#include "common/scan/valid_rays.hpp"
#include "input.hpp"
#include "services/sources/devices/laser_device.hpp"

namespace crsm {

/// A laser that answers each request with the next message of an input. At its end it is gone.
class FuzzedConnection : public Connection {
 public:
  explicit FuzzedConnection(std::span<const std::uint8_t> input) : input_(input) {}

  std::string Read(std::chrono::milliseconds) override {
    const auto message = input_.Next();
    if (!message) throw DeviceError("gone");
    return {message->begin(), message->end()};
  }
  void Write(std::string_view) override {}

 private:
  MessageReader input_;
};

/// Lets a laser be started and scan: its scans must be such as are believed, in an order of time.
inline void FeedDevice(std::unique_ptr<LaserDevice> (*make)(DeviceReport& report),
                       std::span<const std::uint8_t> input) {
  FuzzedConnection connection(input);
  DeviceReport report;
  const auto device = make(report);
  std::vector<DeviceScan> scans;
  try {
    device->Start(connection);
    while (true) device->Take(connection.Read({}), scans);
  } catch (const DeviceError&) {  // is how a laser is refused
  }
  std::int64_t last_us = 0;
  for (const DeviceScan& scan : scans) {
    if (scan.scan.ranges_m.size() < kMinBeams || scan.scan.ranges_m.size() > kMaxBeams) std::abort();
    if (!std::isfinite(scan.scan.angle_min_rad) || !(std::abs(scan.scan.angle_step_rad) > 0.0f)) std::abort();
    if (!(scan.turn_s > 0.0) || scan.turn_s > 1e6 || scan.device_us < last_us) std::abort();
    last_us = scan.device_us;
    FindValidRays(scan.scan, {});
  }
}

}  // namespace crsm
