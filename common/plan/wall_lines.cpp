#include "common/plan/wall_lines.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/math/symmetric.hpp"
#include "common/scan/hits.hpp"
#include "common/scan/surface.hpp"

namespace crsm {

void HitSums::Add(const Eigen::Vector2d& hit_m) {
  num += 1.0;
  const Eigen::Vector2d off = hit_m - mean_m;
  mean_m += off / num;
  scatter_m2 += off * (hit_m - mean_m).transpose();
}

void HitSums::Add(const HitSums& other) {
  if (other.num == 0.0) return;
  const Eigen::Vector2d off = other.mean_m - mean_m;
  const double sum = num + other.num;
  scatter_m2 += other.scatter_m2 + off * off.transpose() * (num * other.num / sum);
  mean_m += off * (other.num / sum);
  num = sum;
}

namespace {

Eigen::Vector2d Turned(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

/// Adds the stretches of hits first to last, on one surface.
class Splitter {
 public:
  Splitter(const Eigen::Matrix2Xd& hits_m, const Eigen::Vector2d& laser_m, int scan,
           const PlanConstants::Stretch& constants, std::vector<WallStretch>& found)
      : hits_m_(hits_m), laser_m_(laser_m), scan_(scan), constants_(constants), found_(found) {}

  void Split(Eigen::Index first, Eigen::Index last) {
    if (last - first + 1 < constants_.least_hits) return;
    const Eigen::Vector2d chord = hits_m_.col(last) - hits_m_.col(first);
    const double length_m = chord.norm();
    Eigen::Index furthest = first;
    double most_m = 0.0;
    for (Eigen::Index i = first + 1; i < last; ++i) {
      const Eigen::Vector2d off = hits_m_.col(i) - hits_m_.col(first);
      const double off_m = length_m > 1e-6 ? std::abs(Cross(chord, off)) / length_m : off.norm();
      if (off_m > most_m) {
        most_m = off_m;
        furthest = i;
      }
    }
    if (most_m > constants_.bend_max_m) {
      Split(first, furthest);
      return Split(furthest, last);
    }
    Add(first, last);
  }

 private:
  void Add(Eigen::Index first, Eigen::Index last) {
    WallStretch stretch;
    stretch.scan = scan_;
    for (Eigen::Index i = first; i <= last; ++i) stretch.hits.Add(Eigen::Vector2d(hits_m_.col(i)));
    const auto weakest = FindWeakest(stretch.hits.scatter_m2);
    const Eigen::Vector2d& normal = weakest.second;
    if (weakest.first > stretch.hits.num * constants_.residual_max_m * constants_.residual_max_m) return;
    const Eigen::Vector2d& mean = stretch.hits.mean_m;
    const auto OnLine = [&](Eigen::Index i) -> Eigen::Vector2d {
      const Eigen::Vector2d hit = hits_m_.col(i);
      return hit - normal * normal.dot(hit - mean);
    };
    stretch.from_m = OnLine(first);
    stretch.to_m = OnLine(last);
    if ((stretch.to_m - stretch.from_m).norm() < constants_.least_m) return;
    stretch.normal = normal.dot(laser_m_ - mean) >= 0.0 ? normal : Eigen::Vector2d(-normal);
    found_.push_back(stretch);
  }

  const Eigen::Matrix2Xd& hits_m_;
  Eigen::Vector2d laser_m_;
  int scan_;
  const PlanConstants::Stretch& constants_;
  std::vector<WallStretch>& found_;
};

double LengthOf(const WallStretch& stretch) { return (stretch.to_m - stretch.from_m).norm(); }

/// Fits a line to its stretches; what it covers as well.
void Fit(const std::vector<WallStretch>& stretches, const PlanConstants::Line& constants, WallLine& line) {
  HitSums sums;
  for (const int i : line.stretches) sums.Add(stretches[static_cast<std::size_t>(i)].hits);
  Eigen::Vector2d normal = FindWeakest(sums.scatter_m2).second;
  if (normal.dot(line.normal) < 0.0) normal = -normal;
  line.origin_m = sums.mean_m;
  line.normal = normal;
  line.along = -Turned(normal);
  line.from_m = std::numeric_limits<double>::infinity();
  line.to_m = -line.from_m;
  double off2 = 0.0;
  for (const int i : line.stretches) {
    const WallStretch& stretch = stretches[static_cast<std::size_t>(i)];
    for (const double at : {line.Along(stretch.from_m), line.Along(stretch.to_m)}) {
      line.from_m = std::min(line.from_m, at);
      line.to_m = std::max(line.to_m, at);
    }
    const double off = line.Across(stretch.hits.mean_m);
    off2 += off * off;
  }
  // Hits of one scan have the error of its pose in common: scans count, not hits.
  const auto num = static_cast<double>(line.stretches.size());
  const double sigma = std::max(constants.pose_sigma_m, std::sqrt(off2 / num));
  const double spread = std::sqrt(std::max(1e-6, line.along.dot(sums.scatter_m2 * line.along) / sums.num));
  line.sigma_offset_m = sigma / std::sqrt(num);
  line.sigma_yaw_rad = line.sigma_offset_m / spread;
}

/// How far its stretches turn against a line, on the average: those of one wall do not.
double MeanTurn(const WallLine& line, const std::vector<WallStretch>& stretches) {
  double sum = 0.0;
  double weight = 0.0;
  for (const int i : line.stretches) {
    const WallStretch& stretch = stretches[static_cast<std::size_t>(i)];
    sum += LengthOf(stretch) * Cross(stretch.normal, line.normal);
    weight += LengthOf(stretch);
  }
  return sum / weight;
}

/// along_max_m: to the next stretch.
bool LiesOn(const WallLine& line, const WallStretch& stretch, double along_max_m,
            const PlanConstants::Line& constants) {
  if (stretch.normal.dot(line.normal) <= 0.0) return false;
  const double turn = std::abs(Cross(stretch.normal, line.normal));
  if (turn > constants.yaw_max_rad + constants.end_m / LengthOf(stretch)) return false;
  if (std::abs(line.Across(stretch.from_m)) > constants.offset_max_m) return false;
  if (std::abs(line.Across(stretch.to_m)) > constants.offset_max_m) return false;
  const auto [from, to] = std::minmax({line.Along(stretch.from_m), line.Along(stretch.to_m)});
  return from <= line.to_m + along_max_m && to >= line.from_m - along_max_m;
}

/// The line of the first stretch that is left.
WallLine GrowLine(const std::vector<WallStretch>& stretches, const std::vector<int>& left, double along_max_m,
                  const PlanConstants::Line& constants) {
  WallLine line;
  line.normal = stretches[static_cast<std::size_t>(left.front())].normal;
  line.stretches = {left.front()};
  Fit(stretches, constants, line);
  constexpr int kMostRounds = 6;
  for (int round = 0; round < kMostRounds; ++round) {
    std::vector<int> on_it;
    for (const int i : left) {
      if (LiesOn(line, stretches[static_cast<std::size_t>(i)], along_max_m, constants)) on_it.push_back(i);
    }
    if (on_it.empty() || on_it == line.stretches) break;
    line.stretches = on_it;
    Fit(stretches, constants, line);
  }
  return line;
}

/// Whether two lines are the two sides of one thin wall.
bool AreOneThinWall(const WallLine& a, const WallLine& b, const PlanConstants::Line& constants) {
  if (a.normal.dot(b.normal) >= 0.0 || std::abs(Cross(a.normal, b.normal)) > constants.yaw_max_rad) return false;
  const auto [from, to] = std::minmax({a.Along(b.At(b.from_m)), a.Along(b.At(b.to_m))});
  const double first = std::max(from, a.from_m);
  const double last = std::min(to, a.to_m);
  if (first >= last) return false;
  const Eigen::Vector2d middle = a.At(0.5 * (first + last));
  return std::abs(b.Across(middle)) < constants.one_face_m;
}

}  // namespace

std::vector<WallStretch> FindStretches(const PlacedScan& scan, int number, const PlanConstants::Stretch& constants) {
  const Eigen::Matrix2Xd seen_m = ComputeHits(scan.rays.Unpack());
  const auto [sin, cos] = ComputeSinCos(scan.T_map_laser.yaw_rad);
  const Eigen::Matrix2d rotation{{cos, -sin}, {sin, cos}};
  const Eigen::Vector2d laser_m(scan.T_map_laser.x_m, scan.T_map_laser.y_m);
  const Eigen::Matrix2Xd hits_m = (rotation * seen_m).colwise() + laser_m;
  std::vector<WallStretch> found;
  if (hits_m.cols() == 0) return found;
  const std::vector<bool> joined = Gaps(seen_m).FindSurfaces(constants.near_m, constants.join_max_m);
  Splitter splitter(hits_m, laser_m, number, constants, found);
  Eigen::Index first = 0;
  for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
    if (i + 1 < hits_m.cols() && joined[static_cast<std::size_t>(i)]) continue;
    splitter.Split(first, i);
    first = i + 1;
  }
  return found;
}

std::vector<WallLine> FitLines(const std::vector<WallStretch>& stretches, const PlanConstants::Line& constants) {
  std::vector<int> left(stretches.size());
  std::iota(left.begin(), left.end(), 0);
  std::stable_sort(left.begin(), left.end(), [&](int a, int b) {
    return LengthOf(stretches[static_cast<std::size_t>(a)]) > LengthOf(stretches[static_cast<std::size_t>(b)]);
  });
  std::vector<WallLine> lines;
  while (!left.empty()) {
    WallLine line = GrowLine(stretches, left, constants.along_max_m, constants);
    if (std::abs(MeanTurn(line, stretches)) > constants.turn_max_rad) {
      line = GrowLine(stretches, left, constants.close_m, constants);
    }
    if (static_cast<int>(line.stretches.size()) >= constants.least_scans) lines.push_back(line);
    std::vector<int> others;
    const std::vector<int>& taken = line.stretches;  // in the order of `left`
    auto next = taken.begin();
    for (const int i : left) {
      if (next != taken.end() && *next == i) {
        ++next;
      } else if (i != left.front()) {
        others.push_back(i);
      }
    }
    left = std::move(others);
  }
  for (std::size_t i = 0; i < lines.size(); ++i) {
    for (std::size_t j = lines.size(); --j > i;) {
      if (!AreOneThinWall(lines[i], lines[j], constants)) continue;
      lines[i].stretches.insert(lines[i].stretches.end(), lines[j].stretches.begin(), lines[j].stretches.end());
      lines[i].two_faced = true;
      lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(j));
      Fit(stretches, constants, lines[i]);
    }
  }
  return lines;
}

