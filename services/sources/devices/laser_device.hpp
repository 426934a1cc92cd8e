#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/scan/laser_scan.hpp"
#include "services/sources/devices/connection.hpp"

namespace crsm {

/// What a laser has measured in a turn. Beams that saw nothing in the laser's range are 0 = no return.
struct DeviceScan {
  LaserScan scan;                ///< its utime is not known yet
  std::int64_t device_us = 0;    ///< of the last beam, by the laser's clock, without its wraps
  bool clock_restarted = false;  ///< this clock does not go on from the last scan's
  double turn_s = 0.0;           ///< what a whole turn takes
};

/// What went wrong, for people and for SERVICE_STATUS.
struct DeviceReport {
  std::map<std::string, std::int64_t> counts;
  std::vector<std::string> complaints;  ///< to be said, a line each
};

/// A kind of laser: how it is asked to scan, and what its bytes mean. A file for each kind; all of them are one object
/// for one connection.
class LaserDevice {
 public:
  virtual ~LaserDevice() = default;

  /// Ends what an earlier process left going on, asks the laser what it is, and lets it scan. Returns what it is, in
  /// words. Throws DeviceError; takes at most three seconds.
  virtual std::string Start(Connection& connection) = 0;

  /// The next bytes of a laser that scans. Scans that are whole and undamaged go to `scans`; what is damaged is left
  /// out and counted. Throws DeviceError if the laser says that it cannot go on.
  virtual void Take(std::string_view bytes, std::vector<DeviceScan>& scans) = 0;

  /// Lets the laser rest. Throws DeviceError.
  virtual void Stop(Connection& connection) = 0;
};

/// What is the same for all lasers of a kind.
struct DeviceKind {
  std::string name;
  std::vector<int> bauds;  ///< usual ones, the most usual first
  std::string tcp_port;    ///< the usual one; empty: none
  double clock_error;      ///< by how much its clock may be too fast or too slow, as a share
  std::string no_scans;    ///< why it may send no scans after it was started
  std::unique_ptr<LaserDevice> (*make)(DeviceReport& report);
};

/// All kinds: hokuyo.cpp, rplidar.cpp, sick.cpp.
const std::vector<DeviceKind>& DeviceKinds();

std::unique_ptr<LaserDevice> MakeHokuyo(DeviceReport& report);
std::unique_ptr<LaserDevice> MakeRplidar(DeviceReport& report);
std::unique_ptr<LaserDevice> MakeSick(DeviceReport& report);

}  // namespace crsm
