#include "common/match/global_search.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "common/match/summit.hpp"

namespace crsm {
namespace {

constexpr double kFirstCell_m = 0.2;
constexpr int kDirections = 120;
constexpr std::size_t kMostPlaces = 10'000;
constexpr int kMostRays = 180;  ///< of a scan; more tell no more
constexpr std::size_t kMostClimbs = 5000;
constexpr std::size_t kMostFinalists = 50;

bool Better(const Individual& a, const Individual& b) { return a.fitness > b.fitness; }

/// Whether two poses are of one place.
bool AreNear(const Pose2& a, const Pose2& b) {
  constexpr double kNear_m = 0.5;
  constexpr double kNear_rad = 0.26;
  return std::abs(a.x_m - b.x_m) <= kNear_m && std::abs(a.y_m - b.y_m) <= kNear_m &&
         std::abs(WrapAngle(a.yaw_rad - b.yaw_rad)) <= kNear_rad;
}

/// The map in larger cells, of `factor` x `factor`: occupied where one of them is, free where one is and none is
/// occupied.
class CoarseMap {
 public:
  CoarseMap(const ByteMap& map, const MapGeometry& geometry, int factor)
      : geometry_(factor * geometry.cell_size_m()), field_(0.0, true) {
    std::map<TileIndex, TileBytes> tiles;
    const auto Down = [factor](int cell) { return cell >= 0 ? cell / factor : -((-cell - 1) / factor) - 1; };
    for (const auto& [index, tile] : map.tiles().entries()) {
      for (int offset = 0; offset < kTileCells; ++offset) {
        const std::uint8_t byte = tile->cells[static_cast<std::size_t>(offset)];
        if (byte == kUnexploredByte) continue;
        const Cell fine = CellAt(index, offset);
        const Cell cell{Down(fine.x), Down(fine.y)};
        auto coarse = tiles.find(TileOf(cell));
        if (coarse == tiles.end()) {
          coarse = tiles.emplace(TileOf(cell), TileBytes{}).first;
          coarse->second.fill(kUnexploredByte);
        }
        std::uint8_t& whole = coarse->second[static_cast<std::size_t>(OffsetInTile(cell))];
        if (IsOccupied(byte)) whole = kOccupiedByte;
        if (IsFree(byte) && whole == kUnexploredByte) whole = kFreeByte;
      }
    }
    TileBytes unexplored;
    unexplored.fill(kUnexploredByte);
    std::vector<TileIndex> changed;
    for (const auto& [index, bytes] : tiles) {
      map_.Apply({index, PackRuns(unexplored, bytes)});
      changed.push_back(index);
    }
    field_.Refresh(map_, changed);
  }

  const ByteMap& map() const { return map_; }
  const MapGeometry& geometry() const { return geometry_; }
  const FitnessField& field() const { return field_; }

 private:
  ByteMap map_;
  MapGeometry geometry_;
  FitnessField field_;
};

std::vector<Pose2> FindFreePlaces(const CoarseMap& coarse) {
  std::vector<Pose2> places;
  const double cell_m = coarse.geometry().cell_size_m();
  for (const auto& [index, tile] : coarse.map().tiles().entries()) {
    for (int offset = 0; offset < kTileCells; ++offset) {
      if (tile->cells[static_cast<std::size_t>(offset)] != kFreeByte) continue;
      const Cell cell = CellAt(index, offset);
      places.push_back({(cell.x + 0.5) * cell_m, (cell.y + 0.5) * cell_m, 0.0});
    }
  }
  return places;
}

/// The best poses on the coarse map, those that the neighbouring directions do not beat.
std::vector<Individual> TryEverywhere(const CoarseMap& coarse, const std::vector<Pose2>& places,
                                      const Eigen::Matrix2Xd& hits_m, int& evaluations) {
  const RaysInCells rays = ToCells(hits_m, coarse.geometry());
  std::vector<Individual> best;
  std::array<double, kDirections> scores;
  for (const Pose2& place : places) {
    const auto At = [&](int direction) {
      return Pose2{place.x_m, place.y_m, 2.0 * kPi * direction / kDirections - kPi};
    };
    for (int i = 0; i < kDirections; ++i) {
      scores[static_cast<std::size_t>(i)] = coarse.field().Evaluate(rays, At(i), coarse.geometry());
    }
    for (int i = 0; i < kDirections; ++i) {
      const auto Score = [&](int direction) { return scores[static_cast<std::size_t>(direction % kDirections)]; };
      if (Score(i) > Score(i + kDirections - 1) && Score(i) >= Score(i + 1)) best.push_back({At(i), Score(i)});
    }
    evaluations += kDirections;
    if (best.size() < 4 * kMostClimbs) continue;
    std::stable_sort(best.begin(), best.end(), Better);
    best.resize(kMostClimbs);
  }
  std::stable_sort(best.begin(), best.end(), Better);
  if (best.size() > kMostClimbs) best.resize(kMostClimbs);
  return best;
}

/// The best of each place, best first; `most` of them.
std::vector<Individual> KeepDistinct(std::vector<Individual> candidates, std::size_t most) {
  std::stable_sort(candidates.begin(), candidates.end(), Better);
  std::vector<Individual> distinct;
  for (const Individual& candidate : candidates) {
    if (distinct.size() == most) break;
    const bool known = std::any_of(distinct.begin(), distinct.end(),
                                   [&](const Individual& other) { return AreNear(candidate.pose, other.pose); });
    if (!known) distinct.push_back(candidate);
  }
  return distinct;
}

/// Some columns of many, evenly spread.
Eigen::Matrix2Xd Thin(const Eigen::Matrix2Xd& all) {
  const Eigen::Index step = (all.cols() + kMostRays - 1) / kMostRays;
  if (step <= 1) return all;
  Eigen::Matrix2Xd some(2, (all.cols() + step - 1) / step);
  for (Eigen::Index i = 0; i < some.cols(); ++i) some.col(i) = all.col(i * step);
  return some;
}

}  // namespace

double ComputeAgreement(const ByteMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& T_map_laser,
                        const MapGeometry& geometry) {
  constexpr double kNear_m = 0.3;  // what stands so near was there for a moment
  constexpr double kMostSteps = 4000.0;
  const double cell_m = geometry.cell_size_m();
  const double tolerance_m = std::max(0.15, 1.5 * cell_m);
  if (hits_m.cols() == 0) return 0.0;
  const auto [sin, cos] = ComputeSinCos(T_map_laser.yaw_rad);
  int num_agreeing = 0;
  for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
    const double range_m = std::sqrt(hits_m.col(i).squaredNorm());
    const double dx = (cos * hits_m(0, i) - sin * hits_m(1, i)) / range_m;
    const double dy = (sin * hits_m(0, i) + cos * hits_m(1, i)) / range_m;
    const double step_m = std::max(cell_m, range_m / kMostSteps);
    for (double way_m = std::min(kNear_m, range_m - tolerance_m); way_m <= range_m + tolerance_m; way_m += step_m) {
      if (!IsOccupied(map.At(geometry.CellAt(T_map_laser.x_m + way_m * dx, T_map_laser.y_m + way_m * dy)))) continue;
      if (way_m >= range_m - tolerance_m) ++num_agreeing;
      break;
    }
  }
  return static_cast<double>(num_agreeing) / static_cast<double>(hits_m.cols());
}

