#include <cmath>

#include "catch.hpp"
#include "common/math/trigonometry.hpp"
#include "services/sources/bags/bag_source.hpp"
#include "services/sources/open_laser_source.hpp"
#include "source_helpers.hpp"
#include "transform_bytes.hpp"

namespace crsm {
namespace {

enum Connection : std::uint32_t { kScan, kOdom, kOther, kTf, kStatic, kPose };

constexpr const char* kTfType = "tf2_msgs/TFMessage";

/// A ROS 1 bag of records. Its topics must be put in first.
class Bag {
 public:
  Bag& Topic(Connection number, const std::string& name, const std::string& type) {
    records_ += Ros1Connection(number, name, type);
    return *this;
  }
  Bag& Scan(std::uint32_t nanosec, const std::string& frame = "laser") {
    records_ += Ros1Message(kScan, LaserMessage{.nanosec = nanosec, .frame = frame}.Ros1());
    return *this;
  }
  Bag& Odometry(const TransformFields& fields, Connection number = kOdom) {
    records_ += Ros1Message(number, Ros1Odometry(fields));
    return *this;
  }
  Bag& Tf(const std::vector<TransformFields>& transforms, Connection number = kTf) {
    records_ += Ros1Message(number, Ros1Transforms(transforms));
    return *this;
  }
  Bag& Add(Connection number, const std::string& data) {
    records_ += Ros1Message(number, data);
    return *this;
  }
  std::string bytes() const { return Ros1Bytes(records_); }

