#include "common/diagnosis/changes.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <unordered_map>

#include "common/graph/mapper.hpp"
#include "common/match/judge/census.hpp"
#include "common/math/columns.hpp"
#include "common/math/floor_to_int.hpp"
#include "common/math/symmetric.hpp"
#include "common/scan/hits.hpp"

namespace crsm {
namespace {

std::int64_t KeyOf(Cell cell) { return static_cast<std::int64_t>(cell.x) * (4 * kMaxCell) + cell.y; }
Cell CellOfKey(std::int64_t key) {
  const std::int64_t y = ((key + 2 * kMaxCell) % (4 * kMaxCell) + 4 * kMaxCell) % (4 * kMaxCell) - 2 * kMaxCell;
  return {static_cast<int>((key - y) / (4 * kMaxCell)), static_cast<int>(y)};
}

}  // namespace

class ChangeFinder::Votes {
  /// What scans say of one cell, for one kind of change.
  struct Ballot {
    std::vector<int> places;  ///< from which it was seen changed, rising
    int num_scans = 0;        ///< that did
    int num_against = 0;      ///< that saw it unchanged since the last of them
    int num_all_against = 0;  ///< ... since the first
    std::int64_t last_scan = -1;
    std::int64_t last_against = -1;
    std::int64_t first_utime = 0;

    void Count(std::int64_t scan, int place, std::int64_t utime) {
      num_against = 0;
      if (last_scan == scan) return;
      if (num_scans++ == 0) first_utime = utime;
      last_scan = scan;
      const auto at = std::ranges::lower_bound(places, place);
      if (at == places.end() || *at != place) places.insert(at, place);
    }

    /// Whether enough scans have seen by now that nothing has changed.
    bool Refute(std::int64_t scan, int enough) {
      if (last_against == scan || last_scan == scan) return false;
      last_against = scan;
      ++num_all_against;
      return ++num_against >= enough;
    }
  };

  /// The ballots of a kind.
  class Ballots {
   public:
    Ballot* Find(Cell cell) {
      const Marks* tile = marks_.Find(TileOf(cell));
      if (!tile || !tile->is_voted[static_cast<std::size_t>(OffsetInTile(cell))]) return nullptr;
      return &ballots_.find(KeyOf(cell))->second;
    }

    Ballot* Touch(Cell cell) {
      if (!marks_.HasRoomFor(TileOf(cell))) return nullptr;
      marks_.Touch(TileOf(cell)).is_voted[static_cast<std::size_t>(OffsetInTile(cell))] = true;
      return &ballots_[KeyOf(cell)];
    }

    void Drop(Cell cell) {
      marks_.Touch(TileOf(cell)).is_voted[static_cast<std::size_t>(OffsetInTile(cell))] = false;
      ballots_.erase(KeyOf(cell));
    }

    bool empty() const { return ballots_.empty(); }
    const std::unordered_map<std::int64_t, Ballot>& all() const { return ballots_; }

   private:
    struct Marks {
      std::array<bool, kTileCells> is_voted{};
    };
    TileGrid<Marks> marks_;
    std::unordered_map<std::int64_t, Ballot> ballots_;
  };

 public:
  using Constants = DiagnosisConstants::Changes;

  Votes(const ByteMap& map, const Constants& constants)
      : map_(map), geometry_(map.geometry()), constants_(constants), reader_(map, CensusOf(constants)) {}

