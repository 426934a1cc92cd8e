#include "common/graph/g2o.hpp"

#include "common/math/format_number.hpp"

namespace crsm {
namespace {

std::string FormatPose(const Pose2& pose) {
  return " " + FormatNumber(pose.x_m) + " " + FormatNumber(pose.y_m) + " " + FormatNumber(pose.yaw_rad);
}

}  // namespace

std::string FormatG2o(const PoseGraph& graph) {
  std::string text;
  for (std::size_t i = 0; i < graph.poses().size(); ++i) {
    text += "VERTEX_SE2 " + std::to_string(i) + FormatPose(graph.poses()[i]) + "\n";
  }
  if (!graph.poses().empty()) text += "FIX 0\n";
  for (const GraphEdge& edge : graph.edges()) {
    text += "EDGE_SE2 " + std::to_string(edge.from) + " " + std::to_string(edge.to) + FormatPose(edge.T_from_to);
    const std::array<double, 9>& w = edge.sqrt_information;
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t column = row; column < 3; ++column) {
        const double information = w[row] * w[column] + w[3 + row] * w[3 + column] + w[6 + row] * w[6 + column];
        text += " " + FormatNumber(information);
      }
    }
    text += "\n";
  }
  return text;
}

}  // namespace crsm
