#include "common/graph/pose_graph.hpp"

#include <cmath>
#include <limits>

#include "catch.hpp"
#include "common/math/random.hpp"

namespace crsm {
namespace {

constexpr MotionSigma kOdometry{0.01, 0.01, 0.0015};
constexpr MotionSigma kLoop{0.03, 0.03, 0.005};

/// Once round a square of `side` steps of 0.4 m, and back at the start.
std::vector<Pose2> DriveRound(int side) {
  std::vector<Pose2> poses{{1.0, -2.0, 0.3}};
  for (int i = 1; i <= 4 * side; ++i) {
    poses.push_back(poses.back() * Pose2{0.4, 0.0, i % side == 0 ? kPi / 2 : 0.0});
  }
  return poses;
}

/// The graph of a drive whose every motion is off by `error`, and by noise.
PoseGraph Chain(const std::vector<Pose2>& truth, const Pose2& error, std::uint64_t seed) {
  Random random(seed);
  PoseGraph graph;
  graph.AddPose(truth[0]);
  for (std::size_t i = 1; i < truth.size(); ++i) {
    const Pose2 noise{kOdometry.x_m * random.Gaussian(), kOdometry.y_m * random.Gaussian(),
                      kOdometry.yaw_rad * random.Gaussian()};
    const Pose2 motion = Inverse(truth[i - 1]) * truth[i] * noise * error;
    const int last = graph.AddPose(graph.poses().back() * motion);
    graph.AddEdge(GraphEdge::Make(last - 1, last, motion, kOdometry));
  }
  return graph;
}

double LargestDistance_m(const std::vector<Pose2>& one, const std::vector<Pose2>& other) {
  double largest_m = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    largest_m = std::max(largest_m, std::hypot(one[i].x_m - other[i].x_m, one[i].y_m - other[i].y_m));
  }
  return largest_m;
}

GraphEdge Loop(const std::vector<Pose2>& truth, int from, int to, const Pose2& error = {}) {
  const auto At = [&](int i) { return truth[static_cast<std::size_t>(i)]; };
  GraphEdge edge = GraphEdge::Make(from, to, Inverse(At(from)) * At(to) * error, kLoop);
  edge.may_be_wrong = true;
  return edge;
}

/// The cost as its definition has it.
double CostLiterally(const PoseGraph& graph, const std::vector<Pose2>& poses) {
  PoseGraph moved;
  for (const Pose2& pose : poses) moved.AddPose(pose);
  double cost = 0.0;
  for (const GraphEdge& edge : graph.edges()) {
    const double squared = moved.SquaredError(edge);
    cost += edge.may_be_wrong ? 9.0 * squared / (9.0 + squared) : squared;
  }
  return cost;
}

}  // namespace

TEST_CASE("a loop brings a drive that bends back to its start, and bends all of it a little") {
  const std::vector<Pose2> truth = DriveRound(40);
  PoseGraph graph = Chain(truth, {0.0, 0.0, 0.0004}, 4);
  const double before_m = LargestDistance_m(graph.poses(), truth);
  REQUIRE(before_m > 0.9);
  graph.AddEdge(Loop(truth, 0, 160));
  graph.AddEdge(Loop(truth, 3, 157));
  const GraphOptimisation optimisation = graph.Optimise();
  CHECK(optimisation.cost_after < optimisation.cost_before);
  CHECK(optimisation.iterations <= 8);  // steps that remember the equations of the last one take longer
  CHECK(graph.poses()[0] == truth[0]);
  CHECK(LargestDistance_m({graph.poses().back()}, {truth.back()}) < 0.05);
  CHECK(LargestDistance_m(graph.poses(), truth) < 0.5 * before_m);
}

TEST_CASE("where an optimisation ends no pose can be moved for less cost") {
  const std::vector<Pose2> truth = DriveRound(5);
  PoseGraph graph = Chain(truth, {0.01, -0.002, 0.02}, 2);
  graph.AddEdge(Loop(truth, 0, 20));
  graph.AddEdge(Loop(truth, 2, 14, {0.05, 0.0, 0.0}));
  const GraphOptimisation optimisation = graph.Optimise();
  const double cost = CostLiterally(graph, graph.poses());
  CHECK(optimisation.cost_after == Approx(cost));
  for (std::size_t i = 1; i < graph.poses().size(); ++i) {
    for (const Pose2& way :
         {Pose2{1e-3, 0, 0}, {-1e-3, 0, 0}, {0, 1e-3, 0}, {0, -1e-3, 0}, {0, 0, 1e-3}, {0, 0, -1e-3}}) {
      std::vector<Pose2> moved = graph.poses();
      moved[i] = {moved[i].x_m + way.x_m, moved[i].y_m + way.y_m, moved[i].yaw_rad + way.yaw_rad};
      REQUIRE(CostLiterally(graph, moved) > cost);
    }
  }
}

