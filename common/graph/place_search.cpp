#include "common/graph/place_search.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <queue>
#include <tuple>

namespace crsm {
namespace {

/// Poses on a lattice: 2^level of them along each axis, from here on.
struct Node {
  int count;
  int level;
  int x;
  int y;
  int yaw;

  /// The order in which they are looked at: what promises most first.
  friend bool operator<(const Node& a, const Node& b) {
    return std::tie(a.count, b.level, a.x, a.y, a.yaw) < std::tie(b.count, a.level, b.x, b.y, b.yaw);
  }
};

/// The poses that are tried: cells apart, and turned by so little that no point moves by more than a cell.
class Lattice {
 public:
  Lattice(const HitPyramid& pyramid, const Eigen::Matrix2Xd& points_m, const PlaceWindow& window, double farthest_m)
      : pyramid_(pyramid),
        centre_(window.centre),
        step_rad_(pyramid.cell_m() / farthest_m),
        reach_(static_cast<int>(std::ceil(window.reach_m / pyramid.cell_m()))),
        reach_yaw_(static_cast<int>(std::ceil(window.reach_rad / step_rad_))),
        x_cells_((points_m.row(0).array() / pyramid.cell_m()).cast<float>()),
        y_cells_((points_m.row(1).array() / pyramid.cell_m()).cast<float>()) {}

  Pose2 PoseAt(double x, double y, double yaw) const {
    return {centre_.x_m + x * pyramid_.cell_m(), centre_.y_m + y * pyramid_.cell_m(),
            WrapAngle(centre_.yaw_rad + yaw * step_rad_)};
  }

  bool Contains(const Node& node) const { return node.x <= reach_ && node.y <= reach_ && node.yaw <= reach_yaw_; }

  /// How many points at most lie on hits at one of the node's poses; all that matters below `least` is that it is.
  int Bound(const Node& node, int least) const {
    const double middle = 0.5 * ((1 << node.level) - 1);
    return pyramid_.Count(node.level, x_cells_, y_cells_, PoseAt(node.x + middle, node.y + middle, node.yaw + middle),
                          least);
  }

  /// Whether all poses of a node are those of one place.
  bool IsAt(const Node& node, const Node& place) const {
    constexpr double kOther_m = 0.6;
    constexpr double kOther_rad = 0.2;
    const int size = 1 << node.level;
    const auto Far = [size](int at, int from) { return std::max(from - at, at + size - 1 - from); };
    const double far_m = pyramid_.cell_m() * std::max(Far(node.x, place.x), Far(node.y, place.y));
    return far_m < kOther_m && step_rad_ * Far(node.yaw, place.yaw) < kOther_rad;
  }

  /// The nodes of the highest level.
  template <class Visit>
  void VisitTop(Visit&& visit) const {
    constexpr int kTop = HitPyramid::kLevels - 1;
    for (int yaw = -reach_yaw_; yaw <= reach_yaw_; yaw += 1 << kTop) {
      for (int y = -reach_; y <= reach_; y += 1 << kTop) {
        for (int x = -reach_; x <= reach_; x += 1 << kTop) visit(Node{0, kTop, x, y, yaw});
      }
    }
  }

 private:
  const HitPyramid& pyramid_;
  Pose2 centre_;
  double step_rad_;
  int reach_;
  int reach_yaw_;
  Eigen::ArrayXf x_cells_;
  Eigen::ArrayXf y_cells_;
};

}  // namespace

HitPyramid::HitPyramid(const Eigen::Matrix2Xd& hits_m, double cell_m) : cell_m_(cell_m) {
  constexpr int kMargin = 2;       // cells
  if (hits_m.cols() == 0) return;  // all that was seen is far away
  const Eigen::Vector2d low = hits_m.rowwise().minCoeff();
  const Eigen::Vector2d high = hits_m.rowwise().maxCoeff();
  origin_m_ = low.array() - kMargin * cell_m;
  Grid base;
  base.width = static_cast<int>((high.x() - low.x()) / cell_m) + 2 * kMargin + 1;
  base.height = static_cast<int>((high.y() - low.y()) / cell_m) + 2 * kMargin + 1;
  base.cells.assign(static_cast<std::size_t>(base.width) * static_cast<std::size_t>(base.height), 0);
  for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
    const auto x = static_cast<std::size_t>((hits_m(0, i) - origin_m_.x()) / cell_m);
    const auto y = static_cast<std::size_t>((hits_m(1, i) - origin_m_.y()) / cell_m);
    base.cells[y * static_cast<std::size_t>(base.width) + x] = 1;
  }
  levels_[0] = Widen(base, 1);
  Grid coarse = levels_[0];
  for (std::size_t level = 1; level < kLevels; ++level) {
    levels_[level] = Widen(coarse, 2);
    coarse = Halve(coarse);
  }
}

