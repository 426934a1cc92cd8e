// The Python module crsm_slam._crsm_slam: the library, and the logs that the programs read, for Python.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <crsm_slam/slam.hpp>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "services/base/say.hpp"
#include "services/python/arguments.hpp"
#include "services/settings/command_line.hpp"
#include "services/sources/open_laser_source.hpp"
#include "services/sources/study_laser.hpp"

namespace py = pybind11;

namespace {

using crsm_python::Arguments;
using crsm_slam::Pose;
using Floats = py::array_t<float>;

// Rows of structured arrays.
struct PoseRow {
  std::int64_t utime;
  double x_m;
  double y_m;
  double yaw_rad;
  std::uint8_t state;
  std::int32_t piece;
};
struct LoopRow {
  std::int64_t older_utime;
  std::int64_t newer_utime;
  double x_m;
  double y_m;
  double yaw_rad;
};

template <std::size_t N>
py::array_t<double> ToArray(const std::array<double, N>& numbers) {
  return py::array_t<double>(static_cast<py::ssize_t>(N), numbers.data());
}
py::array_t<double> ToArray(const Pose& pose) {
  return ToArray(std::array<double, 3>{pose.x_m, pose.y_m, pose.yaw_rad});
}

py::array_t<double> ToMatrix(const std::array<double, 6>& c) {
  const std::array<double, 9> all{c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5]};
  return py::array_t<double>(std::vector<py::ssize_t>{3, 3}, all.data());
}

py::array_t<std::uint8_t> ToCells(const std::uint8_t* cells, py::ssize_t height, py::ssize_t width) {
  return py::array_t<std::uint8_t>(std::vector<py::ssize_t>{height, width}, cells);
}

/// Other threads of Python run as long as this lives. Unlike py::gil_scoped_release it knows of Python's end: that
/// waits for what daemon threads are at, and none of them goes on afterwards, when what they use is gone.
class WithoutGil {
 public:
  WithoutGil() : state_(PyEval_SaveThread()) {
    ++num_working_;
    StopAtTheEnd();
  }
  ~WithoutGil() {
    StopAtTheEnd();
    PyEval_RestoreThread(state_);
    --num_working_;
  }
  WithoutGil(const WithoutGil&) = delete;
  WithoutGil& operator=(const WithoutGil&) = delete;

