#include "common/scan/odometry_buffer.hpp"

#include <limits>

#include "catch.hpp"

namespace crsm {
namespace {

using State = ScanOdometry::State;

constexpr std::int64_t kSecond = 1'000'000;
const Pose2 kPose{1.0, 2.0, 3.0};

OdometryBuffer BufferOf(const std::vector<Odometry>& samples) {
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

Pose2 Along(double x_m) { return {x_m, 0.0, 0.0}; }

}  // namespace

TEST_CASE("a scan's odometry is that of its own utime, or what lies between the samples around it, to a millionth") {
  struct Case {
    std::vector<Odometry> samples;
    std::int64_t utime;
    Pose2 expected;
  };
  const std::vector<Odometry> way{{kSecond, Pose2{1.0, 2.0, 0.4}}, {kSecond + 40'000, Pose2{2.0, 0.0, 0.0}}};
  const std::vector<Odometry> steps{{0, Pose2{}}, {3, Pose2{1e-6, 1.0, -1.0}}};
  for (const Case& tested : {Case{{{kSecond, kPose}}, kSecond, kPose},
                             {way, kSecond + 10'000, {1.25, 1.5, 0.3}},
                             {way, kSecond + 20'000, {1.5, 1.0, 0.2}},
                             {way, kSecond + 39'999, {1.999975, 0.00005, 0.00001}},
                             {steps, 1, {0.0, 0.333333, -0.333333}},
                             {steps, 2, {1e-6, 0.666667, -0.666667}},
                             {{{0, Along(9.0)}, {10, Along(1.0)}, {30, Along(3.0)}, {90, Along(9.0)}}, 20, Along(2.0)},
                             {{{0, Pose2{}}, {10, std::nullopt}, {40, Along(4.0)}}, 20, Along(2.0)}}) {
    CAPTURE(tested.utime);
    CheckKnown(BufferOf(tested.samples).Find(tested.utime), tested.expected);
  }
  CheckKnown(BufferOf(way).FindExact(kSecond), way[0].T_odom_robot.value());
}

TEST_CASE("a scan after the last sample is awaited; one before the first, or that says that it has none, has none") {
  const std::vector<Odometry> none_at_10{{0, Pose2{}}, {10, std::nullopt}, {40, Along(4.0)}};
  CheckNotKnown(BufferOf({}).Find(5), State::kAwaited);
  CheckNotKnown(BufferOf({}).FindExact(5), State::kAwaited);
  CheckNotKnown(BufferOf({{0, kPose}, {40, kPose}}).FindExact(20), State::kAwaited);
  CheckNotKnown(BufferOf({{kSecond, kPose}}).Find(kSecond + 1), State::kAwaited);
  // Samples of before a step back are later than the scan.
  CheckNotKnown(BufferOf({{9 * kSecond, kPose}, {8 * kSecond, kPose}}).Find(8 * kSecond + 50'000), State::kAwaited);
  CheckNotKnown(BufferOf({{kSecond, kPose}}).Find(kSecond - 1), State::kNone);
  CheckNotKnown(BufferOf(none_at_10).Find(10), State::kNone);
  CheckNotKnown(BufferOf(none_at_10).FindExact(10), State::kNone);
  CheckNotKnown(BufferOf({{0, kPose}, {20, std::nullopt}}).Find(10), State::kNone);  // the odometry went past the scan
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

TEST_CASE("samples up to 0.1 s from the scan count, others leave it without odometry") {
  for (const auto& [gap_us, expected] : {std::pair(100'000, State::kKnown), {100'001, State::kNone}}) {
    CAPTURE(gap_us);
    for (const auto& [before_us, after_us] : {std::pair(gap_us, gap_us), {gap_us, 1}, {1, gap_us}}) {
      const OdometryBuffer buffer = BufferOf({{kSecond - before_us, kPose}, {kSecond + after_us, kPose}});
      CHECK(buffer.Find(kSecond).state == expected);
    }
  }
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
