#include "common/match/search/place_search.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "common/math/floor_to_int.hpp"

namespace crsm {
namespace {

/// From a pose to the next of a level, in cells of its grid.
constexpr int StepOfGrid(int level) { return level == 0 ? 1 : 2; }

/// What a level's grid has left of and below the hits, in its cells: what they were widened by, room for the next
/// poses, and a margin.
constexpr int BeforeGrid(int level) { return (level == 0 ? 1 : 2) + StepOfGrid(level) + 1; }

/// What the bits of a cell count, as four numbers of 16 bits, so that they are added up at once: kFreeWeight more, so
/// that none is negative.
constexpr std::array<std::uint64_t, 256> kCounts = [] {
  std::array<std::uint64_t, 256> counts{};
  for (std::uint64_t bits = 0; bits < counts.size(); ++bits) {
    for (std::uint64_t i = 0; i < 4; ++i) {
      const std::uint64_t hit = bits >> i & 1;
      const std::uint64_t free = bits >> (i + 4) & 1;
      counts[bits] |= (hit + HitPyramid::kFreeWeight * (1 - free)) << (16 * i);
    }
  }
  return counts;
}();

/// Points that are laid on a level's grid.
struct Overlaying {
  const std::uint8_t* cells;
  int width;
  int shift;  ///< a cell is 2^shift cells of the points wide
  float x0;   ///< of the pose, in these, and its turn
  float y0;
  float cos;
  float sin;
  float x_end;  ///< of the grid; there and at 0 lies nothing
  float y_end;
  const float* x;
  const float* y;
  int num;
  int least;  ///< as of HitPyramid::Count
};

__attribute__((always_inline)) inline float Clamp(float value, float most) {
  const float positive = value > 0.0f ? value : 0.0f;
  return positive < most ? positive : most;
}

/// Adds up kCounts.
__attribute__((always_inline)) inline void CountOverlay(const Overlaying& task, std::array<int, 4>& counts) {
  constexpr int kAtOnce = 64;
  constexpr int kFreeWeight = HitPyramid::kFreeWeight;
  const auto [cells, width, shift, x0, y0, cos, sin, x_end, y_end, px, py, num, least] = task;
  std::array<int, kAtOnce> at;
  for (int begin = 0; begin < num; begin += kAtOnce) {
    const int here = std::min(kAtOnce, num - begin);
    for (int i = 0; i < here; ++i) {
      const int x = static_cast<int>(Clamp(x0 + cos * px[begin + i] - sin * py[begin + i], x_end)) >> shift;
      const int y = static_cast<int>(Clamp(y0 + sin * px[begin + i] + cos * py[begin + i], y_end)) >> shift;
      at[static_cast<std::size_t>(i)] = y * width + x;
    }
    std::uint64_t four = 0;
    for (int i = 0; i < here; ++i) four += kCounts[cells[at[static_cast<std::size_t>(i)]]];
    for (std::size_t i = 0; i < 4; ++i) counts[i] += static_cast<int>(four >> (16 * i) & 0xffff);
    const int at_most = (kFreeWeight + 1) * (num - begin - here);
    if (*std::max_element(counts.begin(), counts.end()) + at_most < least + kFreeWeight * num) break;
  }
}

void CountOnAny(const Overlaying& task, std::array<int, 4>& counts) { CountOverlay(task, counts); }

#ifdef __x86_64__
/// The same, compiled for twice as many at a time.
__attribute__((target("avx2"))) void CountAvx2(const Overlaying& task, std::array<int, 4>& counts) {
  CountOverlay(task, counts);
}
#endif

using CountKernel = void (*)(const Overlaying& task, std::array<int, 4>& counts);

/// The fastest one on this machine.
CountKernel FindCountKernel() {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2")) return CountAvx2;
#endif
  return CountOnAny;
}

/// Poses on a lattice: 2^level of them along each axis, from here on.
struct Node {
  int count;
  int level;
  int x;
  int y;
  int yaw;
};

/// Nodes that are still to be looked at, those that promise most first: by count, the lower level, x, y and yaw. There
/// may be millions of them, and few counts and levels: each has a heap of its own.
class Front {
 public:
  /// most: of a count.
  explicit Front(int most) : heaps_(static_cast<std::size_t>(most + 1) * kLevels) {}