 private:
  std::string records_;
};

Bag WithTf() { return Bag().Topic(kScan, "/scan", "sensor_msgs/LaserScan").Topic(kTf, "/tf", kTfType); }
Bag WithOdometry() {
  return Bag().Topic(kScan, "/scan", "sensor_msgs/LaserScan").Topic(kOdom, "/odom", "nav_msgs/Odometry");
}

using Poses = std::vector<std::optional<Pose2>>;
using Notes = std::vector<std::string>;

struct Result {
  Poses poses;  ///< by the odometry, of each scan
  std::int64_t num_bad = 0;
  Notes notes;
};

Result Read(const Bag& bag, const std::string& named = "") {
  const ScratchFile file(bag.bytes());
  BagSource source(file.path(), {"/scan"}, named);
  Result result;
  while (source.Next()) result.poses.push_back(source.Odometry());
  result.num_bad = CountOf(source, "bad_odometry");
  result.notes = source.OdometryNotes();
  return result;
}

std::string ErrorOfBag(const Bag& bag, const std::string& named) {
  return ErrorOf([&] { Read(bag, named); });
}

const double kHalf = std::sqrt(0.5);
const TransformFields kMounting{.parent = "base_link", .child = "laser", .x_m = 0.2, .rotation = {0, 0, 1, 0}};

TransformFields RobotAt(double x_m, std::uint32_t nanosec) { return {.x_m = x_m, .nanosec = nanosec}; }

}  // namespace

TEST_CASE("odometry of TF is where the laser is by the wheels, between two messages too") {
  // The mounting is known from the first scan on, wherever in the bag TF tells it.
  const Result result = Read(WithTf()
                                 .Tf({RobotAt(1.0, 0)})
                                 .Scan(0)
                                 .Scan(10'000'000)
                                 .Tf({RobotAt(2.0, 20'000'000), {.parent = "base_link", .child = "wheel"}})
                                 .Tf({kMounting}));
  CHECK(result.poses == Poses{Pose2{1.2, 0.0, 3.141592}, Pose2{1.7, 0.0, 3.141592}});
  CHECK(result.num_bad == 0);
  CHECK(result.notes == Notes{"gives odometry to 2 of 2 scans (base_link in the frame odom of TF): "
                              "the laser stands at x 0.200 m, y 0.000 m, yaw 180.0 deg on the robot"});
}

TEST_CASE("old TF is read as the new, with slashes and prefixes, and from a topic of its own for what never moves") {
  const Bag bag = Bag()
                      .Topic(kScan, "/scan", "sensor_msgs/LaserScan")
                      .Topic(kTf, "/tf", "tf/tfMessage")
                      .Topic(kStatic, "/tf_static", kTfType)
                      .Tf({{.parent = "/r1/odom", .child = "/r1/base", .x_m = 1.0}})
                      .Scan(0, "/r1/laser")
                      .Tf({{.parent = "r1/base", .child = "r1/laser", .y_m = 0.5, .sec = 0}}, kStatic);
  CHECK(Read(bag).poses == Poses{Pose2{1.0, 0.5, 0.0}});
}

TEST_CASE("a topic of odometry goes before TF, which then tells the mounting alone") {
  const Result result = Read(WithOdometry()
                                 .Topic(kTf, "/tf", kTfType)
                                 .Tf({kMounting, {.x_m = 9.0}})
                                 .Odometry({.x_m = 1.0, .rotation = {0, 0, kHalf, kHalf}})
                                 .Scan(0));
  CHECK(result.poses == Poses{Pose2{1.0, 0.2, -1.570797}});  // of two headings, each in whole microradians
  CHECK(
      result.notes.at(0).starts_with("gives odometry to 1 of 1 scans (base_link in /odom): the laser stands at x 0.2"));
}

TEST_CASE("without TF, or without a way in it, the odometry is the robot's, which is said") {
  const auto Mounting = [](const Result& result) {
    CHECK(result.poses == Poses{Pose2{1.0, 0.0, 0.0}});
    REQUIRE(result.notes.size() == 1);
    return result.notes[0].substr(result.notes[0].find("): ") + 3);
  };
  const std::string unknown = "where the laser stands on the robot is not known, as ";
  CHECK(Mounting(Read(WithOdometry().Odometry(RobotAt(1.0, 0)).Scan(0))) == unknown + "the bag has no TF");
  const Bag both = WithOdometry().Topic(kTf, "/tf", kTfType).Odometry(RobotAt(1.0, 0));
  CHECK(Mounting(Read(Bag(both).Scan(0).Tf({{.parent = "odom", .child = "laser"}}))) ==
        unknown + "TF does not lead from laser to base_link");
  CHECK(Mounting(Read(Bag(both).Scan(0, "").Tf({kMounting}))) == unknown + "the scans name no frame");
  const Bag nameless = WithOdometry().Topic(kTf, "/tf", kTfType).Odometry({.child = "", .x_m = 1.0}).Tf({kMounting});
  CHECK(Mounting(Read(Bag(nameless).Scan(0))) == unknown + "the odometry names no frame of the robot");
  const TransformFields tilted{.parent = "base_link", .child = "laser", .rotation = {0, kHalf, 0, kHalf}};
  CHECK(Mounting(Read(Bag(both).Tf({tilted}).Scan(0))) == unknown + "TF tilts it by 90 deg");
}

TEST_CASE("in TF without a way from the laser the only robot is meant, or of several the one with a usual name") {
  const auto Read2 = [](const std::vector<TransformFields>& robots) { return Read(WithTf().Tf(robots).Scan(0)); };
  const Result one = Read2({{.child = "kobuki", .x_m = 1.0}});
  CHECK(one.poses == Poses{Pose2{1.0, 0.0, 0.0}});
  CHECK(one.notes.at(0).ends_with("TF does not lead from laser to kobuki"));
  CHECK(Read2({{.child = "arm", .x_m = 2.0}, {.child = "base_footprint", .x_m = 1.0}}).poses == one.poses);
  const Result two = Read2({{.child = "a", .x_m = 2.0}, {.child = "b", .x_m = 1.0}});
  CHECK(two.poses == Poses{std::nullopt});
  CHECK(two.notes.at(0).ends_with("several robots could be meant: a in odom, b in odom"));
  CHECK(Read2({{.parent = "r1/odom"}, {.parent = "r2/odom", .child = "r2/base_link"}}).poses == two.poses);
}

TEST_CASE("what another program corrects is no odometry: TF that leads to a map alone is not used, which is said") {
  const Result result = Read(WithTf().Tf({kMounting, {.parent = "map", .x_m = 5.0}}).Scan(0));
  CHECK(result.poses == Poses{std::nullopt});
  CHECK(result.notes.at(0).ends_with("--odometry-topic may name another of its frames: base_link, map"));
}

TEST_CASE("which odometry is used is told from the start, and nothing of a bag that has none") {
  const auto NameIn = [](const Bag& bag) {
    const ScratchFile file(bag.bytes());
    return BagSource(file.path(), {"/scan"}).OdometryName();
  };
  CHECK(NameIn(WithTf().Tf({{}, kMounting}).Scan(0)) == "base_link in the frame odom of TF");
  CHECK(NameIn(WithOdometry().Topic(kTf, "/tf", kTfType).Odometry({}).Scan(0)) == "base_link in /odom");
  CHECK(NameIn(WithOdometry().Odometry({}).Scan(0)) == "/odom");
  CHECK(NameIn(WithTf().Tf({kMounting}).Scan(0)).empty());
  const Bag none = Bag().Topic(kScan, "/scan", "sensor_msgs/LaserScan").Scan(0);
  CHECK(NameIn(none).empty());
  CHECK(Read(none).notes.empty());
}

TEST_CASE("odometry that no scan can have says why") {
  const std::string start = "has odometry (base_link in /odom), but gives it to no scan: ";
  const Bag bag = WithOdometry().Topic(kTf, "/tf", kTfType);
  CHECK(Read(Bag(bag).Odometry({.sec = 7}).Odometry({.sec = 8}).Odometry({.sec = 2000}).Scan(0)).notes.at(0) ==
        start + "a scan needs a message within 0.1 s before it and one within 0.1 s after it, by their own times");
  Bag late = bag;
  for (std::uint32_t scan = 0; scan < 12; ++scan) late.Scan(50'000'000 * scan);
  CHECK(Read(late.Odometry({})).notes.at(0) ==
        start + "its messages stand too late in the recording, behind eight more scans or a second, or are too few");
}

TEST_CASE("a named topic is used, also one of poses, and one of several") {
  const Bag bag = WithOdometry()
                      .Topic(kOther, "/wheels", "nav_msgs/Odometry")
                      .Topic(kPose, "/vicon", "geometry_msgs/PoseStamped")
                      .Odometry(RobotAt(1.0, 0))
                      .Odometry(RobotAt(2.0, 0), kOther)
                      .Add(kPose, Ros1Pose(RobotAt(3.0, 0)))
                      .Scan(0);
  CHECK(Read(bag).poses == Poses{Pose2{1.0, 0.0, 0.0}});
  CHECK(Read(bag, "/wheels").poses == Poses{Pose2{2.0, 0.0, 0.0}});
  const Result poses = Read(bag, "/vicon");
  CHECK(poses.poses == Poses{Pose2{3.0, 0.0, 0.0}});
  CHECK(poses.notes.at(0).starts_with("gives odometry to 1 of 1 scans (/vicon): "));
}

TEST_CASE("a named frame of TF is used, before a topic and whatever it is called") {
  const Bag bag = WithOdometry()
                      .Topic(kTf, "/tf", kTfType)
                      .Odometry(RobotAt(1.0, 0))
                      .Tf({kMounting, RobotAt(2.0, 0), {.parent = "map", .child = "odom", .x_m = 3.0}})
                      .Scan(0);
  CHECK(Read(bag, "odom").poses == Poses{Pose2{2.2, 0.0, 3.141592}});
  const Bag vicon = WithTf().Tf({kMounting, {.parent = "vicon", .x_m = 4.0}}).Scan(0);
  CHECK(Read(vicon, "vicon").poses == Poses{Pose2{4.2, 0.0, 3.141592}});
  const Result map = Read(bag, "map");
  CHECK(map.poses == Poses{std::nullopt});
  CHECK(map.notes.at(0).ends_with("--odometry-topic odom is its odometry"));
}

TEST_CASE("odometry that is named and not there is an error that lists what there is") {
  CHECK(ErrorOfBag(WithOdometry().Scan(0), "/wheels")
            .ends_with("; its topics of odometry: /odom (nav_msgs/Odometry in ros1); it has no TF"));
  CHECK(ErrorOfBag(WithTf().Tf({kMounting, {}}).Scan(0), "/wheels")
            .ends_with("; frames in which others stand: base_link, odom"));
  CHECK(ErrorOfBag(WithOdometry().Scan(0), "/scan").find(" has no odometry /scan") != std::string::npos);
  CHECK(ErrorOfBag(WithOdometry().Scan(0), "/odo").ends_with("; it has no TF; did you mean /odom?"));
  CHECK(ErrorOfBag(WithOdometry().Scan(0), "/scam").ends_with("; it has no TF"));  // a laser is no odometry
  CHECK(ErrorOfBag(WithTf().Tf({kMounting, {}}).Scan(0), "odm")
            .ends_with("; frames in which others stand: base_link, odom; did you mean odom?"));
}

TEST_CASE("of several TF that of the laser's namespace is read") {
  for (const std::string robot : {"/a1", "/z1"}) {  // before and behind "/tf" in the list of topics
    const Bag bag = Bag()
                        .Topic(kScan, robot + "/scan", "sensor_msgs/LaserScan")
                        .Topic(kTf, robot + "/tf", kTfType)
                        .Topic(kStatic, "/other/tf", kTfType)
                        .Topic(kOther, "/tf", kTfType)
                        .Tf({RobotAt(1.0, 0)})
                        .Tf({RobotAt(2.0, 0)}, kStatic)
                        .Tf({RobotAt(3.0, 0)}, kOther)
                        .Scan(0);
    const ScratchFile file(bag.bytes());
    BagSource source(file.path(), {});
    REQUIRE(source.Next());
    CHECK(source.Odometry() == Pose2{1.0, 0.0, 0.0});
  }
}

TEST_CASE("bad TF is counted where it is the odometry's, and passed over") {
  const Result result = Read(WithTf()
                                 .Add(kTf, "no TF")
                                 .Tf({{.x_m = NAN}, {.parent = "base_link", .child = "wheel", .x_m = NAN}})
                                 .Tf({kMounting, RobotAt(1.0, 0)})
                                 .Scan(0));
  CHECK(result.poses == Poses{Pose2{1.2, 0.0, 3.141592}});
  CHECK(result.num_bad == 2);
}

TEST_CASE("a laser that hangs upside down by TF is known as such, and its scans stay") {
  const TransformFields mounting{.parent = "base_link", .child = "laser", .x_m = 0.2, .rotation = {1, 0, 0, 0}};
  const TransformFields upright{.parent = "base_link", .child = "laser", .x_m = 0.2, .rotation = {0, 0, 1, 0}};
  for (const Connection topic : {kTf, kStatic}) {
    const auto BagOf = [&](const TransformFields& fields) {
      return WithTf()
          .Topic(kStatic, "/tf_static", kTfType)
          .Tf({fields}, topic)
          .Tf({{.y_m = 1.0, .rotation = {0, 0, kHalf, kHalf}}})
          .Scan(0);
    };
    const ScratchFile hangs(BagOf(mounting).bytes());
    const ScratchFile stands(BagOf(upright).bytes());
    BagSource hanging(hangs.path(), {"/scan"});
    BagSource standing(stands.path(), {"/scan"});
    CHECK(hanging.IsUpsideDown());
    CHECK_FALSE(standing.IsUpsideDown());
    CHECK(hanging.Next() == standing.Next());
    CHECK(Read(BagOf(mounting)).poses == Poses{Pose2{0.0, 1.2, 1.570796}});
  }
}

TEST_CASE("a laser that moves on the robot is told") {
  const auto WithJointAt = [](double x_m) {
    return Read(WithTf()
                    .Tf({kMounting, {}})
                    .Scan(0)
                    .Tf({{.parent = "base_link", .child = "laser", .x_m = x_m, .rotation = {0, 0, 1, 0}}}));
  };
  CHECK(WithJointAt(0.21).notes.size() == 1);
  REQUIRE(WithJointAt(0.23).notes.size() == 2);
  CHECK(WithJointAt(0.23).notes[1].starts_with("has a laser that moves on the robot: laser turns or shifts in TF"));
}

TEST_CASE("bags that other programs wrote with TF alone give the drive of their laser") {
  for (const std::string name : {"tf.bag", "old_tf.bag", "tf.mcap", "tf.db3"}) {
    INFO(name);
    const auto source = OpenLaserSource(DataPath(name), {});
    for (int i = 0; i < 3; ++i) {
      REQUIRE(source->Next());
      REQUIRE(source->Odometry());
      CHECK(Distance(*source->Odometry(), {i * 0.1, 0.0, 0.0}) < 2e-6);  // rounding
      CHECK(std::abs(source->Odometry()->yaw_rad) < 2e-6);
    }
    CHECK(source->OdometryNotes().at(0).ends_with(
        "the laser stands at x 0.250 m, y -0.100 m, yaw 90.0 deg on the robot"));
  }
}

}  // namespace crsm
