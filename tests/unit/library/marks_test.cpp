#include <cmath>
#include <crsm_slam/slam.hpp>

#include "catch.hpp"
#include "common/worlds/simulator.hpp"
#include "scratch.hpp"

namespace {

using namespace crsm;

/// A drive of some seconds; the laser's utimes and where it truly stood.
struct Drive {
  Drive() {
    Simulator simulator(LoadWorld("demo"), 1);
    for (int i = 0; i < 150; ++i) {
      const auto scan = simulator.Next();
      slam.Process({scan->utime, scan->angle_min_rad, scan->angle_step_rad, scan->ranges_m});
      utimes.push_back(scan->utime);
      poses.push_back(*simulator.TruePose());
    }
  }
  crsm_slam::Slam slam{{.preset = "utm-30lx"}};
  std::vector<std::int64_t> utimes;
  std::vector<Pose2> poses;
};

crsm_slam::Mark Victim(std::optional<std::int64_t> utime) { return {"v", "victim", "in the hall", utime}; }

void CheckSame(const std::vector<crsm_slam::PlacedMark>& a, const std::vector<crsm_slam::PlacedMark>& b) {
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    CHECK(a[i].id == b[i].id);
    CHECK(a[i].name == b[i].name);
    CHECK(a[i].points_m == b[i].points_m);
    CHECK(a[i].covariance == b[i].covariance);
    CHECK(a[i].sightings == b[i].sightings);
    CHECK(a[i].on_map == b[i].on_map);
  }
}

}  // namespace

TEST_CASE("the library takes in marks, moves and removes them, and keeps them with the map") {
  Drive drive;
  crsm_slam::Slam& slam = drive.slam;
  CHECK(slam.Marks().empty());
  slam.AddMark(Victim(drive.utimes[50]));
  slam.AddMark(Victim(drive.utimes[50]));  // counts once
  slam.AddMark({"zone", "keep-out", "", {}, {{0.0, 0.0}, {2.0, 0.0}, {1.0, 1.0}}});
  const auto marks = slam.Marks();
  REQUIRE(marks.size() == 2);
  CHECK(marks[0].sightings == 1);
  CHECK(marks[0].name == "in the hall");
  CHECK(std::abs(marks[0].points_m[0][0] - drive.poses[50].x_m) < 0.05);
  CHECK(std::abs(marks[0].points_m[0][1] - drive.poses[50].y_m) < 0.05);
  CHECK(marks[0].covariance == std::array{0.25, 0.0, 0.25});
  CHECK(marks[1].points_m.size() == 3);

  const ScratchFolder folder;
  slam.Save(folder / "out");
  CHECK(BytesOf(folder / "out/marks.csv").find("v,victim,in the hall,") != std::string::npos);
  crsm_slam::Slam loaded = crsm_slam::Slam::Load(folder / "out");
  CheckSame(loaded.Marks(), marks);
  loaded.RemoveMark("zone");
  CHECK_THROWS_AS(loaded.RemoveMark("zone"), std::invalid_argument);
  CHECK_THROWS_AS(loaded.AddMark({"zone", "keep-out"}), std::invalid_argument);  // in the map's frame
  loaded.MoveMark({"zone", "door", "", {}, {{1.0, 2.0}}});
  loaded.RemoveMark("zone");
  loaded.RemoveMark("v");
  loaded.Save(folder / "out");
  CHECK(crsm_slam::Slam::Load(folder / "out").Marks().empty());
  CHECK_FALSE(std::filesystem::exists(folder / "out/marks.csv"));
  slam.FinishMap();
  CheckSame(slam.Marks(), marks);
}

TEST_CASE("the library refuses a mark that is none, in one line that says why") {
  Drive drive;
  const auto Says = [&](const crsm_slam::Mark& mark, const std::string& why) {
    const std::string error = ErrorOf([&] { drive.slam.AddMark(mark); });
    CAPTURE(error);
    return error.find("mark '" + mark.id + "': ") == 0 && error.find(why) != std::string::npos;
  };
  CHECK(Says({"", "victim"}, "the id must have"));
  CHECK(Says({"v", "A Victim"}, "a-z, 0-9 and -"));
  CHECK(Says({"v", "victim", std::string(64, 'x')}, "the name must have"));
  CHECK(Says({"v", "victim", "", {}, {}}, "has 0 points"));
  CHECK(Says({"v", "victim", "", {}, {{NAN, 0.0}}}, "finite"));
  CHECK(Says({"v", "victim", "", {}, {{0.0, 0.0}}, 0.0}, "radius"));
  CHECK(Says({"v", "victim", "", drive.utimes.back() + 1'000'000}, "no scan was matched within 0.5 s"));
  CHECK(Says({"v", "victim", "", -5}, "the time must be"));
  CHECK(drive.slam.Marks().empty());
  crsm_slam::Slam empty;
  CHECK(ErrorOf([&] { empty.AddMark({"v", "victim"}); }).find("there is no map yet") != std::string::npos);
}
