#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/logs/laser_source.hpp"
#include "common/parameters.hpp"
#include "services/settings/command_line.hpp"
#include "services/sources/laser_choice.hpp"

namespace crsm {

struct SourceOptions {
  std::uint64_t seed = 0;  ///< of the simulator's noise
  LaserChoice laser = {};
  LaserMessageOptions messages = {};
  std::string program = {};         ///< which says on stderr what becomes of a live laser
  std::string odometry_topic = {};  ///< topic, frame of TF or LCM channel; empty for the usual ones
};

/// As the flags of a program say.
SourceOptions SourceOptionsOf(const CommandLine& command_line);

/// What `name` of OpenLaserSource may be, for --help.
std::string DescribeSources();

/// Opens what `name` says: "sim:NAME" a built-in world, "sim:FILE" a world file, "hokuyo:PORT" and its like a laser,
/// which need not be there yet (devices/live_laser.hpp), else a CARMEN or LCM log or a bag (a file of ROS 1 or 2, MCAP,
/// or a folder of ROS 2). Which kind of log it is, and what has compressed it, is found from its content. A name with *
/// or ? stands for the parts of one log that its recorder has split.
/// Throws std::runtime_error, one line, if there is no such thing, if it has no laser or not the odometry that
/// `options` name, or if the world file is wrong.
std::unique_ptr<LaserSource> OpenLaserSource(const std::string& name, const SourceOptions& options);

/// The files that a source is read from, by its name; none of a laser or a built-in world.
std::vector<std::string> FilesOfSource(const std::string& name);

/// Throws std::runtime_error, one line, that `name` has no scans and what is wrong with those that were left out, for
/// who has read all of `source` and got none.
[[noreturn]] void ThrowNoScans(const std::string& name, const LaserSource& source);

/// One line about a log that ends before its end, for who has read all of `source`; empty if it does not. What was
/// whole has been read.
std::string DescribeCut(const std::string& name, const LaserSource& source);

/// A line each about what of a log was left out, for who has read all of `source`.
std::vector<std::string> DescribeComplaints(const std::string& name, const LaserSource& source);

/// A line each about the odometry of a log, for who has read all of `source` and uses it: as of OdometryNotes.
std::vector<std::string> DescribeOdometry(const std::string& name, const LaserSource& source);

}  // namespace crsm
