#include "common/graph/g2o.hpp"

#include "catch.hpp"

namespace crsm {

TEST_CASE("a pose graph is written as g2o reads it") {
  PoseGraph graph;
  CHECK(FormatG2o(graph).empty());
  graph.AddPose({});
  CHECK(FormatG2o(graph) == "VERTEX_SE2 0 0.000000 0.000000 0.000000\nFIX 0\n");
  graph.AddPose({1.0, -2.5, 0.25});
  graph.AddEdge(GraphEdge::Make(0, 1, {1.0, -2.5, 0.25}, {0.5, 0.1, 0.02}));
  // The information of a standard deviation s is 1 / s^2: 4, 100 and 2500.
  CHECK(FormatG2o(graph) ==
        "VERTEX_SE2 0 0.000000 0.000000 0.000000\n"
        "VERTEX_SE2 1 1.000000 -2.500000 0.250000\n"
        "FIX 0\n"
        "EDGE_SE2 0 1 1.000000 -2.500000 0.250000 4.000 0.000 0.000 100.000 0.000 2500.000\n");
  // What a corridor leaves open is in the frame of the pose that an edge leads from: R diag(1, 4) R^T with
  // R = [0.6 -0.8; 0.8 0.6].
  graph.AddEdge(GraphEdge::Make(1, 0, {}, {1.0, 0.5, 1.0}, {0.6, 0.8}));
  CHECK(FormatG2o(graph).ends_with("EDGE_SE2 1 0 0.000000 0.000000 0.000000 2.920 -1.440 0.000 2.080 0.000 1.000\n"));
}

}  // namespace crsm
