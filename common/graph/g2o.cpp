#include "common/graph/g2o.hpp"

#include <fmt/format.h>

#include <iterator>

namespace crsm {

std::string FormatG2o(const PoseGraph& graph) {
  std::string text;
  const auto out = std::back_inserter(text);
  for (std::size_t i = 0; i < graph.poses().size(); ++i) {
    const Pose2& pose = graph.poses()[i];
    fmt::format_to(out, "VERTEX_SE2 {} {:.6f} {:.6f} {:.6f}\n", i, pose.x_m, pose.y_m, pose.yaw_rad);
  }
  if (!graph.poses().empty()) text += "FIX 0\n";
  for (const GraphEdge& edge : graph.edges()) {
    const Pose2& motion = edge.T_from_to;
    const Eigen::Matrix3d information = edge.sqrt_information.transpose() * edge.sqrt_information;
    fmt::format_to(out, "EDGE_SE2 {} {} {:.6f} {:.6f} {:.6f}", edge.from, edge.to, motion.x_m, motion.y_m,
                   motion.yaw_rad);
    for (int row = 0; row < 3; ++row) {
      for (int column = row; column < 3; ++column) fmt::format_to(out, " {:.3f}", information(row, column));
    }
    text += "\n";
  }
  return text;
}

}  // namespace crsm
