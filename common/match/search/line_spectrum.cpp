#include "common/match/search/line_spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "common/math/pose2.hpp"

namespace crsm {
namespace {

constexpr std::size_t kDegrees = std::tuple_size_v<LineSpectrum>;

/// Points on parallel lines: the square of how many lie on each, summed up.
double SumOfSquares(const Eigen::Matrix2Xd& points_m, double direction_rad,
                    const MatchConstants::LineSpectrum& constants) {
  std::vector<int> on_line(static_cast<std::size_t>(constants.lines), 0);
  const auto [sin, cos] = ComputeSinCos(direction_rad);
  for (Eigen::Index i = 0; i < points_m.cols(); ++i) {
    const double across = (cos * points_m(0, i) + sin * points_m(1, i)) / constants.apart_m + constants.lines / 2;
    if (across >= 0.0 && across < constants.lines) ++on_line[static_cast<std::size_t>(across)];
  }
  return std::transform_reduce(on_line.begin(), on_line.end(), 0.0, std::plus<>(),
                               [](int num) { return static_cast<double>(num) * num; });
}

}  // namespace

LineSpectrum ComputeLineSpectrum(const Eigen::Matrix2Xd& points_m, const MatchConstants::LineSpectrum& constants) {
  Eigen::Array<double, kDegrees, 1> sums;
  for (std::size_t i = 0; i < kDegrees; ++i) {
    sums[static_cast<Eigen::Index>(i)] = SumOfSquares(points_m, static_cast<double>(i) * kPi / kDegrees, constants);
  }
  sums -= sums.mean();
  const double length = std::sqrt(sums.square().sum());
  LineSpectrum spectrum{};
  if (length == 0.0) return spectrum;
  for (std::size_t i = 0; i < kDegrees; ++i) {
    spectrum[i] = static_cast<float>(sums[static_cast<Eigen::Index>(i)] / length);
  }
  return spectrum;
}

Turns FindBestTurns(const LineSpectrum& fixed, const LineSpectrum& turned, int num) {
  std::array<float, kDegrees> agreement{};
  for (std::size_t turn = 0; turn < kDegrees; ++turn) {
    for (std::size_t i = 0; i < kDegrees; ++i) agreement[turn] += fixed[(i + turn) % kDegrees] * turned[i];
  }
  std::array<std::size_t, kDegrees> order;
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return agreement[a] > agreement[b]; });
  Turns turns;
  for (std::size_t i = 0; i < std::min(static_cast<std::size_t>(num), kDegrees); ++i) {
    for (const std::size_t beside : {kDegrees - 1, std::size_t{0}, std::size_t{1}}) {
      turns.set((order[i] + beside) % kDegrees);
    }
  }
  return turns;
}

}  // namespace crsm
