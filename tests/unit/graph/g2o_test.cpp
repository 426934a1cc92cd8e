#include "common/graph/g2o.hpp"

#include <Eigen/Dense>
#include <sstream>

#include "catch.hpp"

namespace crsm {

TEST_CASE("a pose graph is written as g2o reads it") {
  PoseGraph graph;
  CHECK(FormatG2o(graph).empty());
  graph.AddPose({});
  CHECK(FormatG2o(graph) == "VERTEX_SE2 0 0 0 0\nFIX 0\n");
  graph.AddPose({1.0, -2.5, 0.25});
  graph.AddEdge(GraphEdge::Make(0, 1, {1.0, -2.5, 0.25}, {0.5, 0.1, 0.02}));
  // The information of a standard deviation s is 1 / s^2: 4, 100 and 2500.
  CHECK(FormatG2o(graph) ==
        "VERTEX_SE2 0 0 0 0\n"
        "VERTEX_SE2 1 1 -2.5 0.25\n"
        "FIX 0\n"
        "EDGE_SE2 0 1 1 -2.5 0.25 4 0 0 100 0 2500\n");
}

TEST_CASE("each number of g2o's text reads back as it was, and others can factor what little a corridor tells") {
  PoseGraph graph;
  graph.AddPose({1.0 / 3.0, -1e-9, 3.1});
  graph.AddPose({12345.678901234567, 0.1, -2.0});
  // Known to 1 cm across a corridor, and along it to 100 m: the frame of the pose that the edge leads from is turned.
  const GraphEdge edge = GraphEdge::Make(1, 0, {0.1 + 0.2, 2.0 / 7.0, 1e-12}, {100.0, 0.01, 0.001}, {0.6, 0.8});
  graph.AddEdge(edge);
  std::istringstream text(FormatG2o(graph));
  std::string word;
  int number = 0;
  for (const Pose2& pose : graph.poses()) {
    Pose2 read;
    text >> word >> number >> read.x_m >> read.y_m >> read.yaw_rad;
    CHECK(read == pose);
  }
  text >> word >> number >> word >> number >> number;
  Pose2 read;
  text >> read.x_m >> read.y_m >> read.yaw_rad;
  CHECK(read == edge.T_from_to);
  Eigen::Matrix3d information;
  for (int row = 0; row < 3; ++row) {
    for (int column = row; column < 3; ++column) {
      text >> information(row, column);
      information(column, row) = information(row, column);
    }
  }
  CHECK(text.good());
  // R diag(1e-4, 1e4) R^T with R = [0.6 -0.8; 0.8 0.6], and 1e6 of the heading.
  CHECK(information(0, 0) == Approx(6400.000036).epsilon(1e-12));
  CHECK(information(0, 1) == Approx(-4799.999952).epsilon(1e-12));
  CHECK(information(1, 1) == Approx(3600.000064).epsilon(1e-12));
  CHECK(information(2, 2) == Approx(1e6).epsilon(1e-12));
  const Eigen::LLT<Eigen::Matrix3d> factor(information);
  CHECK(factor.info() == Eigen::Success);
  CHECK(information.determinant() == Approx(1e6).epsilon(1e-3));  // the product of all three, less what rounding takes
}

}  // namespace crsm