/// Each cell is set if one within `reach` of it is. The grid grows by as much.
HitPyramid::Grid HitPyramid::Widen(const Grid& grid, int reach) {
  const auto w = static_cast<std::size_t>(grid.width);
  const auto h = static_cast<std::size_t>(grid.height);
  const auto r = static_cast<std::size_t>(2 * reach);
  Grid wide{grid.width + 2 * reach, grid.height + 2 * reach, {}};
  const std::size_t ww = w + r;
  std::vector<std::uint8_t> rows(ww * h, 0);
  for (std::size_t y = 0; y < h; ++y) {
    for (std::size_t shift = 0; shift <= r; ++shift) {
      std::uint8_t* to = &rows[y * ww + shift];
      const std::uint8_t* from = &grid.cells[y * w];
      for (std::size_t x = 0; x < w; ++x) to[x] |= from[x];
    }
  }
  wide.cells.assign(ww * (h + r), 0);
  for (std::size_t y = 0; y < h; ++y) {
    for (std::size_t shift = 0; shift <= r; ++shift) {
      std::uint8_t* to = &wide.cells[(y + shift) * ww];
      const std::uint8_t* from = &rows[y * ww];
      for (std::size_t x = 0; x < ww; ++x) to[x] |= from[x];
    }
  }
  return wide;
}

HitPyramid::Grid HitPyramid::Halve(const Grid& grid) {
  Grid half{(grid.width + 1) / 2, (grid.height + 1) / 2, {}};
  const auto width = static_cast<std::size_t>(grid.width);
  const auto height = static_cast<std::size_t>(grid.height);
  const auto half_width = static_cast<std::size_t>(half.width);
  const auto half_height = static_cast<std::size_t>(half.height);
  half.cells.resize(half_width * half_height);
  std::vector<std::uint8_t> both(2 * half_width, 0);  // two rows as one
  for (std::size_t y = 0; y < half_height; ++y) {
    const std::uint8_t* low = &grid.cells[2 * y * width];
    const std::uint8_t* high = &grid.cells[std::min(2 * y + 1, height - 1) * width];
    for (std::size_t x = 0; x < width; ++x) both[x] = low[x] | high[x];
    std::uint8_t* to = &half.cells[y * half_width];
    for (std::size_t x = 0; x < half_width; ++x) to[x] = both[2 * x] | both[2 * x + 1];
  }
  return half;
}

int HitPyramid::Count(int level, const Eigen::ArrayXf& x_cells, const Eigen::ArrayXf& y_cells, const Pose2& pose,
                      int least) const {
  const Grid& grid = levels_[static_cast<std::size_t>(level)];
  const int shift = std::max(level - 1, 0);
  const int widened = level == 0 ? 1 : 2;
  const int offset = level == 0 ? 0 : 1;  // level 0 was widened by a cell before it was halved
  const auto [sin, cos] = ComputeSinCos(pose.yaw_rad);
  const auto s = static_cast<float>(sin);
  const auto c = static_cast<float>(cos);
  constexpr int kBias = 1 << 16;  // positive numbers are rounded down
  const auto x0 = static_cast<float>((pose.x_m - origin_m_.x()) / cell_m_ + offset) + kBias;
  const auto y0 = static_cast<float>((pose.y_m - origin_m_.y()) / cell_m_ + offset) + kBias;
  const int bias = (kBias >> shift) - widened;
  constexpr Eigen::Index kAtOnce = 32;
  const Eigen::Index num = x_cells.size();
  int count = 0;
  for (Eigen::Index begin = 0; begin < num; begin += kAtOnce) {
    const Eigen::Index end = std::min(begin + kAtOnce, num);
    for (Eigen::Index i = begin; i < end; ++i) {
      const int x = (static_cast<int>(x0 + c * x_cells[i] - s * y_cells[i]) >> shift) - bias;
      const int y = (static_cast<int>(y0 + s * x_cells[i] + c * y_cells[i]) >> shift) - bias;
      count += grid.At(x, y);
    }
    if (count + static_cast<int>(num - end) < least) break;
  }
  return count;
}

Place FindPlace(const HitPyramid& pyramid, const Eigen::Matrix2Xd& points_m, const PlaceWindow& window,
                const PlaceTerms& terms) {
  if (points_m.cols() == 0) return {};
  const Lattice lattice(pyramid, points_m, window, terms.farthest_m);
  const auto num_points = static_cast<double>(points_m.cols());
  const auto Least = [](double count) { return static_cast<int>(std::ceil(count)); };
  int least = Least(terms.least_score * num_points);
  Place place;
  std::priority_queue<Node> front;
  const auto Look = [&](Node node) {
    if (!lattice.Contains(node)) return;
    ++place.evaluations;
    node.count = lattice.Bound(node, least);
    if (node.count >= least) front.push(node);
  };
  lattice.VisitTop(Look);
  std::optional<Node> best;
  while (!front.empty() && front.top().count >= least) {
    const Node node = front.top();
    front.pop();
    if (place.evaluations > terms.most_evaluations) {  // too much is alike
      place.rival = place.score = std::max(place.score, node.count / num_points);
      break;
    }
    if (best && lattice.IsAt(node, *best)) continue;
    if (node.level > 0) {
      const int half = 1 << (node.level - 1);
      for (int i = 0; i < 8; ++i) {
        Look({0, node.level - 1, node.x + (i & 1) * half, node.y + (i >> 1 & 1) * half, node.yaw + (i >> 2) * half});
      }
    } else if (best) {
      place.rival = node.count / num_points;
      break;
    } else {
      best = node;
      place.pose = lattice.PoseAt(node.x, node.y, node.yaw);
      place.score = node.count / num_points;
      least = Least(terms.rival_share * node.count);
    }
  }
  return place;
}

}  // namespace crsm