TEST_CASE("a wrong loop is outvoted by right ones, and shows by its error") {
  const std::vector<Pose2> truth = DriveRound(40);
  PoseGraph graph = Chain(truth, {0.0, 0.0, 0.0005}, 3);
  const GraphEdge wrong = Loop(truth, 20, 100, {4.6, 0.0, 0.0});  // as far as from one door to the next
  for (const GraphEdge& edge : {Loop(truth, 0, 160), Loop(truth, 5, 155), wrong}) graph.AddEdge(edge);
  graph.Optimise();
  CHECK(LargestDistance_m(graph.poses(), truth) < 0.4);
  CHECK(graph.SquaredError(graph.edges().back()) > 1000.0);
  CHECK(graph.SquaredError(graph.edges()[160]) < 9.0);
}

TEST_CASE("a motion that is open along an axis gives way along it") {
  PoseGraph graph;
  for (int i = 0; i < 3; ++i) graph.AddPose({1.0 * i, 0.0, 0.0});
  const double corridor_yaw_rad = 0.7;
  const std::array corridor{std::cos(corridor_yaw_rad), std::sin(corridor_yaw_rad)};
  const MotionSigma open{0.5, 0.01, 0.001};
  graph.AddEdge(GraphEdge::Make(0, 1, {1.0, 0.0, 0.0}, open, corridor));
  graph.AddEdge(GraphEdge::Make(1, 2, {1.0, 0.0, 0.0}, kOdometry));
  graph.AddEdge(GraphEdge::Make(0, 2, {2.0 + 0.2 * corridor[0], 0.2 * corridor[1], 0.0}, kLoop));
  graph.Optimise();
  CHECK(graph.poses()[1].x_m == Approx(1.0 + 0.2 * corridor[0]).margin(0.005));
  CHECK(graph.poses()[1].y_m == Approx(0.2 * corridor[1]).margin(0.005));
}

TEST_CASE("headings are compared across the seam of the circle") {
  PoseGraph graph;
  graph.AddPose({0.0, 0.0, 3.1});
  graph.AddPose({0.0, 0.0, -3.1});
  graph.AddEdge(GraphEdge::Make(0, 1, {0.0, 0.0, 0.1}, kOdometry));
  graph.Optimise();
  CHECK(graph.poses()[1].yaw_rad == Approx(3.2 - 2 * kPi));
}

TEST_CASE("the same graph is optimised to the same bits; a pose that nothing holds stays") {
  const std::vector<Pose2> truth = DriveRound(10);
  PoseGraph graph = Chain(truth, {0.0, 0.0, 0.002}, 4);
  graph.AddEdge(Loop(truth, 0, 40));
  PoseGraph other = graph;
  graph.Optimise();
  other.Optimise();
  CHECK(graph.poses() == other.poses());

  const std::vector<Pose2> before = graph.poses();
  graph.AddPose({7.0, 8.0, 0.5});
  graph.Optimise();
  CHECK(graph.poses().back() == Pose2{7.0, 8.0, 0.5});
  CHECK(LargestDistance_m(before, graph.poses()) < 1e-3);
}

TEST_CASE("what is no pose and no edge is refused") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  PoseGraph graph;
  CHECK_THROWS_AS(graph.AddPose({nan, 0.0, 0.0}), std::invalid_argument);
  graph.AddPose({});
  for (const int to : {0, 1}) CHECK_THROWS_AS(graph.AddEdge(GraphEdge::Make(0, to, {}, kLoop)), std::invalid_argument);
  graph.AddPose({});
  for (const GraphEdge& edge : {GraphEdge::Make(-1, 1, {}, kLoop), GraphEdge::Make(0, 1, {0.0, nan, 0.0}, kLoop),
                                GraphEdge::Make(0, 1, {}, {0.0, 0.0, 0.0})}) {
    CHECK_THROWS_AS(graph.AddEdge(edge), std::invalid_argument);
  }
  CHECK(graph.Optimise().iterations == 0);
}

