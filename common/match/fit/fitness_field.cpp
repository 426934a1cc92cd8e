#include "common/match/fit/fitness_field.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <new>
#include <span>
#include <utility>

#include "common/match/fit/fitness_derivatives.hpp"
#include "common/match/fit/rays_in_cells.hpp"
#include "common/math/floor_to_int.hpp"

namespace crsm {
namespace {

/// A coordinate split into its cell and the rest, which is in [0, 1).
struct SplitCoordinate {
  int cell;
  double rest;
};

/// What lies far beyond the limits of the map is brought nearer, where all is as unexplored, so that no sum overflows.
SplitCoordinate Split(double cells) {
  constexpr double kFar = 8.0 * kMaxCell;
  const double near = std::clamp(cells, -kFar, kFar);
  const int cell = FloorToInt(near);
  return {cell, near - cell};
}

/// Whether the pairs of a tile depend on any cell of the map: they hold the first rows and columns of the next tiles
/// too.
bool IsNearMap(const ByteMap& map, TileIndex index) {
  const auto InMap = [&](int dx, int dy) { return map.tiles().Find({index.x + dx, index.y + dy}) != nullptr; };
  return InMap(0, 0) || InMap(1, 0) || InMap(0, 1) || InMap(1, 1);
}

/// The tiles from one corner to another with room around them for a map to grow. Room costs nothing but addresses, and
/// there is a lot: 128 tiles to all sides of the first one. Where that does not do, half of each side is added, so that
/// what it costs to move all tiles is a constant for each of them.
TileRectangle AddRoom(TileIndex low, TileIndex high) {
  constexpr double kRoomyTiles = 65536.0;
  const int width = high.x - low.x + 1;
  const int height = high.y - low.y + 1;
  const double scale = std::max(1.5, std::sqrt(kRoomyTiles / (static_cast<double>(width) * height)));
  const int beside = static_cast<int>(0.5 * (scale - 1.0) * width) + 1;
  const int above = static_cast<int>(0.5 * (scale - 1.0) * height) + 1;
  return {{low.x - beside, low.y - above},
          static_cast<unsigned>(width + 2 * beside),
          static_cast<unsigned>(height + 2 * above)};
}

/// The rectangle around two.
CellRectangle Around(const CellRectangle& a, const CellRectangle& b) {
  return {{std::min(a.low.x, b.low.x), std::min(a.low.y, b.low.y)},
          {std::max(a.high.x, b.high.x), std::max(a.high.y, b.high.y)}};
}

constexpr int kPadded = kTileSide + 4;
using PaddedBytes = std::array<std::uint8_t, kPadded * kPadded>;

/// A tile's bytes with one column and row before it and three after it; those in a rectangle that begins at the tile's
/// corner are to be copied.
void CopyBytes(const ByteMap& map, TileIndex index, const CellRectangle& wanted, PaddedBytes& bytes) {
  for (int tile_y = -1; tile_y <= 1; ++tile_y) {
    for (int tile_x = -1; tile_x <= 1; ++tile_x) {
      const int x_low = std::max(wanted.low.x, tile_x * kTileSide);
      const int x_end = std::min(wanted.high.x + 1, (tile_x + 1) * kTileSide);
      const int y_low = std::max(wanted.low.y, tile_y * kTileSide);
      const int y_end = std::min(wanted.high.y + 1, (tile_y + 1) * kTileSide);
      if (x_low >= x_end || y_low >= y_end) continue;
      const ByteMap::Tile* part = map.tiles().Find({index.x + tile_x, index.y + tile_y});
      for (int y = y_low; y < y_end; ++y) {
        auto* to = bytes.data() + (y + 1) * kPadded + x_low + 1;
        if (part) {
          std::copy_n(part->cells.data() + OffsetInTile({x_low, y}), x_end - x_low, to);
        } else {
          std::fill_n(to, x_end - x_low, kUnexploredByte);
        }
      }
    }
  }
}

using ScoreRow = std::array<std::int16_t, kPairsInRow>;

/// What rays score that end in the cells of a row, from one column to another. All numbers fit into 16 bits, of which a
/// processor computes eight at a time.
///
/// beside: the same row, as cells count that are neighbours.
void ComputeScores(const std::uint8_t* row, const std::uint8_t* beside, int x_low, int x_high,
                   std::int16_t unexplored_score, ScoreRow& scores) {
  const auto most = static_cast<std::int16_t>(kFullScore - unexplored_score);
  for (int x = x_low; x <= x_high; ++x) {
    const int around = beside[x - 1] + beside[x + 1] + beside[x - kPadded] + beside[x + kPadded];
    const auto explored = static_cast<std::int16_t>(most - 10 * row[x] - around);                  // line 10
    scores[static_cast<std::size_t>(x)] = row[x] == kUnexploredByte ? std::int16_t{0} : explored;  // lines 6 to 9
  }
}

}  // namespace

FitnessField::FitnessField(const MapGeometry& geometry, const ScoreRules& rules, FitnessKernel kernel)
    : geometry_(geometry),
      unexplored_score_(static_cast<std::int16_t>(std::lround(rules.unexplored_score))),
      interpolate_(rules.interpolate),
      kernel_(kernel),
      written_(rectangle_.num_places()),
      pairs_(MakeBlankTiles(rectangle_)) {}

void FitnessField::Unmap::operator()(ScorePair* pairs) const { munmap(pairs, num_bytes); }

/// All 0. The system gives memory only to those that are written to, in small pages: a large one would hold a tile and
/// a lot of room.
FitnessField::Pairs FitnessField::MakeBlankTiles(const TileRectangle& rectangle) {
  const std::size_t num_bytes = rectangle.num_places() * kPairsInTile * sizeof(ScorePair);
  void* pairs = mmap(nullptr, num_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (pairs == MAP_FAILED) throw std::bad_alloc();
  madvise(pairs, num_bytes, MADV_NOHUGEPAGE);
  return Pairs(static_cast<ScorePair*>(pairs), {num_bytes});
}

void FitnessField::Refresh(const ByteMap& map, const std::vector<TileIndex>& changed) {
  std::vector<CellRectangle> cells;
  for (const TileIndex index : changed) cells.push_back(CellsOf(index));
  RefreshCells(map, cells);
}

void FitnessField::RefreshCells(const ByteMap& map, const std::vector<CellRectangle>& changed) {
  std::map<TileIndex, CellRectangle> stale_of;  // each tile once, however many around it have changed
  for (const auto& [low, high] : changed) {
    // The score of a cell depends on its neighbours, and each score is in the pair of the cell below too.
    const CellRectangle stale{{low.x - 1, low.y - 2}, {high.x + 1, high.y + 1}};
    const TileIndex first = TileOf({stale.low.x - 2, stale.low.y - 1});  // which may hold the first ones of the next
    const TileIndex last = TileOf(stale.high);
    for (int y = first.y; y <= last.y; ++y) {
      for (int x = first.x; x <= last.x; ++x) {
        const auto [of_tile, is_first] = stale_of.try_emplace({x, y}, stale);
        if (!is_first) of_tile->second = Around(of_tile->second, stale);
      }
    }
  }
  for (const auto& [index, stale] : stale_of) {
    IsNearMap(map, index) ? RefreshPairs(map, index, stale) : Blank(index);
  }
}

/// Moves the tiles to where there is room for all of the map.
void FitnessField::MakeRoom(const ByteMap& map) {
  TileIndex low{INT_MAX, INT_MAX};
  TileIndex high{INT_MIN, INT_MIN};
  for (const auto& [index, tile] : map.tiles().entries()) {
    low = {std::min(low.x, index.x - 1), std::min(low.y, index.y - 1)};
    high = {std::max(high.x, index.x), std::max(high.y, index.y)};
  }
  const TileRectangle roomier = AddRoom(low, high);
  Pairs moved = MakeBlankTiles(roomier);
  std::vector<bool> written(roomier.num_places());
  const auto Move = [&](TileIndex index) {
    if (!rectangle_.Contains(index) || !written_[rectangle_.Place(index)]) return;
    written[roomier.Place(index)] = true;
    std::copy_n(FindTile(index), kPairsInTile, moved.get() + roomier.Place(index) * kPairsInTile);
  };
  for (const auto& entry : map.tiles().entries()) {
    const auto [x, y] = entry.index;
    Move(entry.index);
    for (const TileIndex beside : {TileIndex{x - 1, y}, {x, y - 1}, {x - 1, y - 1}}) {
      if (!map.tiles().Find(beside)) Move(beside);
    }
  }
  rectangle_ = roomier;
  written_ = std::move(written);
  pairs_ = std::move(moved);
}

/// What the tile holds is 0 from now on, and its memory goes back to the system: of pages that it shares with others,
/// as soon as these hold nothing either.
void FitnessField::Blank(TileIndex index) {
  if (!rectangle_.Contains(index) || !written_[rectangle_.Place(index)]) return;
  written_[rectangle_.Place(index)] = false;
  static const auto page_bytes = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  const auto begin = reinterpret_cast<std::uintptr_t>(FindTile(index));
  const auto end = begin + kPairsInTile * sizeof(ScorePair);
  const auto first_page = begin / page_bytes * page_bytes;
  const auto last_page = (end - 1) / page_bytes * page_bytes;
  if (first_page + page_bytes > last_page) {
    std::memset(reinterpret_cast<void*>(begin), 0, end - begin);
    return;
  }
  std::memset(reinterpret_cast<void*>(begin), 0, first_page + page_bytes - begin);
  std::memset(reinterpret_cast<void*>(last_page), 0, end - last_page);
  const auto IsBlank = [](std::uintptr_t page) {
    const auto* bytes = reinterpret_cast<const char*>(page);
    return bytes[0] == 0 && std::memcmp(bytes, bytes + 1, page_bytes - 1) == 0;
  };
  const auto from = IsBlank(first_page) ? first_page : first_page + page_bytes;
  const auto to = IsBlank(last_page) ? last_page + page_bytes : last_page;
  madvise(reinterpret_cast<void*>(from), to - from, MADV_DONTNEED);
}

/// stale: cells of the map whose pairs are to be made anew where they are in the tile.
void FitnessField::RefreshPairs(const ByteMap& map, TileIndex index, const CellRectangle& stale) {
  const Cell corner = CellsOf(index).low;
  const int x_low = std::max(stale.low.x - corner.x, 0);
  const int x_high = std::min(stale.high.x - corner.x, kPairsInRow - 1);
  const int y_low = std::max(stale.low.y - corner.y, 0);
  const int y_high = std::min(stale.high.y - corner.y, kPairRows - 1);
  if (x_low > x_high || y_low > y_high) return;
  if (!rectangle_.Contains(index)) MakeRoom(map);
  written_[rectangle_.Place(index)] = true;

  PaddedBytes bytes;
  CopyBytes(map, index, {{x_low - 1, y_low - 1}, {x_high + 1, y_high + 2}}, bytes);
  // Between cells it matters that both sides of a wall score alike: if the one that nobody sees scored more, each wall
  // would seem to stand a little further away, and the map would grow by a thousandth.
  PaddedBytes beside;
  const std::uint8_t unexplored_beside = interpolate_ ? kFreeByte : kUnexploredByte;
  const std::size_t first_row = static_cast<std::size_t>(y_low) * kPadded;
  const std::size_t num_rows = static_cast<std::size_t>(y_high - y_low) + 4;
  const auto copied = std::span(bytes).subspan(first_row, num_rows * kPadded);
  std::ranges::transform(copied, beside.begin() + static_cast<std::ptrdiff_t>(first_row),
                         [=](std::uint8_t byte) { return byte == kUnexploredByte ? unexplored_beside : byte; });
  ScoreRow here, above;
  const auto Compute = [&](int y, ScoreRow& scores) {
    const int begin = (y + 1) * kPadded + 1;
    ComputeScores(bytes.data() + begin, beside.data() + begin, x_low, x_high, unexplored_score_, scores);
  };
  Compute(y_low, above);
  ScorePair* pairs = FindTile(index) + y_low * kPairsInRow;
  for (int y = y_low; y <= y_high; ++y, pairs += kPairsInRow) {
    here.swap(above);
    Compute(y + 1, above);
    for (int x = x_low; x <= x_high; ++x) {
      pairs[x] = {here[static_cast<std::size_t>(x)], above[static_cast<std::size_t>(x)]};
    }
  }
}

// Interpolation is between the centres of cells, which lie half a cell up and right of their corners; a spline begins a
// whole cell left and below. The bilinear one begins at the nearest 1/128 of a cell, where kernels round down: a bias
// of each match, however small, adds up from scan to scan.

double FitnessField::Evaluate(const RaysInCells& rays, const Pose2& T_map_laser) const {
  if (rays.size() == 0) return 0.0;
  constexpr std::int64_t kUnit = kFractions * kFractions;
  const double shift = interpolate_ ? 0.5 / kFractions - 0.5 : 0.0;
  const std::int64_t sum = kernel_.bilinear(MakeTask(rays, T_map_laser, shift, kFractions));
  const std::int64_t unexplored_sum = unexplored_score_ * kUnit * rays.total_weight();
  return static_cast<double>(sum + unexplored_sum) / static_cast<double>(kFullScore * kUnit * rays.total_weight());
}

FitnessDerivatives FitnessField::Differentiate(const RaysInCells& rays, const Pose2& T_map_laser) const {
  FitnessDerivatives fitness;
  if (rays.size() == 0) return fitness;
  const SplineSums sums = kernel_.spline(MakeTask(rays, T_map_laser, -1.0, 1));
  const double weight = 1.0 / (static_cast<double>(kFullScore) * static_cast<double>(rays.total_weight()));
  const double by_m = weight / geometry_.cell_size_m();
  const double by_m2 = by_m / geometry_.cell_size_m();
  fitness.value = weight * sums.value + static_cast<double>(unexplored_score_) / kFullScore;
  fitness.gradient << by_m * sums.x, by_m * sums.y, weight * sums.yaw;
  fitness.hessian << by_m2 * sums.xx, by_m2 * sums.xy, by_m * sums.x_yaw,  //
      by_m2 * sums.xy, by_m2 * sums.yy, by_m * sums.y_yaw,                 //
      by_m * sums.x_yaw, by_m * sums.y_yaw, weight * sums.yaw_yaw;
  return fitness;
}

/// shift: of the score at which kernels begin from the cell in which a ray ends [cells]. units: in a cell, as the
/// kernel counts them.
FitnessTask FitnessField::MakeTask(const RaysInCells& rays, const Pose2& T_map_laser, double shift, int units) const {
  // Points are placed relative to the laser's cell, where single precision is exact to 1/128 of a cell.
  const SplitCoordinate laser_x = Split(geometry_.ToCells(T_map_laser.x_m));
  const SplitCoordinate laser_y = Split(geometry_.ToCells(T_map_laser.y_m));
  const SinCos rotation = ComputeSinCos(T_map_laser.yaw_rad);
  const auto scale = static_cast<float>(units);

  FitnessTask task;
  task.x = rays.x().data();
  task.y = rays.y().data();
  task.weight = rays.all_alike() ? nullptr : rays.weight().data();
  task.num_rays = static_cast<int>(rays.size());
  task.sin = static_cast<float>(rotation.sin) * scale;
  task.cos = static_cast<float>(rotation.cos) * scale;
  task.offset_x = static_cast<float>(laser_x.rest + shift) * scale;
  task.offset_y = static_cast<float>(laser_y.rest + shift) * scale;
  task.corner_x = (laser_x.cell - rectangle_.origin.x * kTileSide) * units;
  task.corner_y = (laser_y.cell - rectangle_.origin.y * kTileSide) * units;
  task.fraction_mask = interpolate_ ? kFractions - 1 : 0;
  task.tiles = rectangle_;
  task.pairs = pairs_.get();
  return task;
}

}  // namespace crsm
