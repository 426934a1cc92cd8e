// Processes that are killed and sessions that end, wherever that may be: the files are those of one run in one go.

#include <algorithm>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "faults.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kFiles{"map.png", "trajectory.tum"};

const std::vector<std::string> kPrograms{"map_updater",  "loop_closer",  "rrhc_matcher",
                                         "ray_selector", "map_exporter", "laser_publisher"};

/// In each way of sharing three sessions between one process and the stack, in one folder or in folders of their own.
void MapInThreeSessions(const TemporaryFolder& folder, const FaultCourse& course, const std::vector<LaserScan>& scans,
                        const std::vector<std::ptrdiff_t>& ends, const std::vector<std::string>& ways) {
  for (const std::string& how : ways) {
    for (const bool in_one_folder : {false, true}) {
      CAPTURE(how, in_one_folder);
      std::string earlier;
      for (std::size_t part = 0; part < 3; ++part) {
        const std::string out = in_one_folder ? "session" : "session_" + std::to_string(part);
        if (part == 0 || !in_one_folder) fs::remove_all(folder / out);
        const std::string log = folder.Write({scans.begin() + ends[part], scans.begin() + ends[part + 1]}, "part");
        std::vector<std::string> flags = course.flags;
        if (part > 0) flags.insert(flags.end(), {"--resume", folder / earlier});
        how[part] == '1' ? folder.Map(log, out, flags) : folder.MapWithStack(log, out, flags);
        earlier = out;
      }
      folder.CheckSame(earlier, course.name, kFiles);
    }
  }
}

}  // namespace

TEST_CASE("processes that are killed in the middle of a run are started again: nothing is lost, doubled or changed") {
  const TemporaryFolder folder;
  const std::string log = folder.Write(TakeScans("sim:demo", 1500), "run.lcm");
  folder.Map(log, "offline");
  std::vector<Kill> kills{{0.2, "laser_publisher"}, {0.7, "laser_publisher"}};
  for (const std::string& program : kPrograms) kills.push_back({0.5, program});
  MapAndKill(folder, {"demo", log}, "out", kills, JournalBytes(folder / "offline"));
  folder.CheckSame("out", "offline");
  CHECK(folder.Summary("out")["scans"] == 1500);
}

TEST_CASE("kill", "[.][fault][kill]") {
  const TemporaryFolder folder;
  const int num_runs = ByEffort(3, 20, 20);
  const int num_kills_in_storm = ByEffort(5, 20, 20);
  Random random(1);
  for (const FaultCourse& course : WriteCourses(folder, Courses::kAll)) {
    INFO(course.name);
    folder.MapWithStack(course.log, course.name, course.flags);
    const std::uintmax_t end_bytes = JournalBytes(folder / course.name);
    for (int run = 0; run <= num_runs; ++run) {  // the last is the storm
      std::vector<Kill> kills;
      for (const std::string& program : kPrograms) {
        for (int i = 0; i < (run == num_runs ? num_kills_in_storm : 1); ++i) {
          kills.push_back({random.Uniform(0.0, 0.98), program});
        }
      }
      MapAndKill(folder, course, "killed", kills, end_bytes);
      folder.CheckSame("killed", course.name, kFiles);
      CHECK(CountHalfFiles(folder / "killed") == 0);
    }
    fmt::print("{}: {} runs in which each process is killed once, and one in which each is killed {} times: same map\n",
               course.name, num_runs, num_kills_in_storm);
  }
}

TEST_CASE("sessions", "[.][fault][sessions]") {
  const TemporaryFolder folder;
  Random random(1);
  for (const FaultCourse& course : WriteCourses(folder, Courses::kWithLoops)) {
    INFO(course.name);
    folder.Map(course.log, course.name, course.flags);
    const std::vector<LaserScan> scans = TakeScans(course.log, 1'000'000);
    for (int i = 0; i < ByEffort(1, 3, 3); ++i) {
      std::vector<std::ptrdiff_t> cuts{0, std::ssize(scans)};
      for (int k = 0; k < 2; ++k) cuts.push_back(static_cast<std::ptrdiff_t>(random.Next() % scans.size()));
      std::sort(cuts.begin(), cuts.end());
      CAPTURE(cuts);
      MapInThreeSessions(folder, course, scans, cuts, {"161", "616", "666"});
      fmt::print("{}: cut behind scans {} and {} of {}: same map\n", course.name, cuts[1], cuts[2], scans.size());
    }

    // The drive that is localised is the one that made the map: there is no harder one to tell from mapping.
    FaultCourse localised = course;
    localised.flags.insert(localised.flags.end(), {"--localize", folder / course.name});
    const std::string expected = course.name + "_localised";
    folder.Map(course.log, expected, localised.flags);
    std::vector<Kill> kills;
    for (int i = 0; i < ByEffort(3, 10, 10); ++i) kills.push_back({random.Uniform(0.0, 0.95), "map_updater"});
    MapAndKill(folder, localised, "killed", kills, JournalBytes(folder / expected));
    folder.CheckSame("killed", expected, kFiles);
    folder.CheckSame("killed", course.name, {"map.png"});
    fmt::print("{}: map_updater killed {} times while the robot was localised: same poses, same map\n", course.name,
               kills.size());
  }
}
