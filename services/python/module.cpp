// The Python module crsm_slam._crsm_slam: the library, and the logs that the programs read, for Python.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <crsm_slam/slam.hpp>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "services/settings/command_line.hpp"
#include "services/sources/open_laser_source.hpp"
#include "services/sources/study_laser.hpp"

namespace py = pybind11;

namespace {

using crsm_slam::Pose;
using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

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

/// How a flag or a file would say it.
std::string TextOf(const py::handle& value) {
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "true" : "false";
  return py::str(value);
}

crsm_slam::Settings ToSettings(const py::dict& keywords) {
  crsm_slam::Settings settings;
  for (const auto& [key, value] : keywords) {
    const auto name = key.cast<std::string>();
    if (value.is_none()) continue;
    if (name == "preset") {
      settings.preset = py::str(value);
    } else if (name == "profile") {
      settings.profile = py::str(value);
    } else {
      settings.values[name] = TextOf(value);
    }
  }
  return settings;
}

std::vector<float> ToFloats(const Floats& array, const char* name) {
  if (array.ndim() != 1) throw py::value_error(std::string(name) + ": must have one dimension");
  return {array.data(), array.data() + array.size()};
}

std::optional<Pose> ToPose(const std::optional<Doubles>& array, const char* name) {
  if (!array) return std::nullopt;
  if (array->size() != 3) throw py::value_error(std::string(name) + ": must be x [m], y [m], yaw [rad]");
  return Pose{array->data()[0], array->data()[1], array->data()[2]};
}

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

/// A scan, and the odometry that came with it.
struct ScanWithOdometry {
  crsm_slam::Scan scan;
  std::optional<Pose> T_odom_robot;
};

ScanWithOdometry MakeScan(const Floats& ranges_m, float angle_min_rad, float angle_step_rad, std::int64_t utime,
                          const std::optional<Floats>& times_s, const std::optional<Doubles>& odometry) {
  return {{utime, angle_min_rad, angle_step_rad, ToFloats(ranges_m, "ranges_m"),
           times_s ? ToFloats(*times_s, "times_s") : std::vector<float>()},
          ToPose(odometry, "odometry")};
}

/// While it works other threads of Python run; of two that ask for the same object, one waits.
class PySlam {
 public:
  explicit PySlam(crsm_slam::Slam slam) : slam_(std::move(slam)) {}

  template <class Work>
  auto Do(Work&& work) {
    const py::gil_scoped_release release;
    const std::lock_guard lock(mutex_);
    return work(slam_);
  }

  crsm_slam::Step Process(const ScanWithOdometry& scan) {
    return Do([&](crsm_slam::Slam& slam) { return slam.Process(scan.scan, scan.T_odom_robot); });
  }

