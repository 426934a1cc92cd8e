#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "services/sources/devices/laser_device.hpp"

namespace crsm {

/// The samples of a scanning RPLidar, five bytes each, made turns. Knows no connection. Source: SLAMTEC, RPLIDAR
/// Interface Protocol and Application Notes, "SCAN".
///
/// A sample has no checksum, only two bits that check it: where one does not follow from the sample before, its turn is
/// damaged, left out and counted ("bad_turn"), and the next place is looked for where five samples follow from each
/// other. The first part of a turn, before any start of one, is no damage.
class RplidarSamples {
 public:
  /// sample_us: between two samples.
  RplidarSamples(DeviceReport& report, int sample_us) : report_(report), sample_us_(sample_us) {}

  void Take(std::string_view bytes, std::vector<DeviceScan>& scans);

 private:
  struct Sample {
    bool starts_turn = false;
    double angle_deg = 0.0;  ///< clockwise from straight ahead
    float range_m = 0.0f;    ///< 0: nothing was seen
  };
  static constexpr std::size_t kBytes = 5;

  bool IsSample(std::size_t begin) const;
  Sample SampleAt(std::size_t begin) const;
  bool Follows(const Sample& sample) const;
  bool FindSync();
  double ComputeTurned_deg() const;
  void LoseSync(std::vector<DeviceScan>& scans);
  void Add(const Sample& sample, std::vector<DeviceScan>& scans);
  void EndTurn(std::vector<DeviceScan>& scans);

  DeviceReport& report_;
  int sample_us_;
  std::string bytes_;  ///< that are not used yet
  bool in_sync_ = false;
  double last_angle_deg_ = 0.0;
  std::vector<Sample> turn_;  ///< the samples of the turn that is under way
  bool whole_ = false;        ///< this turn was seen from its start
  std::int64_t num_samples_ = 0;
  bool clock_restarted_ = false;
};

}  // namespace crsm
