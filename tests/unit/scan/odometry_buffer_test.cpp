#include "common/scan/odometry_buffer.hpp"

#include <limits>

#include "catch.hpp"

namespace crsm {
namespace {

using State = ScanOdometry::State;

constexpr std::int64_t kSecond = 1'000'000;

OdometryBuffer BufferOf(std::initializer_list<Odometry> samples) {
  OdometryBuffer buffer;
  for (const Odometry& sample : samples) buffer.Add(sample);
  return buffer;
}

void CheckKnown(const ScanOdometry& odometry, const Pose2& expected) {
  CHECK(odometry.state == State::kKnown);
  CHECK(odometry.T_odom_robot == expected);
}

void CheckNotKnown(const ScanOdometry& odometry, State expected) {
  CHECK(odometry.state == expected);
  CHECK_FALSE(odometry.T_odom_robot);
}

const Pose2 kPose{1.0, 2.0, 3.0};

}  // namespace

TEST_CASE("where no odometry has come, a scan's is awaited") {
  CheckNotKnown(OdometryBuffer().Find(5), State::kAwaited);
  CheckNotKnown(OdometryBuffer().FindExact(5), State::kAwaited);
}

TEST_CASE("the odometry of a scan's own utime is its odometry as it is") {
  const OdometryBuffer buffer = BufferOf({{kSecond, kPose}});
  CheckKnown(buffer.Find(kSecond), kPose);
  CheckKnown(buffer.FindExact(kSecond), kPose);
}

TEST_CASE("a scan between two samples is where the robot was on the way between them") {
  const OdometryBuffer buffer = BufferOf({{kSecond, Pose2{1.0, 2.0, 0.4}}, {kSecond + 40'000, Pose2{2.0, 0.0, 0.0}}});
  CheckKnown(buffer.Find(kSecond + 10'000), {1.25, 1.5, 0.3});
  CheckKnown(buffer.Find(kSecond + 20'000), {1.5, 1.0, 0.2});
  CheckKnown(buffer.Find(kSecond + 39'999), {1.999975, 0.00005, 0.00001});
  CheckNotKnown(buffer.FindExact(kSecond + 20'000), State::kAwaited);
}

TEST_CASE("what lies between two samples is rounded to whole micrometres and microradians") {
  const OdometryBuffer buffer = BufferOf({{0, Pose2{0.0, 0.0, 0.0}}, {3, Pose2{1e-6, 1.0, -1.0}}});
  CheckKnown(buffer.Find(1), {0.0, 0.333333, -0.333333});
  CheckKnown(buffer.Find(2), {1e-6, 0.666667, -0.666667});
}

TEST_CASE("between two headings the robot turned the shorter way, across the seam too") {
  const Pose2 left{0.0, 0.0, 3.1};
  const Pose2 right{0.0, 0.0, -3.1};
  const double half_way_rad = 3.141592;  // the largest heading that rounding gives
  CHECK(BufferOf({{0, left}, {100, right}}).Find(25).T_odom_robot->yaw_rad == 3.120796);
  CHECK(BufferOf({{0, left}, {100, right}}).Find(75).T_odom_robot->yaw_rad == -3.120796);
  CHECK(BufferOf({{0, right}, {100, left}}).Find(25).T_odom_robot->yaw_rad == -3.120796);
  CHECK(std::abs(BufferOf({{0, left}, {100, right}}).Find(50).T_odom_robot->yaw_rad) == half_way_rad);
}

TEST_CASE("of many samples the nearest before and after the scan count") {
  const OdometryBuffer buffer = BufferOf({{0, Pose2{100.0, 0.0, 0.0}},
                                          {10, Pose2{1.0, 0.0, 0.0}},
                                          {30, Pose2{3.0, 0.0, 0.0}},
                                          {90, Pose2{100.0, 0.0, 0.0}}});
  CheckKnown(buffer.Find(20), {2.0, 0.0, 0.0});
}

TEST_CASE("a scan after the last sample is awaited, also where samples of before a step back are later than it") {
  CheckNotKnown(BufferOf({{kSecond, kPose}}).Find(kSecond + 1), State::kAwaited);
  const OdometryBuffer stepped_back = BufferOf({{9 * kSecond, kPose}, {8 * kSecond, kPose}});
  CheckNotKnown(stepped_back.Find(8 * kSecond + 50'000), State::kAwaited);
}

TEST_CASE("a scan before the first sample has no odometry") {
  CheckNotKnown(BufferOf({{kSecond, kPose}}).Find(kSecond - 1), State::kNone);
}

TEST_CASE("samples up to 0.1 s from the scan count, others leave it without odometry") {
  const Pose2 far{1.0, 4.0, 3.0};
  for (const std::int64_t gap_us : {100'000, 100'001}) {
    CAPTURE(gap_us);
    const OdometryBuffer before = BufferOf({{kSecond - gap_us, kPose}, {kSecond + gap_us, far}});
    CHECK(before.Find(kSecond).state == (gap_us == 100'000 ? State::kKnown : State::kNone));
    const OdometryBuffer near_after = BufferOf({{kSecond - gap_us, kPose}, {kSecond + 1, far}});
    CHECK(near_after.Find(kSecond).state == (gap_us == 100'000 ? State::kKnown : State::kNone));
    const OdometryBuffer near_before = BufferOf({{kSecond - 1, kPose}, {kSecond + gap_us, far}});
    CHECK(near_before.Find(kSecond).state == (gap_us == 100'000 ? State::kKnown : State::kNone));
  }
}

TEST_CASE("a sample that says that its scan has none is believed for that scan, and passed over for others") {
  const OdometryBuffer buffer = BufferOf({{0, Pose2{0.0, 0.0, 0.0}}, {10, std::nullopt}, {40, Pose2{4.0, 0.0, 0.0}}});
  CheckNotKnown(buffer.Find(10), State::kNone);
  CheckNotKnown(buffer.FindExact(10), State::kNone);
  CheckKnown(buffer.Find(20), {2.0, 0.0, 0.0});
  CheckNotKnown(BufferOf({{0, kPose}, {20, std::nullopt}}).Find(10), State::kNone);  // the odometry went past the scan
}

TEST_CASE("a sample that comes again takes the place of the first") {
  OdometryBuffer buffer = BufferOf({{0, kPose}, {10, kPose}, {0, Pose2{7.0, 0.0, 0.0}}});
  CheckKnown(buffer.Find(0), {7.0, 0.0, 0.0});
  buffer.Add({0, std::nullopt});
  CheckNotKnown(buffer.Find(0), State::kNone);
  buffer.Add({0, kPose});
  CheckKnown(buffer.Find(0), kPose);
}

TEST_CASE("where utimes step back, as intel's do, the sample of a scan's own utime wins over all around it") {
  OdometryBuffer buffer;
  for (std::int64_t i = 0; i < 20; ++i) buffer.Add({100'000 * i, Pose2{0.1 * static_cast<double>(i), 0.0, 0.0}});
  buffer.Add({1'050'000, Pose2{50.0, 0.0, 0.0}});  // 0.85 s back
  CheckKnown(buffer.Find(1'050'000), {50.0, 0.0, 0.0});
  CheckKnown(buffer.Find(1'000'000), {1.0, 0.0, 0.0});
}

TEST_CASE("where utimes step back, samples of before the step are not mixed with those of after it") {
  OdometryBuffer buffer;
  for (std::int64_t i = 0; i <= 20; ++i) buffer.Add({50'000 * i, Pose2{1.0, 0.0, 0.0}});  // 0 to 1 s
  CheckKnown(buffer.Find(310'000), {1.0, 0.0, 0.0});
  CheckNotKnown(buffer.Find(1'000'001), State::kAwaited);
  buffer.Add({300'000, Pose2{2.0, 0.0, 0.0}});  // 0.7 s back
  buffer.Add({340'000, Pose2{3.0, 0.0, 0.0}});
  CheckKnown(buffer.Find(310'000), {2.25, 0.0, 0.0});    // of the same time before the step: no more
  CheckNotKnown(buffer.Find(345'000), State::kAwaited);  // the next sample tells
  CheckNotKnown(buffer.Find(290'000), State::kNone);     // just before the first after the step: which one?
  CheckKnown(buffer.Find(810'000), {1.0, 0.0, 0.0});     // far from what came after the step
  CheckNotKnown(buffer.Find(1'000'001), State::kNone);   // the odometry stepped back before it passed the scan
}

TEST_CASE("the oldest sample by arrival gives way, also where its utime is the latest") {
  OdometryBuffer buffer(3);
  for (const std::int64_t utime : {500, 10, 20, 30}) buffer.Add({utime, kPose});
  CheckNotKnown(buffer.Find(500), State::kAwaited);
  for (const std::int64_t utime : {10, 20, 30}) CheckKnown(buffer.Find(utime), kPose);
  buffer.Add({20, kPose});  // one that comes again takes no room
  for (const std::int64_t utime : {10, 20, 30}) CheckKnown(buffer.Find(utime), kPose);
  OdometryBuffer one(1);
  one.Add({1, kPose});
  one.Add({2, kPose});
  CheckKnown(one.Find(2), kPose);
  CheckNotKnown(one.Find(1), State::kNone);
}

TEST_CASE("utimes at the ends of what a number can hold do no harm") {
  constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kLargest = std::numeric_limits<std::int64_t>::max();
  const OdometryBuffer buffer = BufferOf({{kLeast, kPose}, {kLargest, kPose}});
  CheckNotKnown(buffer.Find(0), State::kNone);
  CheckKnown(buffer.Find(kLargest), kPose);
  CheckKnown(buffer.Find(kLeast), kPose);
}

}  // namespace crsm
