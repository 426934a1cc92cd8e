#include "accuracy/courses.hpp"

#include <limits>

#include "real_logs.hpp"

namespace crsm {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::infinity();  // there is no truth to compare with

const std::vector<std::string> kWithLoops{"--loops", "--angle-scale", "1"};

/// With the logs' full paths; those of which a file is missing are left out, and that is said.
std::vector<Course> Find(const std::vector<Course>& courses) {
  std::vector<Course> found;
  for (Course course : courses) {
    std::string& relations = course.drive.relations;
    const auto log = FindRealLog(course.drive.source);
    const auto known = relations.empty() ? relations : FindRealLog(relations);
    if (!log || !known) continue;
    course.drive.source = *log;
    relations = *known;
    found.push_back(course);
  }
  return found;
}

}  // namespace

// Above each line of bounds stands what the program came to when they were set, over the seeds 1 to 48 of simulated
// drives and 1 to 24 of logs: CRSM_ACCURACY_SEEDS=48 measures that again. A bound keeps a tenth to a third of distance
// from the extreme or the median of so many seeds, and from the mean three deviations of the mean of the gate's runs.

std::vector<Course> SimulatedCourses() {
  return {
      // Turns of 0.5 rad between two scans. One seed of 48 has 0.455 m, all others have less than 0.1 m.
      // worst_m 0.455, typical_m 0.045, mean_m 0.0308, lost 0, fitness 0.8315
      {"hall", {"sim:hall", "utm-30lx"}, 8, {0.50, 0.055, 0.0345, 0.005, 0.8280}},
      // Where its corridors have no doors, some seeds slip by some decimetres.
      // worst_m 0.484, typical_m 0.291, mean_m 0.115 (deviation 0.047), lost 0, fitness 0.7516
      {"twins", {"sim:twins", "sick"}, 24, {0.60, 0.36, 0.144, 0.002, 0.745}},
      // Its walls lie on borders of cells, which moves the map of the first scan by half a cell along x and y: 0.035 m.
      // worst_m 0.120, typical_m 0.044, mean_m 0.0343 (deviation 0.0003), lost 0, fitness 0.7773
      {"corridor", {"sim:corridor"}, 8, {0.16, 0.055, 0.0360, 0.002, 0.774}},
      // worst_m 0.080, typical_m 0.029, mean_m 0.0136 (deviation 0.0024), lost 0, fitness 0.7051
      {"env2", {"sim:env2", "paper"}, 6, {0.10, 0.037, 0.0166, 0.001, 0.7015}},
      // worst_m 0.039, typical_m 0.021, mean_m 0.0103 (deviation 0.0026), lost 0, fitness 0.7023
      {"env3", {"sim:env3", "paper"}, 4, {0.050, 0.027, 0.0142, 0.001, 0.6985}},
      // worst_m 0.048, typical_m 0.030, mean_m 0.0170 (deviation 0.0048), lost 0, fitness 0.7061
      {"env1", {"sim:env1", "paper"}, 4, {0.060, 0.040, 0.0242, 0.001, 0.7025}},
      // worst_m 0.033, typical_m 0.025, mean_m 0.0131 (deviation 0.0020), lost 0, fitness 0.8279
      {"env4", {"sim:env4", "urg-04lx"}, 4, {0.037, 0.031, 0.0162, 0.001, 0.826}},
      // Bent by the angles of its beams it ends 1.3 m to 2.3 m beside the truth without loops. Of the seeds 1 to 20:
      // worst_m 0.500, typical_m 0.229, mean_m 0.1025 (deviation 0.032), lost 0, fitness about 0.71
      {"block", {"sim:block", "sick", "", {}, kWithLoops}, 4, {0.60, 0.36, 0.15, 0.002, 0.69}},
      // Walls on borders of cells, as in the corridor.
      // worst_m 0.043, typical_m 0.041, mean_m 0.0350 (deviation 0.0002), lost 0, fitness 0.8005
      {"demo", {"sim:demo"}, 4, {0.047, 0.045, 0.0365, 0.001, 0.798}},
  };
}

std::vector<Course> RealCourses() {
  return Find({
      // One loop, whose walls most seeds draw twice, is the worst of all; of three runs it may be the median too.
      // worst_m 1.588, typical_m 0.755, mean_m 0.0486 (deviation 0.0081), lost 0.0007, fitness 0.6724
      {"aces", {"radish/aces.clf.gz", "sick", "radish/aces.relations"}, 3, {1.9, 1.3, 0.0630, 0.0012, 0.665}},
      // worst_m 0.231, typical_m 0.127, mean_m 0.0191 (deviation 0.0015), lost 0.0004, fitness 0.7749
      {"intel", {"radish/intel.clf.gz", "sick", "radish/intel.relations"}, 3, {0.28, 0.20, 0.0217, 0.0008, 0.770}},
      // worst_m 0.196, typical_m 0.190, mean_m 0.0315 (deviation 0.0003), lost 0.0008, fitness 0.7486
      {"fr079",
       {"radish/fr079.clf.gz", "sick", "radish/fr079.relations", {-0.04, 0.0, 0.0}},
       3,
       {0.205, 0.200, 0.0323, 0.0015, 0.7455}},
      // With loops, and beams taken as they are said to look. Of 5 to 15 seeds the worst mean_m was 0.0373, 0.0188,
      // 0.0334 and 0.0475. A single relation may be one that no loop holds: the worst is not bounded.
      {"aces loop",
       {"radish/aces.clf.gz", "sick", "radish/aces.relations", {}, kWithLoops},
       2,
       {kUnknown, kUnknown, 0.0375, 0.0012, 0.665}},
      {"intel loop",
       {"radish/intel.clf.gz", "sick", "radish/intel.relations", {}, kWithLoops},
       2,
       {kUnknown, kUnknown, 0.0200, 0.0008, 0.770}},
      {"fr079 loop",
       {"radish/fr079.clf.gz", "sick", "radish/fr079.relations", {-0.04, 0.0, 0.0}, kWithLoops},
       2,
       {kUnknown, kUnknown, 0.0340, 0.0015, 0.7455}},
      {"killian",
       {"radish/killian.clf.gz", "sick", "radish/killian.relations", {}, kWithLoops},
       2,
       {kUnknown, kUnknown, 0.0500, 0.0015, 0.690}},
      // Where these two went nobody knows. What their maps are worth shows in how well the scans fit into them.
      // lost 0.0026, fitness 0.6477
      {"exp1", {"urg04lx/exp1.clf.gz", "urg-04lx"}, 3, {kUnknown, kUnknown, kUnknown, 0.005, 0.644}},
      // lost 0.0076, fitness 0.6326
      {"exp3", {"urg04lx/exp3.clf.gz", "urg-04lx"}, 3, {kUnknown, kUnknown, kUnknown, 0.012, 0.629}},
  });
}

}  // namespace crsm