double ScorePlace(const ByteMap& map, const FitnessField& field, const Eigen::Matrix2Xd& hits_m,
                  const Pose2& T_map_laser, const MapGeometry& geometry) {
  const Eigen::Matrix2Xd thinned_m = Thin(hits_m);
  return field.Evaluate(ToCells(thinned_m, geometry), T_map_laser, geometry) *
         ComputeAgreement(map, thinned_m, T_map_laser, geometry);
}

GlobalMatch SearchWholeMap(const ByteMap& map, const FitnessField& field, const Eigen::Matrix2Xd& hits_m,
                           const Eigen::Matrix2Xd& critical_hits_m, const MapGeometry& geometry) {
  GlobalMatch match;
  int factor = std::max(1, static_cast<int>(std::lround(kFirstCell_m / geometry.cell_size_m())));
  CoarseMap coarse(map, geometry, factor);
  std::vector<Pose2> places = FindFreePlaces(coarse);
  while (places.size() > kMostPlaces) {
    coarse = CoarseMap(map, geometry, factor *= 2);
    places = FindFreePlaces(coarse);
  }
  const Eigen::Matrix2Xd few_hits_m = Thin(critical_hits_m);
  std::vector<Individual> candidates = TryEverywhere(coarse, places, few_hits_m, match.evaluations);

  // Each of them climbs on finer and finer maps.
  double step_rad = kPi / kDirections;
  const auto ClimbOn = [&](const FitnessField& there, const MapGeometry& cells, const Eigen::Matrix2Xd& seen_m,
                           int num_halvings, std::vector<Individual>& climbers) {
    const RaysInCells rays = ToCells(seen_m, cells);
    for (Individual& climber : climbers) {
      climber = ClimbToSummit(climber.pose, cells.cell_size_m(), step_rad, num_halvings, [&](const Pose2& pose) {
        ++match.evaluations;
        return there.Evaluate(rays, pose, cells);
      });
    }
    step_rad *= 0.5;
  };
  while ((factor /= 2) > 1) {
    const CoarseMap finer(map, geometry, factor);
    ClimbOn(finer.field(), finer.geometry(), few_hits_m, 2, candidates);
  }
  ClimbOn(field, geometry, few_hits_m, 2, candidates);

  // The highest climb on with all rays, and are looked at more closely.
  std::vector<Individual> finalists = KeepDistinct(std::move(candidates), kMostFinalists);
  ClimbOn(field, geometry, Thin(hits_m), 4, finalists);
  for (Individual& finalist : finalists) finalist.fitness = ScorePlace(map, field, hits_m, finalist.pose, geometry);
  finalists = KeepDistinct(std::move(finalists), 2);
  if (finalists.empty()) return match;
  match.T_map_laser = finalists[0].pose;
  match.score = finalists[0].fitness;
  match.runner_up = finalists.size() > 1 ? finalists[1].fitness : 0.0;
  return match;
}

}  // namespace crsm
