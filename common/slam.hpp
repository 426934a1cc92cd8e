#pragma once

#include <vector>

#include "common/map/map_updater.hpp"
#include "common/match/rrhc_matcher.hpp"
#include "common/parameters.hpp"
#include "common/scan/laser_scan.hpp"

namespace crsm {

/// The whole algorithm in one process: what the five processes do together, step by step and bit for bit.
class Slam {
 public:
  explicit Slam(const Parameters& parameters);

  /// Selects the critical rays of a scan, matches them to the map so far, and draws the scan into the map.
  /// Scans come in the order in which they were taken; no utime may come twice. T_odom_robot: the odometry of the scan,
  /// where there is some.
  ScanMatch Process(const LaserScan& scan, const std::optional<Pose2>& T_odom_robot = std::nullopt);

  /// Takes over a scan of an earlier session as it was matched then; nullptr where its match had none. All of them one
  /// after the other make the same map, and the next scan is matched as it would have been then.
  void Restore(const LaserScan* scan, const ScanMatch& match);

  /// Finishes the map: from now on scans are localised on it and change nothing. The history begins anew, and where the
  /// first of them was taken is searched on the whole map.
  void Freeze();

  const std::vector<ScanMatch>& history() const { return history_; }
  const ByteMap& map() const { return matcher_.map(); }
  /// As of MapUpdater.
  std::int64_t num_scans_cut() const { return updater_.num_scans_cut(); }
  const MapGeometry& geometry() const { return updater_.geometry(); }

 private:
  Parameters parameters_;
  RrhcMatcher matcher_;
  MapUpdater updater_;
  double density_scale_ = kFirstDensityScale;
  std::vector<ScanMatch> history_;
};

}  // namespace crsm
