#include "common/scan/packed_rays.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

namespace crsm {
namespace {

constexpr std::size_t kBits = 64;
constexpr std::size_t kMostBeams = 4096;  // that scans share: a laser that has more makes them up anew each time

float FromMillimetres(std::uint16_t range_mm) { return static_cast<float>(range_mm / 1000.0); }

/// Nothing where that would not be exact.
std::optional<std::vector<std::uint16_t>> ToMillimetres(const std::vector<float>& range_m) {
  std::vector<std::uint16_t> range_mm;
  range_mm.reserve(range_m.size());
  for (const float range : range_m) {
    const double rounded = std::round(1000.0 * range);
    if (!(rounded >= 0.0 && rounded <= std::numeric_limits<std::uint16_t>::max())) return std::nullopt;
    range_mm.push_back(static_cast<std::uint16_t>(rounded));
    if (FromMillimetres(range_mm.back()) != range) return std::nullopt;
  }
  return range_mm;
}

std::vector<std::uint64_t> AllOf(std::size_t num) {
  std::vector<std::uint64_t> bits((num + kBits - 1) / kBits, ~std::uint64_t{0});
  if (num % kBits != 0) bits.back() >>= kBits - num % kBits;
  return bits;
}

}  // namespace

PackedRays::PackedRays(const ValidRays& rays) {
  if (rays.size() == 0) return;
  Packed packed;
  packed.num_rays = rays.size();
  packed.angle_rad = std::make_shared<const std::vector<float>>(rays.angle_rad);
  packed.has_range = AllOf(rays.size());
  if (auto range_mm = ToMillimetres(rays.range_m)) {
    packed.range_mm = *std::move(range_mm);
  } else {
    packed.range_m = rays.range_m;
  }
  packed_ = std::make_shared<const Packed>(std::move(packed));
}

void PackedRays::ShareAngles(const PackedRays& other) {
  if (!packed_ || !other.packed_ || packed_->angle_rad == other.packed_->angle_rad) return;
  const std::vector<float>& known = *other.packed_->angle_rad;
  const std::vector<float> mine = Unpack().angle_rad;
  const bool rise = std::ranges::adjacent_find(mine, std::greater_equal()) == mine.end();
  if (!rise || std::ranges::adjacent_find(known, std::greater_equal()) != known.end()) return;
  const std::vector<float>& mine_and_more = *packed_->angle_rad;
  if (mine_and_more.size() > known.size() && std::ranges::includes(mine_and_more, known)) return;
  Angles all = other.packed_->angle_rad;
  if (!std::ranges::includes(known, mine)) {
    std::vector<float> united;
    std::ranges::set_union(known, mine, std::back_inserter(united));
    const bool mostly_others = united.size() > known.size() + mine.size() / 2;
    if (mostly_others || united.size() > kMostBeams) return;
    all = std::make_shared<const std::vector<float>>(std::move(united));
  }
  Packed packed = *packed_;
  packed.has_range.assign((all->size() + kBits - 1) / kBits, 0);
  std::size_t beam = 0;
  for (const float angle_rad : mine) {
    while ((*all)[beam] != angle_rad) ++beam;
    packed.has_range[beam / kBits] |= std::uint64_t{1} << beam % kBits;
  }
  packed.angle_rad = std::move(all);
  packed_ = std::make_shared<const Packed>(std::move(packed));
}

ValidRays PackedRays::Unpack() const {
  ValidRays rays;
  if (!packed_) return rays;
  rays.angle_rad.reserve(packed_->num_rays);
  for (std::size_t beam = 0; beam < packed_->angle_rad->size(); ++beam) {
    if (packed_->has_range[beam / kBits] >> beam % kBits & 1) rays.angle_rad.push_back((*packed_->angle_rad)[beam]);
  }
  rays.range_m = packed_->range_m;
  if (!rays.range_m.empty()) return rays;
  rays.range_m.resize(packed_->num_rays);
  std::ranges::transform(packed_->range_mm, rays.range_m.begin(), FromMillimetres);
  return rays;
}

std::size_t PackedRays::num_bytes() const {
  if (!packed_) return 0;
  const std::size_t of_angles = packed_->angle_rad.use_count() == 1 ? packed_->angle_rad->size() * sizeof(float) : 0;
  return sizeof(Packed) + of_angles + packed_->has_range.size() * sizeof(std::uint64_t) +
         packed_->range_mm.size() * sizeof(std::uint16_t) + packed_->range_m.size() * sizeof(float);
}

}  // namespace crsm