  bool empty() const { return top_ < 0; }
  /// Of the first one.
  int count() const { return top_ / kLevels; }

  /// Of a count from 0 on.
  void Push(const Node& node) {
    const int index = node.count * kLevels + kLevels - 1 - node.level;
    std::vector<std::uint64_t>& heap = heaps_[static_cast<std::size_t>(index)];
    heap.push_back(Pack(node.x) << (2 * kBits) | Pack(node.y) << kBits | Pack(node.yaw));
    std::ranges::push_heap(heap);
    top_ = std::max(top_, index);
  }

  Node Pop() {
    std::vector<std::uint64_t>& heap = heaps_[static_cast<std::size_t>(top_)];
    std::ranges::pop_heap(heap);
    const std::uint64_t at = heap.back();
    heap.pop_back();
    const Node node{count(), kLevels - 1 - top_ % kLevels, Unpack(at >> (2 * kBits)), Unpack(at >> kBits), Unpack(at)};
    while (top_ >= 0 && heaps_[static_cast<std::size_t>(top_)].empty()) --top_;
    return node;
  }

 private:
  static constexpr int kLevels = HitPyramid::kLevels;
  static constexpr int kBits = 21;
  static constexpr int kZero = 1 << (kBits - 1);
  static std::uint64_t Pack(int value) { return static_cast<std::uint64_t>(value + kZero); }
  static int Unpack(std::uint64_t bits) { return static_cast<int>(bits & (2 * kZero - 1)) - kZero; }

  std::vector<std::vector<std::uint64_t>> heaps_;  ///< by count and level
  int top_ = -1;                                   ///< the first one that is not empty
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
        y_cells_((points_m.row(1).array() / pyramid.cell_m()).cast<float>()) {
    if (!window.turns) return;
    num_allowed_.assign(1, 0);
    for (int yaw = -reach_yaw_; yaw <= reach_yaw_; ++yaw) {
      const auto degree = static_cast<int>(std::lround(yaw * step_rad_ * 180.0 / kPi));
      num_allowed_.push_back(num_allowed_.back() +
                             (window.turns->test(static_cast<std::size_t>(((degree % 180) + 180) % 180)) ? 1 : 0));
    }
  }

  Pose2 PoseAt(double x, double y, double yaw) const {
    return {centre_.x_m + x * pyramid_.cell_m(), centre_.y_m + y * pyramid_.cell_m(),
            WrapAngle(centre_.yaw_rad + yaw * step_rad_)};
  }

  /// The eight halves of a node that are in the window, each with how many points at most lie on hits at one of its
  /// poses; all that matters below `least` is that it is.
  template <class Visit>
  void VisitHalves(const Node& node, int least, Visit&& visit) const {
    const int level = node.level - 1;
    const int half = 1 << level;
    const double middle = 0.5 * (half - 1);
    for (const int yaw : {node.yaw, node.yaw + half}) {
      if (yaw > reach_yaw_ || !IsAnyAllowed(yaw, half)) continue;
      const std::array<int, 4> counts =
          pyramid_.Count(level, x_cells_, y_cells_, PoseAt(node.x + middle, node.y + middle, yaw + middle), least);
      for (int i = 0; i < 4; ++i) {
        const Node part{counts[static_cast<std::size_t>(i)], level, node.x + (i & 1) * half, node.y + (i >> 1) * half,
                        yaw};
        if (part.x <= reach_ && part.y <= reach_) visit(part);
      }
    }
  }

  /// Whether all poses of a node are those of one place.
  bool IsAt(const Node& node, const Node& place, const MatchConstants::OtherPlace& other) const {
    const int size = 1 << node.level;
    const auto Far = [size](int at, int from) { return std::max(from - at, at + size - 1 - from); };
    const double far_m = pyramid_.cell_m() * std::max(Far(node.x, place.x), Far(node.y, place.y));
    if (far_m >= other.m) return false;
    const int turn = static_cast<int>(std::lround(2.0 * kPi / step_rad_));  // in a wide window the ends meet
    const int far =
        std::min({Far(node.yaw, place.yaw), Far(node.yaw + turn, place.yaw), Far(node.yaw - turn, place.yaw)});
    return step_rad_ * far < other.rad;
  }

