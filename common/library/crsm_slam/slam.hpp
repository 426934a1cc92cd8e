#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#define CRSM_SLAM_PUBLIC [[gnu::visibility("default")]]

/// CRSM SLAM as a library: a map and poses from the scans of a planar laser, without odometry. Lengths are in metres,
/// angles in radians, counter-clockwise. The frame of the map is the laser's at the first scan.
///
/// The same scans and settings give the same map on every x86-64 machine, the one that `slam_offline` makes of them.
/// Nothing is printed, and no clock is asked. An object is for one thread at a time; it has one of its own that searches
/// loops, unless they are switched off.
namespace crsm_slam {

/// A pose in the plane: `T_a_b` is frame b seen from frame a.
struct Pose {
  double x_m = 0.0;      ///< forward
  double y_m = 0.0;      ///< left
  double yaw_rad = 0.0;  ///< counter-clockwise
};

/// One sweep of a planar laser.
struct Scan {
  std::int64_t utime = 0;       ///< when it was taken [us], 0 or later; it names the scan
  float angle_min_rad = 0.0f;   ///< of beam 0, laser frame, from x
  float angle_step_rad = 0.0f;  ///< from a beam to the next; negative for lasers that turn clockwise
  std::vector<float> ranges_m;  ///< along each beam, 2 to 4096; <= 0, NaN or beyond the laser's reach: no return
};

/// How the pose of a scan was found.
enum class State {
  kFirst,       ///< the map was empty: the pose is its origin
  kOk,          ///< matched to the map
  kLost,        ///< no pose explains the scan: the pose is a guess, the scan stays out of the map
  kDegenerate,  ///< matched, but nothing seen holds the position along one axis, as in a bare corridor
};

/// What became of a scan.
struct Step {
  State state = State::kFirst;              ///< whether the pose is to be believed
  Pose T_map_laser;                         ///< where the laser was
  double fitness = 0.0;                     ///< of the scan at that pose, 0 to 1
  std::array<double, 6> covariance{};       ///< xx, xy, x yaw, yy, y yaw, yaw yaw [m^2, m rad, rad^2]; 0: first or lost
  std::array<double, 2> degenerate_axis{};  ///< unit vector, map frame, where the state is kDegenerate; else 0
  bool drawn = false;                       ///< the scan is in the map: the robot has moved since the last that is
  bool loop_closed = false;                 ///< map and trajectory are put right; T_map_laser of the next may jump
};

/// A scan's pose by all that is known now.
struct StampedPose {
  std::int64_t utime = 0;  ///< of the scan
  Pose T_map_laser;        ///< where the laser was
};

/// Two scans of one place, far apart along the path.
struct Loop {
  std::int64_t older_utime = 0;  ///< of the one
  std::int64_t newer_utime = 0;  ///< of the other
  Pose T_older_newer;            ///< the newer one seen from the older one
};

/// The explored cells of a map, and the rectangle around them; 0 x 0 before the first scan.
struct Map {
  int width_cells = 0;              ///< along x
  int height_cells = 0;             ///< along y
  double cell_size_m = 0.0;         ///< of each side of a cell
  Pose T_map_grid;                  ///< the lower left corner; its yaw is 0
  std::vector<std::uint8_t> cells;  ///< row by row from the lower left, y up: 255 free .. 0 occupied, 127 unexplored
};

/// What a map is made with. Later wins: defaults, preset, profile, values.
struct Settings {
  std::string preset = {};   ///< the laser, one of Presets(); without one its range is 30 m
  std::string profile = {};  ///< "default", or "paper" for the text of the paper to the letter
  /// What `slam_offline --help` lists, with _ for -: {{"range_max_m", "40"}, {"loops", "false"}}.
  std::map<std::string, std::string> values = {};
};

/// Lasers by their names: "sick", "utm-30lx" and others.
CRSM_SLAM_PUBLIC std::vector<std::string> Presets();

/// Of the library: "0.1.0".
CRSM_SLAM_PUBLIC std::string Version();

/// Makes a map, scan by scan.
class CRSM_SLAM_PUBLIC Slam {
 public:
  /// Throws std::invalid_argument, one line that says what would be right, if a setting is none, or two contradict
  /// each other.
  explicit Slam(const Settings& settings = {});
  ~Slam();
  Slam(Slam&&) noexcept;             ///< What was moved from can only be assigned to or destroyed.
  Slam& operator=(Slam&&) noexcept;  ///< As above.

  /// Finds where a scan was taken, draws it into the map, and closes loops. Scans come in the order in which they were
  /// taken. T_odom_robot: the pose by wheels, where there is one; the map does not need it.
  ///
  /// Throws std::invalid_argument, and leaves the map as it is, for a scan that is none, one of a utime that was there
  /// before, or a pose beyond 1e6 m.
  Step Process(const Scan& scan, const std::optional<Pose>& T_odom_robot = std::nullopt);

  /// All that was seen so far, where it belongs by all that is known. With loops it is drawn anew each time, which
  /// takes as long as some hundred scans: for a second, not for a scan.
  Map MakeMap() const;

  /// The poses of all scans so far, in their order.
  std::vector<StampedPose> Trajectory() const;

  /// The loops that hold.
  std::vector<Loop> Loops() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace crsm_slam