  void Add(const ValidRays& rays, const ScanMatch& match) {
    const Pose2& pose = match.T_map_laser;
    if (match.state == MatchState::kLost || !Moved(match) || !Agrees(rays, pose)) return;
    last_ = {match.utime, pose};
    ++scan_;
    const auto& [xx, xy, xyaw, yy, yyaw, yawyaw] = match.covariance;
    const double mean = 0.5 * (xx + yy);
    const double largest = mean + std::sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy);
    const double place_sigma2 = std::max(0.0, largest) + constants_.range_sigma_m * constants_.range_sigma_m;
    const int place = FindPlace(pose);
    const Eigen::Matrix2Xd hits_m = ComputeHits(rays);
    const auto [sin, cos] = ComputeSinCos(pose.yaw_rad);
    const Eigen::Matrix2d rotation{{cos, -sin}, {sin, cos}};
    for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
      const Eigen::Vector2d ray_m = rotation * hits_m.col(i);
      const double sigma = std::sqrt(place_sigma2 + std::max(0.0, yawyaw) * ray_m.squaredNorm());
      const double tolerance_m = constants_.tolerance_cells * geometry_.cell_size_m() + constants_.sigmas * sigma;
      if (tolerance_m <= constants_.tolerance_max_m) AddRay(pose, ray_m, tolerance_m, place, match.utime);
    }
  }

  static MatchConstants::Census CensusOf(const Constants& constants) {
    MatchConstants::Census census;
    census.before_end_m = constants.before_end_m;
    return census;
  }

  void Learn(const ValidRays& rays, const Pose2& pose) {
    is_learning_ = true;
    ++scan_;
    const Eigen::Matrix2Xd hits_m = ComputeHits(rays);
    const auto [sin, cos] = ComputeSinCos(pose.yaw_rad);
    const Eigen::Matrix2d rotation{{cos, -sin}, {sin, cos}};
    const double tolerance_m =
        constants_.tolerance_cells * geometry_.cell_size_m() + constants_.sigmas * constants_.range_sigma_m;
    for (Eigen::Index i = 0; i < hits_m.cols(); ++i) AddRay(pose, rotation * hits_m.col(i), tolerance_m, 0, 0);
    is_learning_ = false;
  }

  std::vector<MapChange> Find() const {
    std::vector<MapChange> changes;
    for (const auto& [kind, ballots] : {std::pair(ChangeKind::kNew, &new_), std::pair(ChangeKind::kGone, &gone_)}) {
      for (const std::vector<std::int64_t>& thing : Cluster(*ballots)) {
        const auto change = Describe(kind, *ballots, thing);
        if (change) changes.push_back(*change);
      }
    }
    std::ranges::stable_sort(changes, std::ranges::greater(), &MapChange::area_m2);
    if (changes.size() > kMost) changes.resize(kMost);
    return changes;
  }

 private:
  bool Moved(const ScanMatch& match) const {
    if (!last_) return true;
    const Pose2 motion = Inverse(last_->T_map_laser) * match.T_map_laser;
    return Length(motion) >= constants_.step_m || std::abs(motion.yaw_rad) >= constants_.step_rad ||
           std::abs(static_cast<double>(match.utime - last_->utime)) >= constants_.step_s * 1e6;
  }

  /// Whether the scan fits the map as those of a good run do: one that does not may have been matched to a wrong place.
  bool Agrees(const ValidRays& rays, const Pose2& pose) {
    const Census census = CountRays(map_, ThinColumns(ComputeHits(rays), constants_.most_asked), pose);
    return census.fits >= constants_.least_agreement * (1.0 - census.unknown);
  }

  /// The number of the place of a pose: another one than those of poses that are further away, or look elsewhere.
  int FindPlace(const Pose2& pose) {
    const auto Square = [&](double at_m) { return FloorToInt(std::clamp(at_m, -1e6, 1e6) / constants_.place_m); };
    const int x = Square(pose.x_m);
    const int y = Square(pose.y_m);
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const auto near = places_.find({x + dx, y + dy});
        if (near == places_.end()) continue;
        for (const auto& [number, other] : near->second) {
          const bool is_same = Distance(pose, other) < constants_.place_m &&
                               std::abs(WrapAngle(pose.yaw_rad - other.yaw_rad)) < constants_.place_rad;
          if (is_same) return number;
        }
      }
    }
    places_[{x, y}].emplace_back(num_places_, pose);
    return num_places_++;
  }

  void AddRay(const Pose2& pose, const Eigen::Vector2d& ray_m, double tolerance_m, int place, std::int64_t utime) {
    const RayFate fate = reader_.FindFate(pose, ray_m);
    if (fate == RayFate::kUnknown) return;
    const double range_m = ray_m.norm();
    const Eigen::Vector2d direction = ray_m / range_m;
    const Eigen::Vector2d laser_m(pose.x_m, pose.y_m);
    const Eigen::Vector2d hit_m = laser_m + ray_m;
    const Cell hit = geometry_.CellAt(hit_m.x(), hit_m.y());
    if (fate == RayFate::kFits) {
      RefuteGone(hit_m, direction);
    } else if (IsFree(At(hit)) && !StandsNear(hit_m, tolerance_m)) {
      Vote(new_, hit, place, utime);
    }
    const bool passes = fate == RayFate::kPasses;
    if (!passes && new_.empty()) return;
    const double step_m = geometry_.cell_size_m();
    const double until_m = range_m - std::max(tolerance_m, constants_.before_end_m);
    Cell last{std::numeric_limits<int>::max(), 0};
    for (double at_m = 0.0; at_m < until_m; at_m += step_m) {
      const Eigen::Vector2d at = laser_m + at_m * direction;
      const Cell cell = geometry_.CellAt(at.x(), at.y());
      if (cell == last) continue;
      last = cell;
      Ballot* ballot = new_.Find(cell);
      if (ballot && ballot->Refute(scan_, constants_.enough_against)) new_.Drop(cell);
      if (passes && IsOccupied(At(cell)) && PassesHoweverItIsMoved(at, direction, tolerance_m)) {
        Vote(gone_, cell, place, utime);
      }
    }
  }

  /// A cell that the map's own scans contradict, or one beside it, is not asked.
  void Vote(Ballots& ballots, Cell cell, int place, std::int64_t utime) {
    if (is_learning_) {
      if (Ballot* ballot = errors_.Touch(cell)) ballot->Count(scan_, place, utime);
      return;
    }
    if (IsErrorOfMap(cell)) return;
    if (Ballot* ballot = ballots.Touch(cell)) ballot->Count(scan_, place, utime);
  }

  bool IsErrorOfMap(Cell cell) {
    if (errors_.empty()) return false;
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        const Ballot* ballot = errors_.Find({cell.x + x, cell.y + y});
        if (ballot && ballot->num_scans >= constants_.enough_errors) return true;
      }
    }
    return false;
  }

  std::uint8_t At(Cell cell) {
    const double cell_m = geometry_.cell_size_m();
    return reader_.At((cell.x + 0.5) * cell_m, (cell.y + 0.5) * cell_m);
  }

  bool StandsNear(const Eigen::Vector2d& at_m, double tolerance_m) {
    const double cell_m = geometry_.cell_size_m();
    const int reach = static_cast<int>(std::ceil(tolerance_m / cell_m));
    for (int y = -reach; y <= reach; ++y) {
      for (int x = -reach; x <= reach; ++x) {
        if (std::hypot(x, y) * cell_m > tolerance_m + 0.5 * cell_m) continue;
        if (IsOccupied(reader_.At(at_m.x() + x * cell_m, at_m.y() + y * cell_m))) return true;
      }
    }
    return false;
  }

  /// Whether the ray would pass through what stands there if it ran by the tolerance further left, or further right.
  bool PassesHoweverItIsMoved(const Eigen::Vector2d& at_m, const Eigen::Vector2d& direction, double tolerance_m) {
    const Eigen::Vector2d left(-direction.y(), direction.x());
    const double cell_m = geometry_.cell_size_m();
    for (const double side_m : {tolerance_m, -tolerance_m}) {
      bool passes = false;
      for (double along_m = -constants_.beside_m; along_m <= constants_.beside_m && !passes; along_m += cell_m) {
        const Eigen::Vector2d there = at_m + side_m * left + along_m * direction;
        passes = IsOccupied(reader_.At(there.x(), there.y()));
      }
      if (!passes) return false;
    }
    return true;
  }

  /// What stands there again hides the rest of the thing, which is behind it.
  void RefuteGone(const Eigen::Vector2d& hit_m, const Eigen::Vector2d& direction) {
    if (gone_.empty()) return;
    const Cell hit = geometry_.CellAt(hit_m.x(), hit_m.y());
    bool is_back = false;
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) is_back = RefuteGoneAt({hit.x + x, hit.y + y}) || is_back;
    }
    if (!is_back) return;
    const double cell_m = geometry_.cell_size_m();
    for (double behind_m = 2.0 * cell_m; behind_m < constants_.behind_m; behind_m += cell_m) {
      const Eigen::Vector2d at_m = hit_m + behind_m * direction;
      for (const double side_m : {-cell_m, 0.0, cell_m}) {
        const Eigen::Vector2d there_m = at_m + side_m * direction.unitOrthogonal();
        RefuteGoneAt(geometry_.CellAt(there_m.x(), there_m.y()));
      }
    }
  }

  /// Whether something had gone there.
  bool RefuteGoneAt(Cell cell) {
    Ballot* ballot = gone_.Find(cell);
    if (ballot && ballot->Refute(scan_, constants_.enough_against)) gone_.Drop(cell);
    return ballot != nullptr;
  }

  /// The cells of each thing: of those that enough scans saw changed, what lies close together.
  std::vector<std::vector<std::int64_t>> Cluster(const Ballots& ballots) const {
    std::map<std::int64_t, bool> is_left;  // in an order that is the same everywhere
    for (const auto& [key, ballot] : ballots.all()) {
      const bool is_seen = static_cast<int>(ballot.places.size()) >= constants_.least_places &&
                           ballot.num_scans >= constants_.least_scans &&
                           ballot.num_scans > constants_.majority * ballot.num_all_against;
      if (is_seen) is_left[key] = true;
    }
    const int reach = static_cast<int>(std::ceil(geometry_.ToCells(constants_.apart_m)));
    std::vector<std::vector<std::int64_t>> things;
    for (auto& [first, left] : is_left) {
      if (!left) continue;
      left = false;
      std::vector<std::int64_t> thing{first};
      for (std::size_t i = 0; i < thing.size(); ++i) {
        const Cell cell = CellOfKey(thing[i]);
        for (int y = -reach; y <= reach; ++y) {
          for (int x = -reach; x <= reach; ++x) {
            const auto near = is_left.find(KeyOf({cell.x + x, cell.y + y}));
            if (near == is_left.end() || !near->second) continue;
            near->second = false;
            thing.push_back(near->first);
          }
        }
      }
      things.push_back(std::move(thing));
    }
    return things;
  }

  /// Nothing if the thing is too small to tell.
  std::optional<MapChange> Describe(ChangeKind kind, const Ballots& ballots,
                                    const std::vector<std::int64_t>& thing) const {
    const double cell_m = geometry_.cell_size_m();
    std::vector<int> places;
    MapChange change;
    change.kind = kind;
    change.first_utime = std::numeric_limits<std::int64_t>::max();
    for (const std::int64_t key : thing) {
      const Ballot& ballot = ballots.all().at(key);
      places.insert(places.end(), ballot.places.begin(), ballot.places.end());
      change.first_utime = std::min(change.first_utime, ballot.first_utime);
    }
    std::ranges::sort(places);
    places.erase(std::unique(places.begin(), places.end()), places.end());
    change.num_places = static_cast<std::int32_t>(places.size());
    double least_m2 = std::numeric_limits<double>::infinity();
    constexpr int kTurns = 18;
    for (int turn = 0; turn < kTurns; ++turn) {
      const auto [sin, cos] = ComputeSinCos(turn * 0.5 * kPi / kTurns);
      Eigen::Array2d low = Eigen::Array2d::Constant(std::numeric_limits<double>::infinity());
      Eigen::Array2d high = -low;
      for (const std::int64_t key : thing) {
        const Cell cell = CellOfKey(key);
        const Eigen::Array2d at((cell.x + 0.5) * cell_m, (cell.y + 0.5) * cell_m);
        const Eigen::Array2d turned(cos * at.x() + sin * at.y(), -sin * at.x() + cos * at.y());
        low = low.min(turned);
        high = high.max(turned);
      }
      const Eigen::Array2d size = high - low + cell_m;
      if (size.prod() >= least_m2 - 1e-9) continue;
      least_m2 = size.prod();
      const Eigen::Array2d middle = 0.5 * (low + high);
      change.middle = {cos * middle.x() - sin * middle.y(), sin * middle.x() + cos * middle.y()};
      change.length_m = size.maxCoeff();
      change.width_m = size.minCoeff();
      const double yaw = turn * 0.5 * kPi / kTurns;
      change.yaw_rad = size.x() >= size.y() ? yaw : yaw - 0.5 * kPi;
    }
    const bool is_large = change.length_m >= constants_.least_m &&
                          static_cast<int>(thing.size()) >= constants_.least_cells &&
                          change.num_places >= constants_.least_places_of_thing;
    return is_large ? std::optional(change) : std::nullopt;
  }

  struct Last {
    std::int64_t utime;
    Pose2 T_map_laser;
  };

  const ByteMap& map_;
  MapGeometry geometry_;
  Constants constants_;
  RayReader reader_;
  std::optional<Last> last_;
  std::int64_t scan_ = 0;
  std::map<std::pair<int, int>, std::vector<std::pair<int, Pose2>>> places_;
  int num_places_ = 0;
  Ballots new_;
  Ballots gone_;
  Ballots errors_;  ///< of the map
  bool is_learning_ = false;
};

ChangeFinder::ChangeFinder(const ByteMap& map, const DiagnosisConstants::Changes& constants)
    : votes_(std::make_unique<Votes>(map, constants)) {}
ChangeFinder::~ChangeFinder() = default;
ChangeFinder::ChangeFinder(ChangeFinder&&) noexcept = default;

ChangeFinder MakeChangeFinder(const Mapper& mapper, const ByteMap& map) {
  ChangeFinder finder(map);
  for (const KeyframeId id : mapper.graph().ids()) {
    if (!mapper.IsKeyframeOnMap(id)) continue;
    finder.Learn(mapper.graph().keyframe(id).rays.Unpack(), At(mapper.best_poses(), id));
  }
  return finder;
}

void ChangeFinder::Learn(const ValidRays& rays, const Pose2& T_map_laser) { votes_->Learn(rays, T_map_laser); }

void ChangeFinder::Add(const ValidRays& rays, const ScanMatch& match) { votes_->Add(rays, match); }

std::vector<MapChange> ChangeFinder::Find() const { return votes_->Find(); }

}  // namespace crsm