 private:
  std::mutex mutex_;
  crsm_slam::Slam slam_;
};

py::array_t<PoseRow> TrajectoryOf(PySlam& slam) {
  const auto poses = slam.Do([](const crsm_slam::Slam& of) { return of.Trajectory(); });
  py::array_t<PoseRow> rows(static_cast<py::ssize_t>(poses.size()));
  PoseRow* row = rows.mutable_data();
  for (const crsm_slam::StampedPose& pose : poses) {
    const auto& [x_m, y_m, yaw_rad] = pose.T_map_laser;
    *row++ = {pose.utime, x_m, y_m, yaw_rad, static_cast<std::uint8_t>(pose.state), pose.piece};
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
    const crsm_slam::Settings settings = ToSettings(CheckedSettings(keywords));
    const crsm_slam::Slam checks(settings);  // throws what is wrong with them
    std::vector<std::string> words{"crsm_slam"};
    for (const auto& [key, value] : keywords) AddFlag(key.cast<std::string>(), value, words);
    const py::gil_scoped_release release;
    using enum crsm::ParameterGroup;
    command_line_ = std::make_unique<crsm::CommandLine>(
        "crsm_slam", "", std::vector{kSeed, kLaser, kScan, kSelection, kMatch, kUpdate, kLoops, kAlgorithm}, kKeys);
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
    const py::gil_scoped_release release;
    Rewind();
    return *this;
  }

  ScanWithOdometry Next() {
    std::optional<crsm::LaserScan> scan;
    {
      const py::gil_scoped_release release;
      scan = source_->Next();
    }
    if (!scan) throw py::stop_iteration();
    std::optional<Pose> T_odom_robot;
    if (const auto odometry = source_->Odometry(); odometry && command_line_->settings().odometry)
      T_odom_robot = Pose{odometry->x_m, odometry->y_m, odometry->yaw_rad};
    return {
        {scan->utime, scan->angle_min_rad, scan->angle_step_rad, std::move(scan->ranges_m), std::move(scan->times_s)},
        T_odom_robot};
  }

  std::optional<Pose> TruePose() const {
    const auto pose = source_->TruePose();
    return pose ? std::optional(Pose{pose->x_m, pose->y_m, pose->yaw_rad}) : std::nullopt;
  }

  double progress() const { return source_->Progress(); }

  py::dict settings() const {
    py::dict settings;
    for (const auto& [key, value] : crsm::ListParameters(command_line_->parameters()))
      settings[key.c_str()] = ToPython(value);
    return settings;
  }

 private:
  static inline const std::vector<std::string> kKeys{"laser_channel", "laser_frame", "odometry", "odometry_topic",
                                                     "botlab_clockwise"};

  /// Those of the map.
  static py::dict CheckedSettings(const py::dict& keywords) {
    py::dict settings;
    for (const auto& [key, value] : keywords) {
      if (std::ranges::find(kKeys, key.cast<std::string>()) == kKeys.end()) settings[key] = value;
    }
    return settings;
  }

  static void AddFlag(const std::string& key, const py::handle& value, std::vector<std::string>& words) {
    if (value.is_none()) return;
    if (!py::isinstance<py::bool_>(value)) {
      words.insert(words.end(), {crsm::FlagOf(key), TextOf(value)});
    } else {
      words.push_back(value.cast<bool>() ? crsm::FlagOf(key) : "--no" + crsm::FlagOf(key).substr(1));
    }
  }

  std::string name_;
  std::unique_ptr<crsm::CommandLine> command_line_;
  std::unique_ptr<crsm::LaserSource> source_;
};

std::string Describe(const crsm_slam::Step& step) {
  return "Step(state=" + std::string(py::str(py::cast(step.state))) +
         ", T_map_laser=" + std::string(py::str(ToArray(step.T_map_laser))) +
         ", fitness=" + std::string(py::str(py::float_(step.fitness))) + ")";
}

void AddTypes(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(PoseRow, utime, x_m, y_m, yaw_rad, state, piece);
  PYBIND11_NUMPY_DTYPE(LoopRow, older_utime, newer_utime, x_m, y_m, yaw_rad);

  py::enum_<crsm_slam::State>(module, "State", "How the pose of a scan was found.")
      .value("FIRST", crsm_slam::State::kFirst, "a trajectory begins: the pose is the origin, or a guess")
      .value("OK", crsm_slam::State::kOk, "matched to the map")
      .value("LOST", crsm_slam::State::kLost, "no pose explains the scan: the pose is a guess")
      .value("DEGENERATE", crsm_slam::State::kDegenerate, "matched, but one direction is open, as in a bare corridor");
  py::enum_<crsm_slam::Trust>(module, "Trust", "Whether a map can be trusted.")
      .value("GOOD", crsm_slam::Trust::kGood, "no check found a fault")
      .value("DOUBTFUL", crsm_slam::Trust::kDoubtful, "look at the map before you rely on it")
      .value("BAD", crsm_slam::Trust::kBad, "not to be trusted");

  py::class_<ScanWithOdometry>(module, "Scan", "One sweep of a planar laser.")
      .def(py::init(&MakeScan), py::arg("ranges_m"), py::kw_only(), py::arg("angle_min_rad"), py::arg("angle_step_rad"),
           py::arg("utime"), py::arg("times_s") = py::none(), py::arg("odometry") = py::none(),
           "ranges_m: (N,) [m], of 2 to 4096 beams; <= 0, NaN, inf or above the maximum range: no return.\n"
           "angle_min_rad: angle of beam 0 from x, counter-clockwise. angle_step_rad: from a beam to the next.\n"
           "utime: time of the scan [us], 0 or later; it identifies the scan. times_s: (N,), when each beam was\n"
           "measured, from utime on [s]. odometry: x [m], y [m], yaw [rad] by the wheels.")
      .def_property_readonly("ranges_m",
                             [](const ScanWithOdometry& scan) {
                               return Floats(static_cast<py::ssize_t>(scan.scan.ranges_m.size()),
                                             scan.scan.ranges_m.data());
                             })
      .def_property_readonly(
          "times_s",
          [](const ScanWithOdometry& scan) {
            return Floats(static_cast<py::ssize_t>(scan.scan.times_s.size()), scan.scan.times_s.data());
          },
          "(N,) [s], or (0,) where that is not known")
      .def_property_readonly("angle_min_rad", [](const ScanWithOdometry& scan) { return scan.scan.angle_min_rad; })
      .def_property_readonly("angle_step_rad", [](const ScanWithOdometry& scan) { return scan.scan.angle_step_rad; })
      .def_property_readonly("utime", [](const ScanWithOdometry& scan) { return scan.scan.utime; })
      .def_property_readonly("odometry", [](const ScanWithOdometry& scan) -> py::object {
        return scan.T_odom_robot ? py::object(ToArray(*scan.T_odom_robot)) : py::none();
      });

  py::class_<crsm_slam::Step>(module, "Step", "The result of one scan.")
      .def_readonly("state", &crsm_slam::Step::state)
      .def_property_readonly(
          "T_map_laser", [](const crsm_slam::Step& step) { return ToArray(step.T_map_laser); },
          "(3,): x [m], y [m], yaw [rad]")
      .def_property_readonly(
          "T_local_laser", [](const crsm_slam::Step& step) { return ToArray(step.T_local_laser); },
          "(3,): the same in a frame that drifts, without jumps")
      .def_readonly("fitness", &crsm_slam::Step::fitness, "of the scan at that pose, 0 to 1")
      .def_property_readonly(
          "covariance", [](const crsm_slam::Step& step) { return ToMatrix(step.covariance); },
          "(3, 3), of x [m], y [m], yaw [rad]")
      .def_property_readonly(
          "degenerate_axis", [](const crsm_slam::Step& step) { return ToArray(step.degenerate_axis); },
          "(2,): unit vector, map frame, if the state is DEGENERATE; else 0")
      .def_readonly("drawn", &crsm_slam::Step::drawn, "the scan is in the map")
      .def_readonly("loop_closed", &crsm_slam::Step::loop_closed, "map and trajectory were corrected")
      .def_readonly("on_map", &crsm_slam::Step::on_map, "this part of the path is joined with the map")
      .def("__repr__", &Describe);

  py::class_<crsm_slam::Map>(module, "Map", "The smallest rectangle with all explored cells.")
      .def_property_readonly(
          "cells",
          [](const crsm_slam::Map& map) { return ToCells(map.cells.data(), map.height_cells, map.width_cells); },
          "(height, width), uint8, y up: 255 free .. 0 occupied, 127 unexplored")
      .def_readonly("cell_size_m", &crsm_slam::Map::cell_size_m)
      .def_property_readonly(
          "origin_m",
          [](const crsm_slam::Map& map) {
            return ToArray(std::array<double, 2>{map.T_map_grid.x_m, map.T_map_grid.y_m});
          },
          "(2,): x and y of the lower left corner, map frame [m]")
      .def_property_readonly(
          "extent_m",
          [](const crsm_slam::Map& map) {
            const auto& [x_m, y_m, yaw_rad] = map.T_map_grid;
            return py::make_tuple(x_m, x_m + map.width_cells * map.cell_size_m, y_m,
                                  y_m + map.height_cells * map.cell_size_m);
          },
          "left, right, bottom, top [m], as matplotlib.imshow takes it with origin='lower'");

  py::class_<crsm_slam::MapChanges::Tile>(module, "Tile", "A square of 64 x 64 cells.")
      .def_readonly("x_cells", &crsm_slam::MapChanges::Tile::x_cells, "of its lower left cell, from the map's origin")
      .def_readonly("y_cells", &crsm_slam::MapChanges::Tile::y_cells)
      .def_property_readonly(
          "cells", [](const crsm_slam::MapChanges::Tile& tile) { return ToCells(tile.cells.data(), 64, 64); },
          "(64, 64), uint8, y up, as of Map");
  py::class_<crsm_slam::MapChanges>(module, "MapChanges", "What changed in a map.")
      .def_readonly("version", &crsm_slam::MapChanges::version)
      .def_readonly("cell_size_m", &crsm_slam::MapChanges::cell_size_m)
      .def_readonly("tiles", &crsm_slam::MapChanges::tiles);

  py::class_<crsm_slam::Verdict>(module, "Verdict", "What speaks for a map and against it.")
      .def_readonly("trust", &crsm_slam::Verdict::trust)
      .def_readonly("lines", &crsm_slam::Verdict::lines, "for people: what came of the scans, and the reasons")
      .def_readonly("off_m", &crsm_slam::Verdict::off_m, "how far off parts of the map may be [m], or None")
      .def("__str__", [](const crsm_slam::Verdict& verdict) {
        std::string text;
        for (const std::string& line : verdict.lines) text += (text.empty() ? "" : "\n") + line;
        return text;
      });
}

void AddSlam(py::module_& module) {
  py::class_<PySlam>(module, "Slam",
                     "Makes a map, scan by scan. Settings are keywords: preset, profile, and those of\n"
                     "`slam_offline --help`, with _ for -: Slam(preset='sick', cell_size_m=0.1, loops=False).\n"
                     "Other threads run while it works. Lengths are in metres, angles in radians.")
      .def(py::init([](const py::kwargs& settings) {
             return std::make_unique<PySlam>(crsm_slam::Slam(ToSettings(settings)));
           }),
           "Raises ValueError, one line, for a setting that does not exist or has a wrong value.")
      .def_static(
          "load",
          [](const std::string& folder, const std::optional<Doubles>& start, const py::kwargs& keywords) {
            const crsm_slam::Settings settings = ToSettings(keywords);
            const auto T_map_laser = ToPose(start, "start");
            const py::gil_scoped_release release;
            return std::make_unique<PySlam>(crsm_slam::Slam::Load(folder, settings, T_map_laser));
          },
          py::arg("folder"), py::arg("start") = py::none(),
          "A map that was saved, by slam_offline or run_stack too. The next scan goes on with it, or is localised\n"
          "after finish_map(). start: x, y, yaw, about where the next scan is taken.")
      .def("process", &PySlam::Process, py::arg("scan"),
           "Finds the pose of a Scan, draws it into the map, and closes loops.")
      .def(
          "process",
          [](PySlam& slam, const Floats& ranges_m, float angle_min_rad, float angle_step_rad, std::int64_t utime,
             const std::optional<Floats>& times_s, const std::optional<Doubles>& odometry) {
            return slam.Process(MakeScan(ranges_m, angle_min_rad, angle_step_rad, utime, times_s, odometry));
          },
          py::arg("ranges_m"), py::kw_only(), py::arg("angle_min_rad"), py::arg("angle_step_rad"), py::arg("utime"),
          py::arg("times_s") = py::none(), py::arg("odometry") = py::none(),
          "The same of ranges (N,) [m] and what Scan takes besides. Raises ValueError for an invalid scan and for a\n"
          "utime that was used before; the map does not change then.")
      .def(
          "make_map", [](PySlam& slam) { return slam.Do([](const crsm_slam::Slam& of) { return of.MakeMap(); }); },
          "The Map of all scans so far, corrected by all loop closures. Takes as long as some hundred scans.")
      .def(
          "trajectory", &TrajectoryOf,
          "(scans,), with the fields utime [us], x_m, y_m, yaw_rad (T_map_laser, corrected), state (State), and piece\n"
          "(1: on the map of make_map).")
      .def("loops", &LoopsOf,
           "(loops,), with the fields older_utime, newer_utime [us], x_m, y_m, yaw_rad (T_older_newer).")
      .def(
          "changes_since",
          [](PySlam& slam, std::int64_t version) {
            return slam.Do([&](crsm_slam::Slam& of) { return of.ChangesSince(version); });
          },
          py::arg("version") = 0, "MapChanges since a version of the map that a call before has named; 0: all of it.")
      .def(
          "judge", [](PySlam& slam) { return slam.Do([](const crsm_slam::Slam& of) { return of.Judge(); }); },
          "The Verdict: whether the map can be trusted, and why.")
      .def(
          "save",
          [](PySlam& slam, const std::string& folder) { slam.Do([&](const crsm_slam::Slam& of) { of.Save(folder); }); },
          py::arg("folder"),
          "Writes map.png, map.pgm, map.yaml, trajectory.tum, graph.g2o, and journal/, of which load() and "
          "slam_offline\n"
          "make the map again.")
      .def(
          "begin_drive", [](PySlam& slam) { slam.Do([](crsm_slam::Slam& of) { of.BeginDrive(); }); },
          "Another drive begins with the next scan: the robot may be anywhere.")
      .def(
          "finish_map", [](PySlam& slam) { slam.Do([](crsm_slam::Slam& of) { of.FinishMap(); }); },
          "From now on scans are localised on the map, and change nothing.");
}

}  // namespace