  /// The nodes whose halves are those of the highest level.
  template <class Visit>
  void VisitTop(Visit&& visit) const {
    constexpr int kTop = HitPyramid::kLevels;
    for (int yaw = -reach_yaw_; yaw <= reach_yaw_; yaw += 1 << kTop) {
      for (int y = -reach_; y <= reach_; y += 1 << kTop) {
        for (int x = -reach_; x <= reach_; x += 1 << kTop) visit(Node{0, kTop, x, y, yaw});
      }
    }
  }

 private:
  /// Of so many yaws from one on.
  bool IsAnyAllowed(int yaw, int num) const {
    if (num_allowed_.empty()) return true;
    const auto first = static_cast<std::size_t>(yaw + reach_yaw_);
    const std::size_t end = std::min(first + static_cast<std::size_t>(num), num_allowed_.size() - 1);
    return num_allowed_[end] > num_allowed_[first];
  }

  const HitPyramid& pyramid_;
  Pose2 centre_;
  double step_rad_;
  int reach_;
  int reach_yaw_;
  Eigen::ArrayXf x_cells_;
  Eigen::ArrayXf y_cells_;
  std::vector<int> num_allowed_;  ///< before each yaw, of all of the window; empty where all are
};

}  // namespace

HitPyramid::HitPyramid(const Eigen::Matrix2Xd& hits_m, double cell_m, const Eigen::Matrix4Xd& rays_m)
    : cell_m_(cell_m) {
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
  Build(base, rays_m.cols() > 0 ? DrawFree(base, rays_m) : Grid{});
}

HitPyramid::HitPyramid(const ByteMap& map, const Eigen::Vector2d& low_m, const Eigen::Vector2d& high_m, double cell_m)
    : cell_m_(cell_m), origin_m_(low_m) {
  const double map_cell_m = map.geometry().cell_size_m();
  Grid hits;
  hits.width = static_cast<int>((high_m.x() - low_m.x()) / cell_m) + 1;
  hits.height = static_cast<int>((high_m.y() - low_m.y()) / cell_m) + 1;
  hits.cells.assign(static_cast<std::size_t>(hits.width) * static_cast<std::size_t>(hits.height), 0);
  Grid free = hits;
  const TileIndex first = TileOf(map.geometry().CellAt(low_m.x(), low_m.y()));
  const TileIndex last = TileOf(map.geometry().CellAt(high_m.x(), high_m.y()));
  for (const auto& [index, tile] : map.tiles().entries()) {
    if (index.x < first.x || index.x > last.x || index.y < first.y || index.y > last.y) continue;
    const Cell corner = CellAt(index, 0);
    for (int row = 0; row < kTileSide; ++row) {
      const double y_m = (corner.y + row + 0.5) * map_cell_m - low_m.y();
      const int y = FloorToInt(y_m / cell_m);
      if (y < 1 || y >= hits.height - 1) continue;  // beyond the border nothing is known
      const std::size_t begin = static_cast<std::size_t>(y) * static_cast<std::size_t>(hits.width);
      for (int column = 0; column < kTileSide; ++column) {
        const std::uint8_t byte = tile->cells[static_cast<std::size_t>(row * kTileSide + column)];
        if (byte == kUnexploredByte) continue;
        const int x = FloorToInt(((corner.x + column + 0.5) * map_cell_m - low_m.x()) / cell_m);
        if (x < 1 || x >= hits.width - 1) continue;
        const std::size_t at = begin + static_cast<std::size_t>(x);
        (IsOccupied(byte) ? hits : free).cells[at] = 1;
      }
    }
  }
  for (std::size_t i = 0; i < hits.cells.size(); ++i) free.cells[i] &= static_cast<std::uint8_t>(1 - hits.cells[i]);
  Build(hits, free);
}

/// free: without cells if nothing is known of them.
void HitPyramid::Build(const Grid& base, const Grid& free) {
  // What is occupied is not free: free are cells of which all, occupied those of which any are, so one is made as the
  // other, turned round.
  const bool knows_free = !free.cells.empty();
  Grid hits = Widen(base, 1);
  Grid occupied = knows_free ? Widen(Invert(free), 1) : Grid{};
  const auto Join = [&](const Grid& of_hits, int reach, int step) {
    return knows_free ? JoinFour(of_hits, Invert(reach == 0 ? occupied : Widen(occupied, reach)), step)
                      : JoinFour(of_hits, step);
  };
  levels_[0] = Join(hits, 0, StepOfGrid(0));
  for (int level = 1; level < kLevels; ++level) {
    levels_[static_cast<std::size_t>(level)] = Join(Widen(hits, 2), 2, StepOfGrid(level));
    hits = Halve(hits);
    if (knows_free) occupied = Halve(occupied);
  }
}

/// Cells that rays cross and that no hit is in; none at the border, beyond which nothing is known.
HitPyramid::Grid HitPyramid::DrawFree(const Grid& hits, const Eigen::Matrix4Xd& rays_m) const {
  Grid free{hits.width, hits.height, std::vector<std::uint8_t>(hits.cells.size(), 0)};
  for (Eigen::Index i = 0; i < rays_m.cols(); ++i) {
    const Eigen::Vector2d from = (rays_m.col(i).head<2>() - origin_m_) / cell_m_;
    const Eigen::Vector2d to = (rays_m.col(i).tail<2>() - origin_m_) / cell_m_;
    const int num_steps = static_cast<int>(std::ceil((to - from).cwiseAbs().maxCoeff()));
    for (int step = 0; step < num_steps; ++step) {
      const Eigen::Vector2d at = from + (to - from) * step / num_steps;
      const int x = static_cast<int>(std::floor(at.x()));
      const int y = static_cast<int>(std::floor(at.y()));
      if (x < 1 || y < 1 || x >= free.width - 1 || y >= free.height - 1) continue;
      const auto cell =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(free.width) + static_cast<std::size_t>(x);
      free.cells[cell] = hits.cells[cell] == 0;
    }
  }
  return free;
}

HitPyramid::Grid HitPyramid::Invert(Grid grid) {
  for (std::uint8_t& cell : grid.cells) cell = cell == 0;
  return grid;
}

HitPyramid::Grid HitPyramid::JoinFour(const Grid& hits, const Grid& free, int step) {
  Grid joined = JoinFour(hits, step);
  const Grid joined_free = JoinFour(free, step);
  for (std::size_t i = 0; i < joined.cells.size(); ++i) {
    joined.cells[i] = static_cast<std::uint8_t>(joined.cells[i] | joined_free.cells[i] << 4);
  }
  return joined;
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

/// What a point at a cell lies on, and those `step` cells further along x, along y, and along both: a bit each. Grows
/// by so many cells to the left and below, and by a margin of one where nothing is.
HitPyramid::Grid HitPyramid::JoinFour(const Grid& grid, int step) {
  const auto w = static_cast<std::size_t>(grid.width);
  const auto h = static_cast<std::size_t>(grid.height);
  const auto s = static_cast<std::size_t>(step);
  Grid joined{grid.width + step + 2, grid.height + step + 2, {}};
  const std::size_t jw = w + s + 2;
  joined.cells.assign(jw * (h + s + 2), 0);
  for (std::size_t y = 0; y < h; ++y) {
    const std::uint8_t* from = &grid.cells[y * w];
    for (int bit = 0; bit < 4; ++bit) {
      std::uint8_t* to = &joined.cells[(y + 1 + (bit & 2 ? 0 : s)) * jw + 1 + (bit & 1 ? 0 : s)];
      for (std::size_t x = 0; x < w; ++x) to[x] = static_cast<std::uint8_t>(to[x] | from[x] << bit);
    }
  }
  return joined;
}

HitPyramid::Overlay HitPyramid::Lay(const Eigen::Matrix2Xd& points_m, const Pose2& pose) const {
  Overlay overlay;
  const Grid& grid = levels_[0];
  if (grid.cells.empty()) return overlay;
  constexpr unsigned kHit = 1;
  constexpr unsigned kFree = 1 << 4;
  const auto [sin, cos] = ComputeSinCos(pose.yaw_rad);
  const Eigen::Vector2d at_m = Eigen::Vector2d(pose.x_m, pose.y_m) - origin_m_;
  for (Eigen::Index i = 0; i < points_m.cols(); ++i) {
    const double x_m = at_m.x() + cos * points_m(0, i) - sin * points_m(1, i);
    const double y_m = at_m.y() + sin * points_m(0, i) + cos * points_m(1, i);
    const auto x = static_cast<int>(std::floor(x_m / cell_m_)) + BeforeGrid(0);
    const auto y = static_cast<int>(std::floor(y_m / cell_m_)) + BeforeGrid(0);
    if (x < 0 || y < 0 || x >= grid.width || y >= grid.height) continue;
    const unsigned bits =
        grid.cells[static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.width) + static_cast<std::size_t>(x)];
    if (bits & kHit) ++overlay.on_hits;
    if (bits & kFree) ++overlay.on_free;
  }
  return overlay;
}

std::array<int, 4> HitPyramid::Count(int level, const Eigen::ArrayXf& x_cells, const Eigen::ArrayXf& y_cells,
                                     const Pose2& pose, int least) const {
  const Grid& grid = levels_[static_cast<std::size_t>(level)];
  std::array<int, 4> counts{};
  if (grid.cells.empty()) return counts;
  const int shift = std::max(level - 1, 0);
  const int before = BeforeGrid(level);
  const int offset = level == 0 ? 0 : 1;  // level 0 was widened by a cell before it was halved
  const auto [sin, cos] = ComputeSinCos(pose.yaw_rad);
  const auto s = static_cast<float>(sin);
  const auto c = static_cast<float>(cos);
  const auto x0 = static_cast<float>((pose.x_m - origin_m_.x()) / cell_m_ + offset + before * (1 << shift));
  const auto y0 = static_cast<float>((pose.y_m - origin_m_.y()) / cell_m_ + offset + before * (1 << shift));
  const auto x_end = static_cast<float>((grid.width - 1) << shift);  // there and at 0 lies nothing
  const auto y_end = static_cast<float>((grid.height - 1) << shift);
  const Overlaying task{grid.cells.data(), grid.width, shift, x0, y0, c, s, x_end, y_end, x_cells.data(),
                        y_cells.data(), static_cast<int>(x_cells.size()), least};
  static const CountKernel count_kernel = FindCountKernel();
  count_kernel(task, counts);
  const auto num = static_cast<int>(x_cells.size());
  for (int& count : counts) count -= kFreeWeight * num;
  return counts;
}

Places FindPlaces(const HitPyramid& pyramid, const Eigen::Matrix2Xd& points_m, const PlaceWindow& window,
                  const PlaceTerms& terms, std::size_t most) {
  Places found;
  if (points_m.cols() == 0) return found;
  const Lattice lattice(pyramid, points_m, window, terms.farthest_m);
  const auto num_points = static_cast<double>(points_m.cols());
  const auto Least = [](double count) { return static_cast<int>(std::ceil(count)); };
  int least = Least(terms.least_score * num_points);
  Front front(static_cast<int>(points_m.cols()));
  const auto Halve = [&](const Node& node) {
    lattice.VisitHalves(node, least, [&](const Node& part) {
      ++found.evaluations;
      if (part.count >= least) front.Push(part);
    });
  };
  lattice.VisitTop(Halve);
  std::vector<Node> known;
  while (!front.empty() && front.count() >= least && known.size() < most) {
    const Node node = front.Pop();
    if (found.evaluations > terms.most_evaluations) {
      found.highest_left = node.count / num_points;
      break;
    }
    const auto IsAt = [&](const Node& place) { return lattice.IsAt(node, place, terms.other); };
    if (std::any_of(known.begin(), known.end(), IsAt)) continue;
    if (node.level > 0) {
      Halve(node);
      continue;
    }
    if (known.empty()) least = Least(terms.rival_share * node.count);
    known.push_back(node);
    found.places.push_back({lattice.PoseAt(node.x, node.y, node.yaw), node.count / num_points});
  }
  return found;
}

Place FindPlace(const HitPyramid& pyramid, const Eigen::Matrix2Xd& points_m, const PlaceWindow& window,
                const PlaceTerms& terms) {
  const Places found = FindPlaces(pyramid, points_m, window, terms, 2);
  Place place;
  place.evaluations = found.evaluations;
  if (!found.places.empty()) {
    place.pose = found.places[0].pose;
    place.score = found.places[0].fitness;
  }
  if (found.places.size() > 1) place.rival = found.places[1].fitness;
  if (found.highest_left > 0.0) place.rival = place.score = std::max(place.score, found.highest_left);
  return place;
}

}  // namespace crsm