  /// To be called once, by atexit.
  static void End() {
    const py::gil_scoped_release release;
    ending_thread_ = std::this_thread::get_id();
    is_ending_ = true;
    while (num_working_ > 0 && getpid() == process_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

 private:
  static void StopAtTheEnd() {
    if (!is_ending_ || std::this_thread::get_id() == ending_thread_) return;
    --num_working_;
    for (;;) pause();
  }

  static inline std::atomic<int> num_working_ = 0;
  static inline std::atomic<bool> is_ending_ = false;
  static inline std::thread::id ending_thread_;   ///< which may still work: in other functions of atexit
  static inline const pid_t process_ = getpid();  ///< a process that was forked from it lacks its threads

  PyThreadState* state_;
};

/// A scan, and the odometry that came with it.
struct ScanWithOdometry {
  crsm_slam::Scan scan;
  std::optional<Pose> T_odom_robot;
};

/// call: what Python calls.
ScanWithOdometry MakeScan(const char* call, const py::args& words, const py::kwargs& keywords) {
  static const std::vector<std::string> kNames{"ranges_m", "angle_min_rad", "angle_step_rad",
                                               "utime",    "times_s",       "odometry"};
  const Arguments arguments(call, words, keywords, kNames, 4);
  const py::object times_s = arguments["times_s"];
  return {{crsm_python::ToUtime(arguments["utime"]), crsm_python::ToAngle(arguments["angle_min_rad"], "angle_min_rad"),
           crsm_python::ToAngle(arguments["angle_step_rad"], "angle_step_rad"),
           crsm_python::ToRanges(arguments["ranges_m"]),
           times_s.is_none() ? std::vector<float>() : crsm_python::ToFloats(times_s, "times_s")},
          crsm_python::ToPose(arguments["odometry"], "odometry")};
}

/// While it works other threads of Python run; of two that ask for the same object, one waits.
class PySlam {
 public:
  explicit PySlam(crsm_slam::Slam slam) : slam_(std::make_unique<crsm_slam::Slam>(std::move(slam))) {}

  /// A process that was forked has this object without its threads: nobody could wait for them.
  ~PySlam() {
    if (IsForked()) static_cast<void>(slam_.release());
  }

  template <class Work>
  auto Do(Work&& work) {
    if (IsForked()) {
      throw std::runtime_error("this Slam is of the process that was forked: make or load one in the new process");
    }
    const WithoutGil release;
    const std::lock_guard lock(mutex_);
    return work(*slam_);
  }

  /// Takes a Scan alone, or what makes one.
  crsm_slam::Step Process(const py::args& words, const py::kwargs& keywords) {
    const auto scan = ScanOf(words, keywords);
    return Do([&](crsm_slam::Slam& slam) { return slam.Process(scan.scan, scan.T_odom_robot); });
  }

 private:
  static ScanWithOdometry ScanOf(const py::args& words, const py::kwargs& keywords) {
    const py::object first = !words.empty()              ? py::object(words[0])
                             : keywords.contains("scan") ? py::object(keywords["scan"])
                                                         : py::none();
    if (!py::isinstance<ScanWithOdometry>(first)) return MakeScan("Slam.process", words, keywords);
    if (words.size() + keywords.size() == 1) return first.cast<ScanWithOdometry>();
    throw py::type_error("Slam.process() takes a Scan alone: what belongs to it is said where it is made");
  }

  bool IsForked() const { return getpid() != process_; }

  pid_t process_ = getpid();
  std::mutex mutex_;
  std::unique_ptr<crsm_slam::Slam> slam_;
};

py::array_t<PoseRow> TrajectoryOf(PySlam& slam) {
  const auto poses = slam.Do([](const crsm_slam::Slam& of) { return of.Trajectory(); });
  py::array_t<PoseRow> rows(static_cast<py::ssize_t>(poses.size()));
  PoseRow* row = rows.mutable_data();
  std::memset(static_cast<void*>(row), 0,
              poses.size() * sizeof *row);  // equal paths have equal bytes, between fields too
  for (const crsm_slam::StampedPose& pose : poses) {
    row->utime = pose.utime;
    row->x_m = pose.T_map_laser.x_m;
    row->y_m = pose.T_map_laser.y_m;
    row->yaw_rad = pose.T_map_laser.yaw_rad;
    row->state = static_cast<std::uint8_t>(pose.state);
    row->piece = pose.piece;
    ++row;
  }
  return rows;
}

py::array_t<LoopRow> LoopsOf(PySlam& slam) {
  const auto loops = slam.Do([](const crsm_slam::Slam& of) { return of.Loops(); });
  py::array_t<LoopRow> rows(static_cast<py::ssize_t>(loops.size()));
  LoopRow* row = rows.mutable_data();
  for (const crsm_slam::Loop& loop : loops) {
    const auto& [x_m, y_m, yaw_rad] = loop.T_older_newer;
    *row++ = {loop.older_utime, loop.newer_utime, x_m, y_m, yaw_rad};
  }
  return rows;
}

/// A number, a truth value or a text, as Python has them.
py::object ToPython(const crsm::ParameterValue& value) {
  return std::visit([](const auto& plain) { return py::object(py::cast(plain)); }, value);
}

/// A log, a bag or a simulated world, as slam_offline would read it.
class Log {
 public:
  Log(std::string name, const py::dict& keywords) : name_(std::move(name)) {
    const crsm_slam::Slam checks(
        crsm_python::ToSettings("Log", {}, keywords, kKeys));  // throws what is wrong with them
    std::vector<std::string> words{"crsm_slam"};
    for (const auto& [key, value] : keywords) AddFlag(crsm_python::ToUtf8(key), value, words);
    const WithoutGil release;
    using enum crsm::ParameterGroup;
    command_line_ = std::make_unique<crsm::CommandLine>(
        "crsm_slam", "", std::vector{kSeed, kLaser, kScan, kSelection, kUpdate, kLoops, kAlgorithm}, kKeys);
    std::vector<const char*> arguments;
    for (const std::string& word : words) arguments.push_back(word.c_str());
    if (command_line_->Parse(static_cast<int>(arguments.size()), arguments.data()))
      throw std::invalid_argument("Log: these settings do not fit together");
    crsm::StudyLaser(name_, *command_line_);
    Rewind();
  }

  void Rewind() { source_ = crsm::OpenLaserSource(name_, crsm::SourceOptionsOf(*command_line_)); }

  /// Begins anew.
  Log& Iterate() {
    const WithoutGil release;
    const std::lock_guard lock(mutex_);
    Rewind();
    return *this;
  }

  ScanWithOdometry Next() {
    std::optional<ScanWithOdometry> scan = Read();
    while (!scan && IsLive()) {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();  // Ctrl-C
      scan = Read();
    }
    if (!scan) {
      SayWhatWasLeftOut();
      throw py::stop_iteration();
    }
    return *std::move(scan);
  }

  std::optional<Pose> TruePose() const {
    const std::lock_guard lock(mutex_);
    const auto pose = source_->TruePose();
    return pose ? std::optional(Pose{pose->x_m, pose->y_m, pose->yaw_rad}) : std::nullopt;
  }

  double progress() const {
    const std::lock_guard lock(mutex_);
    return source_->Progress();
  }
  const std::string& name() const { return name_; }

  py::dict settings() const {
    py::dict settings;
    for (const auto& [key, value] : crsm::ListParameters(command_line_->parameters()))
      settings[key.c_str()] = ToPython(value);
    return settings;
  }

 private:
  static inline const std::vector<std::string> kKeys{"laser_channel",  "laser_frame",      "odometry",
                                                     "odometry_topic", "botlab_clockwise", "mirrored"};

  std::optional<ScanWithOdometry> Read() {
    constexpr std::chrono::milliseconds kPatience(200);  // until Ctrl-C is noticed
    const WithoutGil release;
    const std::lock_guard lock(mutex_);
    auto scan = source_->IsLive() ? source_->Poll(kPatience) : source_->Next();
    if (!scan) return std::nullopt;
    std::optional<Pose> T_odom_robot;
    if (const auto odometry = source_->Odometry(); odometry && command_line_->settings().odometry)
      T_odom_robot = Pose{odometry->x_m, odometry->y_m, odometry->yaw_rad};
    return ScanWithOdometry{
        {scan->utime, scan->angle_min_rad, scan->angle_step_rad, std::move(scan->ranges_m), std::move(scan->times_s)},
        T_odom_robot};
  }

  /// On stderr, as slam_offline does: it would not be seen in the map.
  void SayWhatWasLeftOut() {
    const std::lock_guard lock(mutex_);
    std::vector<std::string> lines = crsm::DescribeComplaints(name_, *source_);
    if (command_line_->settings().odometry) {
      for (std::string& line : crsm::DescribeOdometry(name_, *source_)) lines.push_back(std::move(line));
    }
    if (std::string cut = crsm::DescribeCut(name_, *source_); !cut.empty()) lines.push_back(std::move(cut));
    for (const std::string& line : lines) crsm::Say("crsm_slam: " + line);
  }

  bool IsLive() const {
    const std::lock_guard lock(mutex_);
    return source_->IsLive();
  }

  static void AddFlag(const std::string& key, const py::handle& value, std::vector<std::string>& words) {
    if (value.is_none()) return;
    const auto flag = crsm_python::ToBool(value);
    if (!flag && (key == "odometry" || key == "botlab_clockwise" || key == "mirrored")) {
      throw py::type_error(key + ": is " + std::string(py::repr(value)) + ", must be True or False");
    }
    if (!flag) {
      words.insert(words.end(), {crsm::FlagOf(key), crsm_python::ToText(value)});
    } else {
      words.push_back(*flag ? crsm::FlagOf(key) : "--no" + crsm::FlagOf(key).substr(1));
    }
  }

  std::string name_;
  std::unique_ptr<crsm::CommandLine> command_line_;
  std::unique_ptr<crsm::LaserSource> source_;
  mutable std::mutex mutex_;  ///< of the source: threads may ask for scans beside each other
};

py::module_ OwnModule() { return py::module_::import("crsm_slam._crsm_slam"); }

// ---- what repr() shows
std::string Text(double number) { return py::str(py::float_(number)); }

py::object ToPython(crsm_slam::State state) { return OwnModule().attr("State")(static_cast<int>(state)); }
py::object ToPython(crsm_slam::Trust trust) { return OwnModule().attr("Trust")(static_cast<int>(trust)); }

std::string Describe(const crsm_slam::Step& step) {
  return "Step(state=" + std::string(py::str(ToPython(step.state))) +
         ", T_map_laser=" + std::string(py::str(ToArray(step.T_map_laser))) + ", fitness=" + Text(step.fitness) + ")";
}
std::string DescribeScan(const ScanWithOdometry& scan) {
  return "Scan(utime=" + std::to_string(scan.scan.utime) + ", " + std::to_string(scan.scan.ranges_m.size()) +
         " ranges, angle_min_rad=" + Text(scan.scan.angle_min_rad) +
         ", angle_step_rad=" + Text(scan.scan.angle_step_rad) + ")";
}
std::string DescribeMap(const crsm_slam::Map& map) {
  return "Map(" + std::to_string(map.width_cells) + " x " + std::to_string(map.height_cells) + " cells of " +
         Text(map.cell_size_m) + " m)";
}
std::string DescribeVerdict(const crsm_slam::Verdict& verdict) {
  return "Verdict(trust=" + std::string(py::str(ToPython(verdict.trust))) +
         ", off_m=" + (verdict.off_m ? Text(*verdict.off_m) : "None") + ")";
}

/// An enum.IntEnum, whose members can be compared with the numbers in an array.
template <class Enum>
void AddEnum(py::module_& module, const char* name, const char* description,
             const std::vector<std::pair<std::string, Enum>>& members) {
  py::dict values;
  for (const auto& [member, value] : members) values[member.c_str()] = static_cast<int>(value);
  const py::module_ enums = py::module_::import("enum");
  const py::object type = enums.attr("IntEnum")(name, values, py::arg("module") = "crsm_slam");
  for (const char* text_of : {"__str__", "__format__"}) py::setattr(type, text_of, enums.attr("Enum").attr(text_of));
  py::setattr(type, "__doc__", py::str(description));
  module.attr(name) = type;
}

void AddEnums(py::module_& module) {
  using crsm_slam::State;
  using crsm_slam::Trust;
  AddEnum<State>(
      module, "State",
      "How the pose of a scan was found.\n\n"
      "FIRST: a trajectory begins: the pose is the origin, or a guess. OK: matched to the map.\n"
      "LOST: no pose explains the scan: the pose is a guess, and the scan is not in the map.\n"
      "DEGENERATE: matched, but one direction is open, as in a bare corridor.",
      {{"FIRST", State::kFirst}, {"OK", State::kOk}, {"LOST", State::kLost}, {"DEGENERATE", State::kDegenerate}});
  AddEnum<Trust>(
      module, "Trust",
      "Whether a map can be trusted.\n\n"
      "GOOD: no check found a fault. DOUBTFUL: look at the map before you rely on it. BAD: not to be trusted.",
      {{"GOOD", Trust::kGood}, {"DOUBTFUL", Trust::kDoubtful}, {"BAD", Trust::kBad}});
}

void AddScan(py::module_& module) {
  py::class_<ScanWithOdometry>(
      module, "Scan",
      "Scan(ranges_m, *, angle_min_rad, angle_step_rad, utime, times_s=None, odometry=None)\n\n"
      "One sweep of a planar laser. Beams are counted as the laser's angle goes, from angle_min_rad on.\n\n"
      "  ranges_m: (N,), N from 2 to 4096, the range of each beam [m]. No return: 0 or less, NaN, inf,\n"
      "      masked, or above the maximum range. Float32; other numbers are converted.\n"
      "  angle_min_rad: angle of beam 0 from straight ahead (x), counter-clockwise [rad]\n"
      "  angle_step_rad: angle from a beam to the next [rad]; negative for lasers that turn clockwise\n"
      "  utime: time of the scan [us], a whole number from 0 on, another one for each scan. Of seconds:\n"
      "      int(1e6 * seconds). Of a stamp of ROS 2: stamp.sec * 1000000 + stamp.nanosec // 1000.\n"
      "  times_s: (N,), when each beam was measured, counted from utime [s], within 2 s: the scan is deskewed\n"
      "      by that. These are seconds, and not shares of a sweep.\n"
      "  odometry: (3,), the pose of the robot by its wheels: x [m], y [m], yaw [rad], in any fixed frame\n\n"
      "Raises TypeError and ValueError, one line that names the argument.")
      .def(py::init([](const py::args& words, const py::kwargs& keywords) {
        return std::make_unique<ScanWithOdometry>(MakeScan("Scan", words, keywords));
      }))
      .def_property_readonly(
          "ranges_m",
          [](const ScanWithOdometry& scan) {
            return Floats(static_cast<py::ssize_t>(scan.scan.ranges_m.size()), scan.scan.ranges_m.data());
          },
          "(N,), float32, a copy [m]")
      .def_property_readonly(
          "times_s",
          [](const ScanWithOdometry& scan) {
            return Floats(static_cast<py::ssize_t>(scan.scan.times_s.size()), scan.scan.times_s.data());
          },
          "(N,), float32, a copy, from utime on [s]; or (0,) where that is not known")
      .def_property_readonly(
          "angle_min_rad", [](const ScanWithOdometry& scan) { return scan.scan.angle_min_rad; },
          "angle of beam 0 from straight ahead, counter-clockwise [rad]")
      .def_property_readonly(
          "angle_step_rad", [](const ScanWithOdometry& scan) { return scan.scan.angle_step_rad; },
          "angle from a beam to the next [rad]")
      .def_property_readonly(
          "utime", [](const ScanWithOdometry& scan) { return scan.scan.utime; }, "time of the scan [us]")
      .def_property_readonly(
          "odometry",
          [](const ScanWithOdometry& scan) -> py::object {
            return scan.T_odom_robot ? py::object(ToArray(*scan.T_odom_robot)) : py::none();
          },
          "(3,): x [m], y [m], yaw [rad], or None")
      .def("__repr__", &DescribeScan);
}

void AddResults(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(PoseRow, utime, x_m, y_m, yaw_rad, state, piece);
  PYBIND11_NUMPY_DTYPE(LoopRow, older_utime, newer_utime, x_m, y_m, yaw_rad);
  py::class_<crsm_slam::Step>(module, "Step", "The result of one scan.")
      .def_property_readonly(
          "state", [](const crsm_slam::Step& step) { return ToPython(step.state); },
          "a State: OK (matched to the map), LOST (the pose is a guess), FIRST, DEGENERATE")
      .def_property_readonly(
          "T_map_laser", [](const crsm_slam::Step& step) { return ToArray(step.T_map_laser); },
          "(3,), float64: x [m], y [m], yaw [rad] of the laser in the map")
      .def_property_readonly(
          "T_local_laser", [](const crsm_slam::Step& step) { return ToArray(step.T_local_laser); },
          "(3,), float64: the same in a frame that drifts: corrections of the map make no jump in it")
      .def_readonly("fitness", &crsm_slam::Step::fitness, "of the scan at that pose, 0 to 1")
      .def_property_readonly(
          "covariance", [](const crsm_slam::Step& step) { return ToMatrix(step.covariance); },
          "(3, 3), float64, of x [m], y [m], yaw [rad]; variances of 1e4: nothing is known of the pose")
      .def_property_readonly(
          "degenerate_axis", [](const crsm_slam::Step& step) { return ToArray(step.degenerate_axis); },
          "(2,), float64: unit vector, map frame, if the state is DEGENERATE; else 0")
      .def_readonly("drawn", &crsm_slam::Step::drawn, "the scan is in the map")
      .def_readonly("loop_closed", &crsm_slam::Step::loop_closed,
                    "map and trajectory were corrected; the next T_map_laser may jump")
      .def_readonly("on_map", &crsm_slam::Step::on_map,
                    "this part of the path is joined with the map; if not, T_map_laser is in a frame of its own")
      .def("__repr__", &Describe);

  py::class_<crsm_slam::PlacedMark>(module, "PlacedMark", "A place with a name, by all that is known of the map.")
      .def_readonly("id", &crsm_slam::PlacedMark::id, "str: names the place")
      .def_readonly("kind", &crsm_slam::PlacedMark::kind, "str: 'victim' or another")
      .def_readonly("name", &crsm_slam::PlacedMark::name, "str: for people")
      .def_property_readonly(
          "points_m",
          [](const crsm_slam::PlacedMark& mark) {
            py::array_t<double> points({mark.points_m.size(), std::size_t{2}});
            for (std::size_t i = 0; i < 2 * mark.points_m.size(); ++i)
              points.mutable_data()[i] = mark.points_m[i / 2][i % 2];
            return points;
          },
          "(1, 2), or (corners, 2) of an outline, float64, map frame [m]")
      .def_property_readonly(
          "covariance",
          [](const crsm_slam::PlacedMark& mark) {
            const auto& [xx, xy, yy] = mark.covariance;
            py::array_t<double> matrix({2, 2});
            std::ranges::copy(std::array{xx, xy, xy, yy}, matrix.mutable_data());
            return matrix;
          },
          "(2, 2), float64 [m^2], as the sightings have it, without that of the map")
      .def_readonly("sightings", &crsm_slam::PlacedMark::sightings, "int: of which it is made")
      .def_readonly("on_map", &crsm_slam::PlacedMark::on_map, "False: on another piece than the map of make_map()")
      .def("__repr__", [](const crsm_slam::PlacedMark& mark) {
        return "PlacedMark(id=" + std::string(py::repr(py::str(mark.id))) + ", kind='" + mark.kind + "')";
      });

  py::class_<crsm_slam::Map>(
      module, "Map",
      "The smallest rectangle with all explored cells; (0, 0) cells before the first scan. To plot it:\n"
      "pyplot.imshow(map.cells, cmap='gray', origin='lower', extent=map.extent_m)")
      .def_property_readonly(
          "cells",
          [](const crsm_slam::Map& map) { return ToCells(map.cells.data(), map.height_cells, map.width_cells); },
          "(height, width), uint8, a copy, y up: 255 free .. 0 occupied, 127 unexplored")
      .def_readonly("cell_size_m", &crsm_slam::Map::cell_size_m, "side of a cell [m]")
      .def_property_readonly(
          "origin_m",
          [](const crsm_slam::Map& map) {
            return ToArray(std::array<double, 2>{map.T_map_grid.x_m, map.T_map_grid.y_m});
          },
          "(2,), float64: x and y of the lower left corner, map frame [m]")
      .def_property_readonly(
          "extent_m",
          [](const crsm_slam::Map& map) {
            const auto& [x_m, y_m, yaw_rad] = map.T_map_grid;
            return py::make_tuple(x_m, x_m + map.width_cells * map.cell_size_m, y_m,
                                  y_m + map.height_cells * map.cell_size_m);
          },
          "left, right, bottom, top [m], as matplotlib.imshow takes it with origin='lower'")
      .def("__repr__", &DescribeMap);

  py::class_<crsm_slam::MapChanges::Tile>(module, "Tile", "A square of 64 x 64 cells.")
      .def_readonly("x_cells", &crsm_slam::MapChanges::Tile::x_cells,
                    "of its lower left cell; the corner of cell (0, 0) is the origin of the map")
      .def_readonly("y_cells", &crsm_slam::MapChanges::Tile::y_cells, "likewise")
      .def_property_readonly(
          "cells", [](const crsm_slam::MapChanges::Tile& tile) { return ToCells(tile.cells.data(), 64, 64); },
          "(64, 64), uint8, a copy, y up, as of Map");
  py::class_<crsm_slam::MapChanges>(module, "MapChanges", "What changed in a map.")
      .def_readonly("version", &crsm_slam::MapChanges::version, "of the map with these changes, for the next call")
      .def_readonly("cell_size_m", &crsm_slam::MapChanges::cell_size_m, "side of a cell [m]")
      .def_readonly("tiles", &crsm_slam::MapChanges::tiles, "a list of each Tile that changed");

  py::class_<crsm_slam::Verdict>(module, "Verdict", "What speaks for a map and against it; print() shows the lines.")
      .def_property_readonly(
          "trust", [](const crsm_slam::Verdict& verdict) { return ToPython(verdict.trust); },
          "a Trust: GOOD, DOUBTFUL or BAD")
      .def_readonly("lines", &crsm_slam::Verdict::lines,
                    "for people, a list of str: what came of the scans, and the reasons")
      .def_readonly("off_m", &crsm_slam::Verdict::off_m, "how far off parts of the map may be [m], or None")
      .def("__repr__", &DescribeVerdict)
      .def("__str__", [](const crsm_slam::Verdict& verdict) {
        std::string text;
        for (const std::string& line : verdict.lines) text += (text.empty() ? "" : "\n") + line;
        return text;
      });
}

std::string DescribeSlam() {
  return "Slam(**settings)\n\n"
         "Makes a map, scan by scan: Slam(preset='sick', cell_size_m=0.1, loops=False). Other threads run while\n"
         "it works. Each setting overrides the preset. The defaults are for a laser with a range of 30 m:\n\n" +
         crsm_python::DescribeSettings() +
         "\nRaises ValueError, one line, for a setting that does not exist or has a wrong value.";
}

void Warn(const std::string& notice) {
  if (!notice.empty() && PyErr_WarnEx(PyExc_RuntimeWarning, notice.c_str(), 1) != 0) throw py::error_already_set();
}

/// What is missing of the map is a warning of Python.
std::unique_ptr<PySlam> LoadSlam(const std::string& folder, const crsm_slam::Settings& settings,
                                 const std::optional<Pose>& T_map_laser) {
  std::string notice;
  auto loaded = [&] {
    const WithoutGil release;
    crsm_slam::Slam slam = crsm_slam::Slam::Load(folder, settings, T_map_laser);
    notice = slam.LoadNotice();
    return std::make_unique<PySlam>(std::move(slam));
  }();
  Warn(notice);
  return loaded;
}

void AddSlam(py::module_& module) {
  static const std::string description = DescribeSlam();
  py::class_<PySlam>(module, "Slam", description.c_str())
      .def(py::init([](const py::args& words, const py::kwargs& keywords) {
        return std::make_unique<PySlam>(crsm_slam::Slam(crsm_python::ToSettings("Slam", words, keywords)));
      }))
      .def_static(
          "load",
          [](const py::object& folder, const py::object& start, const py::kwargs& keywords) {
            const crsm_slam::Settings settings = crsm_python::ToSettings("Slam.load", {}, keywords);
            const std::string path = crsm_python::ToPath(folder, "folder");
            const auto T_map_laser = crsm_python::ToPose(start, "start");
            return LoadSlam(path, settings, T_map_laser);
          },
          py::arg("folder"), py::arg("start") = py::none(),
          "load(folder, start=None, **settings)\n\n"
          "A map that was saved, by slam_offline or run_stack too. The next scan goes on with it, or is localised\n"
          "after finish_map(). It has its settings with it; others raise ValueError. folder: str or pathlib.Path.\n"
          "start: (3,), x [m], y [m], yaw [rad], about where the next scan is taken. Raises RuntimeError if there\n"
          "is no map in the folder, or if it is damaged in the middle. Where the end of its journal is missing it "
          "loads\n"
          "the scans before, with a RuntimeWarning (warnings.warn) that says how many.")
      .def("process", &PySlam::Process,
           "process(scan)\n"
           "process(ranges_m, *, angle_min_rad, angle_step_rad, utime, times_s=None, odometry=None)\n\n"
           "Finds the pose of a Scan, draws it into the map, and closes loops. Returns a Step. Takes a Scan, or what\n"
           "Scan takes: ranges_m is (N,) [m], angles are in radians, utime is in microseconds; help(crsm_slam.Scan)\n"
           "says more. Raises TypeError and ValueError for an invalid scan, and for a utime that was used before;\n"
           "the map does not change then.")
      .def(
          "make_map", [](PySlam& slam) { return slam.Do([](const crsm_slam::Slam& of) { return of.MakeMap(); }); },
          "make_map()\n\n"
          "The Map of all scans so far, corrected by all loop closures. Takes as long as some hundred scans: call it\n"
          "once a second, not once a scan.")
      .def("trajectory", &TrajectoryOf,
           "trajectory()\n\n"
           "The corrected pose of each scan so far: a structured array (scans,), with the fields utime [us], x_m,\n"
           "y_m, yaw_rad (T_map_laser), state (to be compared with State.OK and others), and piece (1: on the map\n"
           "of make_map; a scan that is not lost floats where it has another one). numpy.column_stack([path['x_m'], "
           "path['y_m']]) has the positions.")
      .def("loops", &LoopsOf,
           "loops()\n\n"
           "The loop closures: a structured array (loops,), with the fields older_utime, newer_utime [us], x_m, y_m,\n"
           "yaw_rad (T_older_newer).")
      .def(
          "changes_since",
          [](PySlam& slam, std::int64_t version) {
            return slam.Do([&](crsm_slam::Slam& of) { return of.ChangesSince(version); });
          },
          py::arg("version") = 0,
          "changes_since(version=0)\n\n"
          "MapChanges since a version of the map that a call before has named; 0: all of it.")
      .def(
          "judge", [](PySlam& slam) { return slam.Do([](const crsm_slam::Slam& of) { return of.Judge(); }); },
          "judge()\n\n"
          "The Verdict: whether the map, or the poses on a finished one, can be trusted, and why.")
      .def(
          "save",
          [](PySlam& slam, const py::object& folder) {
            const std::string path = crsm_python::ToPath(folder, "folder");
            const auto [before, after] = slam.Do([&](const crsm_slam::Slam& of) {
              const std::string notice = of.LoadNotice();
              of.Save(path);
              return std::pair(notice, of.LoadNotice());
            });
            if (after != before) Warn(after);
          },
          py::arg("folder"),
          "save(folder)\n\n"
          "Writes map.png, map.pgm, map.yaml, overview.png, trajectory.tum (of the scans on that map), graph.g2o,\n"
          "summary.json with the verdict, pieces/, and journal/, of which load() and slam_offline make the map again.\n"
          "folder: str or pathlib.Path; it is made if need be. Only an earlier state of this map is replaced there;\n"
          "all other results are moved into a folder below, earlier.1 say, with a RuntimeWarning that names it.\n"
          "Raises RuntimeError where a program or another Slam writes there, and on a finished map, which can only be "
          "saved before that.")
      .def(
          "mark",
          [](PySlam& slam, const std::string& id, const std::string& kind, const std::optional<std::int64_t>& utime,
             const std::vector<std::array<double, 2>>& points_m, const std::string& name, double radius_m, bool moves) {
            const crsm_slam::Mark mark{id, kind, name, utime, points_m, radius_m};
            slam.Do([&](crsm_slam::Slam& of) { moves ? of.MoveMark(mark) : of.AddMark(mark); });
          },
          py::arg("id"), py::arg("kind"), py::kw_only(), py::arg("utime") = py::none(),
          py::arg("points_m") = std::vector<std::array<double, 2>>{{0.0, 0.0}}, py::arg("name") = "",
          py::arg("radius_m") = 0.5, py::arg("moves") = false,
          "mark(id, kind, *, utime=None, points_m=((0.0, 0.0),), name='', radius_m=0.5, moves=False)\n\n"
          "Takes in a sighting of a place with a name. Those of one id are one place, which moves with the map.\n\n"
          "  id: str that names the place, of up to 63 bytes\n"
          "  kind: 'victim', 'hazard', 'keep-out', 'slow' or another str of a-z, 0-9 and -\n"
          "  utime: when it was seen [us]: the points are in the frame of the laser then; None: in the map's frame\n"
          "  points_m: (1, 2), or (3 to 64, 2) of an outline\n"
          "  name: str, for people\n"
          "  radius_m: standard deviation of each coordinate\n"
          "  moves: True: the place is this alone, whatever was seen of it before\n\n"
          "Raises ValueError, one line, if it cannot be taken in.")
      .def(
          "remove_mark",
          [](PySlam& slam, const std::string& id) { slam.Do([&](crsm_slam::Slam& of) { of.RemoveMark(id); }); },
          py::arg("id"),
          "remove_mark(id)\n\n"
          "What is seen of the place later says nothing. Raises ValueError if there is no such place.")
      .def(
          "marks", [](PySlam& slam) { return slam.Do([](const crsm_slam::Slam& of) { return of.Marks(); }); },
          "marks()\n\n"
          "All places with names, where they lie by now: a list of PlacedMark.")
      .def(
          "begin_drive", [](PySlam& slam) { slam.Do([](crsm_slam::Slam& of) { of.BeginDrive(); }); },
          "begin_drive()\n\n"
          "Another drive begins with the next scan: the robot may be anywhere.")
      .def(
          "finish_map", [](PySlam& slam) { slam.Do([](crsm_slam::Slam& of) { of.FinishMap(); }); },
          "finish_map()\n\n"
          "From now on scans are localised on the map, and change nothing. Trajectory and verdict begin anew.\n"
          "Save the map before: later it can't be.");
}

void AddLog(py::module_& module) {
  py::class_<Log>(
      module, "Log",
      "Log(name, *, laser_channel=None, laser_frame=None, odometry=True, odometry_topic=None, mirrored=None,\n"
      "    **settings)\n\n"
      "A log that slam_offline reads (CARMEN, LCM, bags of ROS 1 and 2, MCAP, these compressed), a simulated\n"
      "world ('sim:demo') or a laser ('rplidar:/dev/ttyUSB0'). Iterating gives each Scan: a loop over a log\n"
      "begins with its first scan, so one loop at a time. It is looked at first, and one line on stderr says\n"
      "what the laser is: `settings` are those for Slam(**log.settings).\n\n"
      "  name: str or pathlib.Path\n"
      "  laser_channel: channel or topic of the laser, where the log has several\n"
      "  laser_frame: frame of the laser, where a topic has several\n"
      "  odometry: True gives each scan the log's odometry, where it has some; False leaves it out\n"
      "  odometry_topic: channel or topic of the odometry, or its frame in TF, where the log has several\n"
      "  mirrored: True turns scans round, False leaves them as they are; None: as the log's odometry shows\n"
      "  settings: as of Slam\n\n"
      "Raises RuntimeError, one line, if there is no such log, or if it has no laser.")
      .def(py::init([](const py::object& name, const py::kwargs& keywords) {
             return std::make_unique<Log>(crsm_python::ToPath(name, "name"), keywords);
           }),
           py::arg("name"))
      .def("__iter__", &Log::Iterate, py::return_value_policy::reference_internal, "The first Scan comes next.")
      .def("__next__", &Log::Next, "The next Scan.")
      .def("__repr__", [](const Log& log) { return "Log(" + std::string(py::repr(py::str(log.name()))) + ")"; })
      .def_property_readonly("settings", &Log::settings, "a dict, for Slam(**log.settings)")
      .def_property_readonly("progress", &Log::progress,
                             "how much has been read, 0 to 1; the number of scans is not known")
      .def_property_readonly(
          "true_pose",
          [](const Log& log) -> py::object {
            const auto pose = log.TruePose();
            return pose ? py::object(ToArray(*pose)) : py::none();
          },
          "(3,), float64: where the laser truly stood at the last scan, of simulated worlds; else None");
}

}  // namespace

/// Without this, TYPE.__new__(TYPE), which copy and pickle call too, gives an object whose value is whatever lies in
/// memory. Classes of Python that are made from these are left as they are.
void RefuseNew(const py::handle& type) {
  auto* const plain = reinterpret_cast<PyTypeObject*>(type.ptr());
  const py::cpp_function make([plain](const py::handle& wanted, const py::args&, const py::kwargs&) {
    auto* const of = reinterpret_cast<PyTypeObject*>(wanted.ptr());
    if (of == plain || !PyType_Check(wanted.ptr()) || PyType_IsSubtype(of, plain) == 0) {
      throw py::type_error(std::string(plain->tp_name) + ": cannot be copied, pickled or made by __new__");
    }
    const auto object = py::reinterpret_steal<py::object>(plain->tp_new(of, py::tuple().ptr(), nullptr));
    if (!object) throw py::error_already_set();
    return object;
  });
  // In the dictionary alone: a call of the type still makes objects as it did.
  const py::object method = py::reinterpret_steal<py::object>(PyStaticMethod_New(make.ptr()));
  if (PyDict_SetItemString(plain->tp_dict, "__new__", method.ptr()) != 0) throw py::error_already_set();
  PyType_Modified(plain);
}

/// Errors that name a path, which need not be UTF-8.
void TranslateError(std::exception_ptr error) {
  try {
    if (error) std::rethrow_exception(error);
  } catch (const py::error_already_set&) {
    throw;
  } catch (const py::builtin_exception&) {
    throw;
  } catch (const std::runtime_error& plain) {
    const auto text = py::reinterpret_steal<py::object>(PyUnicode_DecodeFSDefault(plain.what()));
    if (text) PyErr_SetObject(PyExc_RuntimeError, text.ptr());
  }
}

PYBIND11_MODULE(_crsm_slam, module) {
  py::options options;
  options.disable_function_signatures();  // they stand in the texts, as Python writes them
  py::register_exception_translator(&TranslateError);
  AddEnums(module);
  AddScan(module);
  AddResults(module);
  AddSlam(module);
  AddLog(module);
  for (const auto& [name, value] : module.attr("__dict__").cast<py::dict>()) {
    if (PyType_Check(value.ptr()) && !py::hasattr(value, "__members__")) RefuseNew(value);
  }
  py::module_::import("atexit").attr("register")(py::cpp_function(&WithoutGil::End));
  module.def("presets", &crsm_slam::Presets, "presets()\n\nThe names of the presets, one for each laser.");
  module.def("version", &crsm_slam::Version, "version()\n\nThe version of the library: '0.3.0'.");
}
