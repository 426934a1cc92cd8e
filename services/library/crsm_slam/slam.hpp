#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#define CRSM_SLAM_PUBLIC [[gnu::visibility("default")]]

/// CRSM SLAM as a library: it makes a map and poses from the scans of a planar laser, without odometry. Lengths are in
/// metres, angles in radians, counter-clockwise. The frame of the map is the frame of the laser at the first scan.
///
/// The same scans and settings give the same map on every x86-64 machine. `slam_offline` makes the same map too, and
/// each can go on with what the other has saved. The library prints nothing and reads no clock. Use an object from one
/// thread at a time. Each object has one thread of its own that searches loop closures, unless the setting `loops` is
/// false.
namespace crsm_slam {

/// A pose in the plane: `T_a_b` is the pose of frame b in frame a.
struct Pose {
  double x_m = 0.0;      ///< forward
  double y_m = 0.0;      ///< left
  double yaw_rad = 0.0;  ///< counter-clockwise
};

/// One sweep of a planar laser.
struct Scan {
  std::int64_t utime = 0;       ///< time of the scan [us], 0 or later; it identifies the scan
  float angle_min_rad = 0.0f;   ///< angle of beam 0, laser frame, from x
  float angle_step_rad = 0.0f;  ///< angle from a beam to the next; negative for lasers that turn clockwise
  std::vector<float> ranges_m;  ///< of 2 to 4096 beams; <= 0, NaN or above the maximum range: no return
  /// When each beam was measured, from utime on [s], -2 to 2: the scan is deskewed by that. Empty: `sweep_s` says it.
  std::vector<float> times_s = {};
};

/// How the pose of a scan was found.
enum class State {
  kFirst,       ///< a trajectory begins: the pose is the origin, or a guess where scans were lost or missing
  kOk,          ///< matched to the map
  kLost,        ///< no pose explains the scan: the pose is a guess, and the scan is not in the map
  kDegenerate,  ///< matched, but one direction is degenerate: the scan does not fix it, as in a bare corridor
};

/// The result of one scan.
struct Step {
  State state = State::kFirst;  ///< whether you can trust the pose
  Pose T_map_laser;             ///< the pose of the laser
  Pose T_local_laser;           ///< the same in a frame that drifts: corrections of the map make no jump in it
  double fitness = 0.0;         ///< of the scan at that pose, 0 to 1
  /// xx, xy, x yaw, yy, y yaw, yaw yaw [m^2, m rad, rad^2]; 0 in the first scan of all. That of a guess, kLost or
  /// kFirst, grows with the time since the last match; variances of 1e4: nothing is known of the pose.
  std::array<double, 6> covariance{};
  std::array<double, 2> degenerate_axis{};  ///< degenerate direction: unit vector, map frame, if kDegenerate; else 0
  bool drawn = false;                       ///< the scan is in the map; the robot has moved since the last drawn scan
  bool loop_closed = false;                 ///< map and trajectory were corrected; the next T_map_laser may jump
  /// False while the trajectory of this scan is not joined with the map that MakeMap shows: T_map_laser is then in a
  /// frame of its own, and nothing is known of where it lies on that map. See Trajectory.
  bool on_map = true;
};

/// The pose of a scan, corrected by all loop closures so far.
struct StampedPose {
  std::int64_t utime = 0;      ///< time of the scan [us]
  Pose T_map_laser;            ///< the pose of the laser, in the frame of its piece
  State state = State::kLost;  ///< as in the Step of the scan; kLost: the pose is a guess
  /// The piece of the map on which the scan is. 1 is the map that MakeMap shows. Other pieces have numbers from 2 on,
  /// the larger ones first: they are not joined with it, and each has a frame of its own. The numbers may change with
  /// every scan.
  int piece = 1;
};

/// A loop closure: two scans of one place, far apart along the path.
struct Loop {
  std::int64_t older_utime = 0;  ///< the older scan [us]
  std::int64_t newer_utime = 0;  ///< the newer scan [us]
  Pose T_older_newer;            ///< the pose of the newer scan in the frame of the older one
};

/// The smallest rectangle with all explored cells of a map; 0 x 0 cells before the first scan.
struct Map {
  int width_cells = 0;              ///< number of cells along x
  int height_cells = 0;             ///< number of cells along y
  double cell_size_m = 0.0;         ///< side of a cell
  Pose T_map_grid;                  ///< pose of the lower left corner; its yaw is 0
  std::vector<std::uint8_t> cells;  ///< row by row from the lower left, y up: 255 free .. 0 occupied, 127 unexplored
};

/// What changed in a map: squares of 64 x 64 cells.
struct MapChanges {
  std::int64_t version = 0;  ///< of the map with these changes
  double cell_size_m = 0.0;  ///< side of a cell
  /// A square, as it is now.
  struct Tile {
    int x_cells = 0;  ///< of its lower left cell: the corner of cell (0, 0) is the origin of the map
    int y_cells = 0;  ///< likewise
    std::array<std::uint8_t, std::size_t{64} * 64> cells;  ///< row by row from the lower left, as of Map
  };
  std::vector<Tile> tiles;  ///< those that changed
};

/// Whether a map can be trusted.
enum class Trust {
  kGood,      ///< no check found a fault
  kDoubtful,  ///< look at the map before you rely on it
  kBad,       ///< not to be trusted
};

/// What speaks for a map and against it.
struct Verdict {
  Trust trust = Trust::kGood;      ///< of all that was checked
  std::vector<std::string> lines;  ///< for people: what came of the scans, and the reasons
  std::optional<double> off_m;     ///< how far off parts of the map may be; more in one map of twenty
};

/// A place with a name, as somebody saw it: a victim, a room, a zone to keep out of.
struct Mark {
  std::string id;         ///< names the place: 1 to 63 bytes, without control characters
  std::string kind;       ///< victim, hazard, keep-out, slow or any other: 1 to 31 of a-z, 0-9 and -
  std::string name = {};  ///< for people: up to 63 bytes
  /// When it was seen [us]: the points are in the frame of the laser then. Nothing: they are in the map's frame.
  std::optional<std::int64_t> utime = {};
  std::vector<std::array<double, 2>> points_m = {{0.0, 0.0}};  ///< one, or 3 to 64 of an outline
  double radius_m = 0.5;                                       ///< standard deviation of each coordinate, 0.001 to 1000
};

/// A place with a name, by all that is known of the map.
struct PlacedMark {
  std::string id;                               ///< as of Mark; so are the next two
  std::string kind;                             ///< victim or another
  std::string name;                             ///< for people
  std::vector<std::array<double, 2>> points_m;  ///< one, or those of an outline; map frame
  std::array<double, 3> covariance{};           ///< xx, xy, yy [m^2], as the sightings have it, without that of the map
  int sightings = 0;                            ///< of which it is made
  bool on_map = true;                           ///< false: on another piece than the map, in a frame of its own
};

/// The settings of a map. The order is defaults, preset, profile, single ones, values; a later one overrides an earlier
/// one. Nothing: as the preset says. `slam_offline --help` says what each does and its limits.
struct Settings {
  std::string preset = {};                 ///< the laser, one of Presets(); empty: a laser with a range of 30 m
  std::string profile = {};                ///< "default", or "paper", which follows the text of the paper exactly
  std::optional<double> range_min_m = {};  ///< shorter readings are ignored
  std::optional<double> range_max_m = {};  ///< of the laser; readings beyond 95 % of it are ignored
  std::optional<double> angle_scale = {};  ///< true angle / nominal angle of the beams
  std::optional<double> sweep_s = {};      ///< from the first to the last beam; negative: the last one comes first
  std::optional<bool> beam_times = {};     ///< believe Scan::times_s
  std::optional<int> rays_max = {};        ///< most critical rays of a scan
  std::optional<std::uint64_t> seed = {};  ///< of the random numbers
  std::optional<double> cell_size_m = {};  ///< side of a map cell
  std::optional<double> update_distance_m = {};  ///< a scan updates the map after this much motion ...
  std::optional<double> update_angle_rad = {};   ///< ... or this much turning
  std::optional<bool> loops = {};                ///< detect loop closures and correct the map
  std::optional<double> local_map_m = {};        ///< length of the local map, to which scans are matched
  /// The same and others by their names, as text that was read from a file: {{"range_max_m", "40"}, {"loops",
  /// "false"}}.
  std::map<std::string, std::string> values = {};
};

/// The names of the presets, one for each laser: "sick", "utm-30lx" and others.
CRSM_SLAM_PUBLIC std::vector<std::string> Presets();

/// The version of the library: "0.3.0".
CRSM_SLAM_PUBLIC std::string Version();

/// Makes a map, scan by scan.
///
/// Where scans are lost for long, and after a gap in time, a new *trajectory* begins, with a map of its own. It is
/// joined with the rest when the robot comes back to a known place. What is joined is one *piece*; MakeMap shows the
/// largest.
class CRSM_SLAM_PUBLIC Slam {
 public:
  /// Throws std::invalid_argument if a setting does not exist, has a wrong value, or contradicts another one. The text
  /// is one line that says what would be right.
  explicit Slam(const Settings& settings = {});
  ~Slam();
  Slam(Slam&&) noexcept;             ///< A moved-from object can only be assigned to or destroyed.
  Slam& operator=(Slam&&) noexcept;  ///< As above.