std::vector<double> SnapLines(std::vector<WallLine>& lines, const PlanConstants::Direction& constants) {
  constexpr double kQuarter_rad = kPi / 2.0;
  const auto YawOf = [&](const WallLine& line) {
    const double yaw = std::atan2(line.along.y(), line.along.x());
    return yaw - std::floor(yaw / kQuarter_rad) * kQuarter_rad;
  };
  const auto Difference = [&](double a, double b) { return std::remainder(a - b, kQuarter_rad); };
  std::vector<double> weights;  // long lines that many scans saw say most
  for (const WallLine& line : lines) weights.push_back(line.to_m - line.from_m);
  const double all_m = std::accumulate(weights.begin(), weights.end(), 0.0);
  std::vector<double> directions;
  while (static_cast<int>(directions.size()) < constants.most) {
    double best_m = 0.0;
    double best = 0.0;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (weights[i] == 0.0) continue;
      double near_m = 0.0;
      for (std::size_t j = 0; j < lines.size(); ++j) {
        if (std::abs(Difference(YawOf(lines[j]), YawOf(lines[i]))) < constants.width_rad) near_m += weights[j];
      }
      if (near_m > best_m) {
        best_m = near_m;
        best = YawOf(lines[i]);
      }
    }
    if (best_m <= constants.least_share * all_m || best_m == 0.0) break;
    for (int round = 0; round < 3; ++round) {
      double sum = 0.0;
      double off = 0.0;
      for (std::size_t i = 0; i < lines.size(); ++i) {
        const double difference = Difference(YawOf(lines[i]), best);
        if (std::abs(difference) >= constants.width_rad) continue;
        const double sigma = std::max(lines[i].sigma_yaw_rad, constants.yaw_sigma_rad);
        const double weight = weights[i] / (sigma * sigma);
        sum += weight;
        off += weight * difference;
      }
      if (sum > 0.0) best += off / sum;
    }
    directions.push_back(best - std::floor(best / kQuarter_rad) * kQuarter_rad);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (std::abs(Difference(YawOf(lines[i]), best)) < constants.width_rad) weights[i] = 0.0;
    }
  }
  for (WallLine& line : lines) {
    for (const double direction : directions) {
      const double turn = Difference(direction, YawOf(line));
      const double sigma = std::max(line.sigma_yaw_rad, constants.yaw_sigma_rad);
      if (std::abs(turn) > std::min(constants.sigmas * sigma, constants.most_rad)) continue;
      const auto [sin, cos] = ComputeSinCos(turn);
      const Eigen::Matrix2d rotation{{cos, -sin}, {sin, cos}};
      line.along = rotation * line.along;
      line.normal = rotation * line.normal;
      line.snapped = true;
      break;
    }
  }
  return directions;
}

}  // namespace crsm