PYBIND11_MODULE(_crsm_slam, module) {
  AddTypes(module);
  AddSlam(module);
  py::class_<Log>(
      module, "Log",
      "A log that slam_offline reads (CARMEN, LCM, bags of ROS 1 and 2, MCAP, these compressed) or a\n"
      "simulated world ('sim:demo'). It is looked at first, and one line on stderr says what the laser is:\n"
      "`settings` are those for Slam(**log.settings). Iterating gives each Scan, from the first one on.")
      .def(py::init([](const std::string& name, const py::kwargs& keywords) {
             return std::make_unique<Log>(name, keywords);
           }),
           py::arg("name"), "Keywords: settings as of Slam, and laser_channel, laser_frame, odometry, odometry_topic.")
      .def("__iter__", &Log::Iterate, py::return_value_policy::reference_internal)
      .def("__next__", &Log::Next)
      .def_property_readonly("settings", &Log::settings, "a dict, for Slam(**log.settings)")
      .def_property_readonly("progress", &Log::progress, "how much has been read, 0 to 1")
      .def_property_readonly(
          "true_pose",
          [](const Log& log) -> py::object {
            const auto pose = log.TruePose();
            return pose ? py::object(ToArray(*pose)) : py::none();
          },
          "(3,): where the laser truly stood at the last scan, of simulated worlds; else None");
  module.def("presets", &crsm_slam::Presets, "The names of the presets, one for each laser.");
  module.def("version", &crsm_slam::Version);
}