  /// Finds the pose of a scan, draws the scan into the map, and closes loops. Pass the scans in the order in which they
  /// were taken. T_odom_robot: the pose by wheel odometry, if there is one; the map does not need it.
  ///
  /// Throws std::invalid_argument for an invalid scan, for a utime that was used before, and for a pose beyond 1e6 m.
  /// The map does not change then.
  Step Process(const Scan& scan, const std::optional<Pose>& T_odom_robot = std::nullopt);

  /// The map of all scans so far that are on piece 1, corrected by all loop closures. With loops, each call draws the
  /// whole map again, which takes as long as some hundred scans. Call it once a second, not once a scan.
  Map MakeMap() const;

  /// The corrected poses of all scans so far, in the order of the scans, also of those that are lost or floating: on
  /// another piece than the map.
  std::vector<StampedPose> Trajectory() const;

  /// The loop closures that were accepted and not rejected later.
  std::vector<Loop> Loops() const;

  /// What changed in the map of MakeMap since a version of it, which a call before has named; 0: all of it. As costly
  /// as MakeMap.
  MapChanges ChangesSince(std::int64_t version);

  /// Whether the map, or the poses on a finished one, can be trusted, and why. As costly as MakeMap.
  Verdict Judge() const;

  /// Takes in a sighting of a place. Those of one id are one place, which moves with the map when loops are closed. A
  /// sighting of the same id and utime counts once. Throws std::invalid_argument for a mark that is none, if no scan
  /// was matched within half a second of its utime, for a place that was removed, and where there is no room for more.
  void AddMark(const Mark& mark);
  /// The place is this alone, whatever was seen of it before; also one that was removed. Throws likewise.
  void MoveMark(const Mark& mark);
  /// What is seen of the place later says nothing. Throws std::invalid_argument if there is no such place.
  void RemoveMark(const std::string& id);
  /// All places, where they lie by now.
  std::vector<PlacedMark> Marks() const;

