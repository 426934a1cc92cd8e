#pragma once

#include <string>

#include "common/graph/pose_graph.hpp"

namespace crsm {

/// A pose graph as g2o writes it (VERTEX_SE2, EDGE_SE2; Kuemmerle et al., "g2o: A general framework for graph
/// optimization", ICRA 2011): x [m], y [m], yaw [rad], and the upper triangle of the information matrix.
/// Each number has the digits that it takes to read back as it was: rounded ones may be a matrix without a factor.
std::string FormatG2o(const PoseGraph& graph);

}  // namespace crsm
