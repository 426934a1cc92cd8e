#include "common/diagnosis/self_contradiction.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "common/math/columns.hpp"
#include "common/math/median.hpp"
#include "common/math/random.hpp"
#include "common/math/trigonometry.hpp"
#include "common/scan/hits.hpp"

namespace crsm {
namespace {

using ContradictionConstants = DiagnosisConstants::SelfContradiction;

/// One scan, to be asked what its beams meet.
class Look {
 public:
  Look(const PlacedRays& scan, const ContradictionConstants& constants) : scan_(scan), constants_(constants) {
    std::vector<double> steps_rad;
    const auto& angles_rad = scan.rays.angle_rad;
    for (std::size_t i = 1; i < angles_rad.size(); ++i) steps_rad.push_back(angles_rad[i] - angles_rad[i - 1]);
    widest_rad_ = steps_rad.empty() ? 0.0 : constants.beam_gap * FindMedian(std::move(steps_rad));
  }

  /// Share of another scan's hits that lie in front of what this one sees, [0, 1]; nothing where it sees few of them.
  std::optional<double> Contradict(const PlacedRays& other) const {
    const Eigen::Matrix2Xd hits_m = ThinColumns(ComputeHits(other.rays), constants_.most_hits);
    const Pose2 T_this_other = Inverse(scan_.T_map_laser) * other.T_map_laser;
    int num_free = 0;
    int num_hit = 0;
    for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
      const Pose2 hit = T_this_other * Pose2{hits_m(0, i), hits_m(1, i), 0.0};
      const double range_m = Length(hit);
      const auto seen = FindBeams(HeadingOf(hit.x_m, hit.y_m, 0.0));
      if (!seen || range_m < constants_.nearest_m) continue;
      const double tolerance_m = constants_.tolerance_m + constants_.tolerance_per_m * range_m;
      num_free += seen->first > range_m + tolerance_m;
      num_hit += seen->first < range_m + tolerance_m && range_m < seen->second + tolerance_m;
    }
    if (num_free + num_hit < constants_.least_seen) return std::nullopt;
    return static_cast<double>(num_free) / (num_free + num_hit);
  }

 private:
  /// The smallest and the largest range of the three beams next to a direction [m]; nothing where one of them met
  /// nothing.
  std::optional<std::pair<double, double>> FindBeams(double angle_rad) const {
    const auto& angles_rad = scan_.rays.angle_rad;
    if (angles_rad.size() < 3) return std::nullopt;
    const double turned_rad = angles_rad.front() + std::remainder(angle_rad - angles_rad.front(), 2.0 * kPi);
    const double in_scan_rad = turned_rad < angles_rad.front() ? turned_rad + 2.0 * kPi : turned_rad;
    auto next = std::lower_bound(angles_rad.begin(), angles_rad.end(), static_cast<float>(in_scan_rad));
    if (next == angles_rad.begin() || next == angles_rad.end()) return std::nullopt;
    if (in_scan_rad - *(next - 1) < *next - in_scan_rad) --next;
    const auto i = static_cast<std::size_t>(next - angles_rad.begin());
    if (i == 0 || i + 1 == angles_rad.size()) return std::nullopt;
    if (angles_rad[i] - angles_rad[i - 1] > widest_rad_ || angles_rad[i + 1] - angles_rad[i] > widest_rad_) {
      return std::nullopt;
    }
    const auto& ranges_m = scan_.rays.range_m;
    const auto [least, most] = std::minmax({ranges_m[i - 1], ranges_m[i], ranges_m[i + 1]});
    return std::pair<double, double>(least, most);
  }