  /// Another drive begins with the next scan: the robot may be anywhere. Where it comes to known places, the two are
  /// joined.
  void BeginDrive();

  /// Finishes the map. From now on scans are localised on it, and change nothing; where the first of them was taken is
  /// searched on all of the map.
  void FinishMap();

  /// Writes into a folder, which is made if need be: map.png, map.pgm and map.yaml (as map_server reads them),
  /// trajectory.tum (of the scans on piece 1), graph.g2o (with loops), summary.json with the verdict, pieces/, and
  /// journal/, of which Load and slam_offline make the map again. Only an earlier state of this map is replaced there,
  /// as a whole; all other results are moved into a folder below, earlier.1 say: see LoadNotice. Throws
  /// std::runtime_error if that fails, or if a program or another object writes there, and std::logic_error on a
  /// finished map, which can only be saved before that.
  void Save(const std::string& folder) const;

  /// A map that was saved, by slam_offline or run_stack too: the next scan goes on with it, or is localised after
  /// FinishMap. T_map_laser: about where the next scan is taken; without, where the last one was, or anywhere on a
  /// finished map. Settings that the map was made with are taken over; others than these throw std::invalid_argument.
  /// Throws std::runtime_error if there is no map in the folder, if it is damaged in the middle, or if summary.json is
  /// of another map than the journal; see LoadNotice.
  static Slam Load(const std::string& folder, const Settings& settings = {},
                   const std::optional<Pose>& T_map_laser = std::nullopt);

  /// In one line, what Load has found wrong with the journal: that its end is missing, say, and how many scans remain.
  /// After a Save that has moved other results aside, where these are now. Empty where all is as it was saved, and of a
  /// map that was not loaded.
  std::string LoadNotice() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace crsm_slam
