#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/logs/laser_source.hpp"
#include "services/sources/devices/clock_fit.hpp"
#include "services/sources/devices/laser_device.hpp"

namespace crsm {

/// Where a laser is: "hokuyo:/dev/ttyACM0", "rplidar:/dev/ttyUSB0:256000", "sick:tcp://192.168.0.1:2111".
struct DeviceAddress {
  const DeviceKind* kind = nullptr;
  std::string path;  ///< of a serial port, ...
  int baud = 0;      ///< ... whose usual rates are tried if this is 0; ...
  std::string host;  ///< ... or a host
  std::string port;
};

/// What may stand in the place of a log, for --help.
std::string DescribeDevices();

/// Nothing if `name` does not begin with a kind of laser and a colon. Throws UsageError if what follows is no port.
std::optional<DeviceAddress> ParseDevice(const std::string& name);

/// A laser that this process talks to: its scans come when it has measured them. Whatever happens to it, or to the way
/// to it, is said in a line and counted, and it is tried again twice a second: scans come again within two seconds
/// after it has come back.
class LiveLaser : public LaserSource {
 public:
  using Clock = std::chrono::steady_clock;

  /// say: gets what is to be said of the laser.
  LiveLaser(const DeviceAddress& address, std::function<void(const std::string&)> say);
  ~LiveLaser() override;

  bool IsLive() const override { return true; }

  /// The utime of a scan is when its last beam was measured. To connect may take longer than `longest`: some seconds.
  std::optional<LaserScan> Poll(std::chrono::milliseconds longest) override;

  /// The next scan, however long it takes; nothing once the process is asked to end.
  std::optional<LaserScan> Next() override;

  /// From the first beam of the last scan to its last [s].
  double sweep_s() const { return sweep_s_; }

  double Progress() const override { return 0.0; }

  /// "connected": how often; "connection_lost"; and what the laser's kind counts of damaged and missing scans.
  std::map<std::string, std::int64_t> Counts() const override { return report_.counts; }

 private:
  void Connect();
  int NextBaud() const;
  void Receive(std::chrono::milliseconds longest);
  void Keep(DeviceScan scan, Clock::time_point arrival);
  void Disconnect(const std::string& why);
  void SayNews();

  DeviceAddress address_;
  std::function<void(const std::string&)> say_;
  DeviceReport report_;
  std::unique_ptr<Connection> connection_;
  std::unique_ptr<LaserDevice> device_;
  std::string description_;  ///< of the laser, to be said when its first scan has come
  ClockFit clock_;
  std::int64_t clock_offset_us_;  ///< from the steady clock to the time of day, when this process began
  std::deque<LaserScan> waiting_;
  double sweep_s_ = 0.0;
  std::size_t baud_tried_ = 0;     ///< index of the usual baud rate that is to be tried
  bool baud_known_ = false;        ///< it has worked
  bool had_scans_ = false;         ///< since it was connected
  Clock::time_point quiet_since_;  ///< no scan has come since
  Clock::time_point next_try_{};
  std::string said_;  ///< what was said last of a laser that is not there
};

}  // namespace crsm