  const PlacedRays& scan_;
  const ContradictionConstants& constants_;
  double widest_rad_ = 0.0;
};

/// Of scans that were taken where the robot hardly moved, one.
std::vector<const PlacedRays*> ThinOut(std::span<const PlacedRays> scans, const ContradictionConstants& constants) {
  std::vector<const PlacedRays*> kept;
  for (const PlacedRays& scan : scans) {
    if (!kept.empty()) {
      const Pose2 motion = Inverse(kept.back()->T_map_laser) * scan.T_map_laser;
      if (Length(motion) < constants.apart_m && std::abs(motion.yaw_rad) < constants.apart_rad) continue;
    }
    kept.push_back(&scan);
  }
  return kept;
}

using Square = std::pair<std::int64_t, std::int64_t>;

Square SquareOf(const Pose2& pose, double side_m) {
  return {std::llround(std::floor(pose.x_m / side_m)), std::llround(std::floor(pose.y_m / side_m))};
}

/// Looks in one square.
struct Counted {
  int num_looks = 0;
  int num_contradict = 0;
  std::vector<Point> contradicting = {};  ///< where those scans were taken
};

/// The one of some places that lies nearest to their mean: it is on the path, which the mean need not be.
Point FindMiddle(const std::vector<Point>& places) {
  Point mean;
  for (const Point& place : places) {
    mean.x_m += place.x_m / static_cast<double>(places.size());
    mean.y_m += place.y_m / static_cast<double>(places.size());
  }
  const auto Away_m = [&](const Point& place) { return std::hypot(place.x_m - mean.x_m, place.y_m - mean.y_m); };
  return *std::ranges::min_element(places, {}, Away_m);
}

/// Pairs of scans of one place, long apart along the path.
std::vector<std::pair<const PlacedRays*, const PlacedRays*>> FindPairs(const std::vector<const PlacedRays*>& scans,
                                                                       const ContradictionConstants& constants) {
  std::map<Square, std::vector<const PlacedRays*>> at;
  std::vector<std::pair<const PlacedRays*, const PlacedRays*>> pairs;
  for (const PlacedRays* scan : scans) {
    const auto [x, y] = SquareOf(scan->T_map_laser, constants.same_place_m);
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        const auto square = at.find({x + dx, y + dy});
        if (square == at.end()) continue;
        for (const PlacedRays* earlier : square->second) {
          const bool is_here = Distance(earlier->T_map_laser, scan->T_map_laser) < constants.same_place_m;
          if (is_here && scan->path_m - earlier->path_m > constants.long_apart_m) pairs.emplace_back(earlier, scan);
        }
      }
    }
    at[{x, y}].push_back(scan);
  }
  return pairs;
}

}  // namespace

SelfContradiction FindSelfContradiction(std::span<const PlacedRays> scans,
                                        const DiagnosisConstants::SelfContradiction& constants) {
  auto pairs = FindPairs(ThinOut(scans, constants), constants);
  Random random(1);
  for (std::size_t i = 0; i < std::min(pairs.size(), constants.most_pairs); ++i) {
    std::swap(pairs[i], pairs[i + random.Next() % (pairs.size() - i)]);
  }
  pairs.resize(std::min(pairs.size(), constants.most_pairs));
  SelfContradiction found;
  std::int64_t num_contradict = 0;
  std::map<Square, Counted> squares;
  for (const auto& [earlier, later] : pairs) {
    for (const auto share :
         {Look(*earlier, constants).Contradict(*later), Look(*later, constants).Contradict(*earlier)}) {
      if (!share) continue;
      const bool contradicts = *share > constants.contradicting_share;
      ++found.num_looks;
      num_contradict += contradicts;
      Counted& there = squares[SquareOf(later->T_map_laser, constants.square_m)];
      ++there.num_looks;
      there.num_contradict += contradicts;
      if (contradicts) there.contradicting.push_back({later->T_map_laser.x_m, later->T_map_laser.y_m});
    }
  }
  for (const auto& [square, there] : squares) {
    const double share = static_cast<double>(there.num_contradict) / there.num_looks;
    if (there.num_looks < constants.square_looks_min || share <= found.worst_share) continue;
    found.worst_share = share;
    found.worst_place = FindMiddle(there.contradicting);
  }
  if (found.num_looks > 0) found.share = static_cast<double>(num_contradict) / static_cast<double>(found.num_looks);
  return found;
}

}  // namespace crsm