TEST_CASE("poses are optimised by the constants that are given") {
  const std::vector<Pose2> truth = DriveRound(40);
  const auto Optimise = [&](const OptimisationConstants& constants, GraphOptimisation* result = nullptr) {
    const PoseGraph chain = Chain(truth, {0.0, 0.0, 0.0005}, 3);
    PoseGraph graph(constants);
    for (const Pose2& pose : chain.poses()) graph.AddPose(pose);
    for (const GraphEdge& edge : chain.edges()) graph.AddEdge(edge);
    for (const GraphEdge& edge : {Loop(truth, 0, 160), Loop(truth, 5, 155), Loop(truth, 20, 100, {4.6, 0.0, 0.0})}) {
      graph.AddEdge(edge);
    }
    const GraphOptimisation optimisation = graph.Optimise();
    if (result) *result = optimisation;
    return LargestDistance_m(graph.poses(), truth);
  };
  const double usual_m = Optimise({});
  GraphOptimisation few;
  CHECK(Optimise({.doubt = 1e9}) > 2.0 * usual_m);        // the wrong loop counts as much as the right ones
  CHECK(Optimise({.first_doubt = 0.0}) > 1.5 * usual_m);  // the right ones count too little from the beginning
  CHECK(Optimise({.steps_per_doubt = 0, .steps_max = 0}, &few) > 1.5 * usual_m);
  CHECK(few.iterations == 0);
  Optimise({.steps_per_doubt = 0, .steps_max = 3}, &few);
  CHECK(few.iterations <= 3);
  Optimise({.small_step = 1e9}, &few);  // each descent ends after its first step
  GraphOptimisation many;
  Optimise({.release = 1.5}, &many);
  CHECK(few.iterations < many.iterations);
  CHECK(Optimise({.damping_min = 1e12, .damping_max = 1e13}) > 1.5 * usual_m);  // steps of nothing
}

TEST_CASE("samples of a chain spread as its motions do") {
  PoseGraph graph;
  graph.AddPose({});
  constexpr int kSteps = 50;
  for (int i = 1; i <= kSteps; ++i) {
    graph.AddPose({0.4 * i, 0.0, 0.0});
    graph.AddEdge(GraphEdge::Make(i - 1, i, {0.4, 0.0, 0.0}, {0.02, 0.01, 1e-6}));
  }
  constexpr int kNum = 400;
  double x_m2 = 0.0, y_m2 = 0.0;
  const bool solved = graph.Sample(kNum, 1, [&](const std::vector<Pose2>& poses) {
    CHECK(poses[0] == Pose2{});
    x_m2 += std::pow(poses[kSteps].x_m - 0.4 * kSteps, 2) / kNum;
    y_m2 += std::pow(poses[kSteps].y_m, 2) / kNum;
  });
  CHECK(std::sqrt(x_m2) == Approx(0.02 * std::sqrt(kSteps)).epsilon(0.1));
  CHECK(std::sqrt(y_m2) == Approx(0.01 * std::sqrt(kSteps)).epsilon(0.1));
  CHECK(solved);
}

TEST_CASE("what two edges tell alike is open by half of the variance of each, and a loop that is wrong tells nothing") {
  PoseGraph graph;
  graph.AddPose({});
  graph.AddPose({0.4, 0.0, 0.0});
  for (int i = 0; i < 2; ++i) graph.AddEdge(GraphEdge::Make(0, 1, {0.4, 0.0, 0.0}, kOdometry));
  GraphEdge wrong = GraphEdge::Make(0, 1, {9.0, 0.0, 0.0}, kOdometry);
  wrong.may_be_wrong = true;
  graph.AddEdge(wrong);
  double x_m2 = 0.0;
  CHECK(graph.Sample(400, 1, [&](const auto& poses) { x_m2 += std::pow(poses[1].x_m - 0.4, 2) / 400.0; }));
  CHECK(x_m2 == Approx(0.5 * kOdometry.x_m * kOdometry.x_m).epsilon(0.2));
  CHECK_FALSE(PoseGraph().Sample(10, 1, [](const std::vector<Pose2>&) {}));
}

}  // namespace crsm
