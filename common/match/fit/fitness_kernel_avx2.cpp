#include "common/match/fit/fitness_kernel.hpp"

#ifdef __x86_64__

#include <immintrin.h>

#include <algorithm>

namespace crsm {
namespace {

#define CRSM_AVX2 __attribute__((target("avx2"), always_inline))

/// Products of eight scores and weights, summed in pairs to 64 bits.
CRSM_AVX2 inline __m256i Weigh(__m256i scores, __m256i weights) {
  return _mm256_add_epi64(_mm256_mul_epi32(scores, weights),
                          _mm256_mul_epi32(_mm256_srli_epi64(scores, 32), _mm256_srli_epi64(weights, 32)));
}

constexpr int kLanes = 8;
constexpr int kBlock = 96;  // rays whose places are computed before the first score is fetched

/// What is the same for all rays, once in each lane. tile_bits: a tile is 2^tile_bits units of the task.
struct Lanes {
  CRSM_AVX2 Lanes(const FitnessTask& task, unsigned tile_bits)
      : sin(_mm256_set1_ps(task.sin)),
        cos(_mm256_set1_ps(task.cos)),
        offset_x(_mm256_set1_ps(task.offset_x)),
        offset_y(_mm256_set1_ps(task.offset_y)),
        corner_x(_mm256_set1_epi32(task.corner_x)),
        corner_y(_mm256_set1_epi32(task.corner_y)),
        end_x(_mm256_set1_epi32(static_cast<int>(task.tiles.width << tile_bits))),
        end_y(_mm256_set1_epi32(static_cast<int>(task.tiles.height << tile_bits))),
        pairs_in_tile_row(_mm256_set1_epi32(static_cast<int>((task.tiles.width + 1) * kPairsInTile))),
        fraction_mask(_mm256_set1_epi32(task.fraction_mask)) {}

  /// FindPair of eight rays: where their pairs lie among all. x, y: of the cells.
  CRSM_AVX2 __m256i FindPairs(__m256i x, __m256i y) const {
    const __m256i cell_mask = _mm256_set1_epi32(kTileMask);
    const __m256i pairs_in_tile_and_row = _mm256_set1_epi32(kPairsInTile << 16 | kPairsInRow);  // of 16 bits each
    const __m256i tile_row = _mm256_mullo_epi32(_mm256_srli_epi32(y, kTileBits), pairs_in_tile_row);
    const __m256i tile_x = _mm256_srli_epi32(x, kTileBits);
    const __m256i tile_and_row = _mm256_madd_epi16(
        _mm256_or_si256(_mm256_slli_epi32(tile_x, 16), _mm256_and_si256(y, cell_mask)), pairs_in_tile_and_row);
    return _mm256_add_epi32(_mm256_add_epi32(tile_row, tile_and_row), _mm256_and_si256(x, cell_mask));
  }

  __m256 sin, cos, offset_x, offset_y;
  __m256i corner_x, corner_y, end_x, end_y, pairs_in_tile_row, fraction_mask;
};

/// Eight rays, seen from the pose.
struct Turned {
  CRSM_AVX2 Turned(const Lanes& lanes, __m256 ray_x, __m256 ray_y)
      : arm_x(_mm256_sub_ps(_mm256_mul_ps(lanes.cos, ray_x), _mm256_mul_ps(lanes.sin, ray_y))),
        arm_y(_mm256_add_ps(_mm256_mul_ps(lanes.sin, ray_x), _mm256_mul_ps(lanes.cos, ray_y))),
        at_x(_mm256_add_ps(arm_x, lanes.offset_x)),
        at_y(_mm256_add_ps(arm_y, lanes.offset_y)),
        whole_x(_mm256_floor_ps(at_x)),
        whole_y(_mm256_floor_ps(at_y)),
        x(_mm256_min_epu32(_mm256_add_epi32(lanes.corner_x, _mm256_cvttps_epi32(whole_x)), lanes.end_x)),
        y(_mm256_min_epu32(_mm256_add_epi32(lanes.corner_y, _mm256_cvttps_epi32(whole_y)), lanes.end_y)) {}

  __m256 arm_x, arm_y;  ///< from the laser
  __m256 at_x, at_y;    ///< from the corner of its cell
  __m256 whole_x, whole_y;
  __m256i x, y;  ///< in the rectangle; whole units
};

/// Where the rays of a block end.
struct Block {
  alignas(32) std::uint32_t pair[kBlock];  // of a score and the one above it
  alignas(32) std::int32_t right[kBlock];  // of the pair [1/128 cell]
  alignas(32) std::int32_t up[kBlock];
};

/// Line 5 of section 5.2 for eight rays, from the i-th of the block on.
CRSM_AVX2 inline void Place(const Lanes& lanes, __m256 ray_x, __m256 ray_y, int i, Block& block) {
  const Turned turned(lanes, ray_x, ray_y);
  const auto Store = [i](auto* to, __m256i value)
                         CRSM_AVX2 { _mm256_store_si256(reinterpret_cast<__m256i*>(to + i), value); };
  Store(block.pair,
        lanes.FindPairs(_mm256_srli_epi32(turned.x, kFractionBits), _mm256_srli_epi32(turned.y, kFractionBits)));
  Store(block.right, _mm256_and_si256(turned.x, lanes.fraction_mask));
  Store(block.up, _mm256_and_si256(turned.y, lanes.fraction_mask));
}

/// What eight rays of a block score, from the i-th on, times kFractions^2. Scores are fetched one by one, which is
/// faster than to gather them.
CRSM_AVX2 inline __m256i ScoreBilinear(const ScorePair* pairs, const Block& block, int i) {
  const auto Fetch = [&](int ray) { return pairs + block.pair[i + ray]; };
  const auto FetchTwo = [&](int ray) CRSM_AVX2 {
    const __m128i first = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(Fetch(ray)));
    return _mm_loadh_pi(_mm_castsi128_ps(first), reinterpret_cast<const __m64*>(Fetch(ray + 1)));
  };
  const __m256 rays_0145 = _mm256_insertf128_ps(_mm256_castps128_ps256(FetchTwo(0)), FetchTwo(4), 1);
  const __m256 rays_2367 = _mm256_insertf128_ps(_mm256_castps128_ps256(FetchTwo(2)), FetchTwo(6), 1);
  const __m256i left_pairs = _mm256_castps_si256(_mm256_shuffle_ps(rays_0145, rays_2367, 0x88));
  const __m256i right_pairs = _mm256_castps_si256(_mm256_shuffle_ps(rays_0145, rays_2367, 0xdd));

  const __m256i one = _mm256_set1_epi32(kFractions);
  const __m256i up = _mm256_load_si256(reinterpret_cast<const __m256i*>(block.up + i));
  const __m256i shares = _mm256_or_si256(_mm256_sub_epi32(one, up), _mm256_slli_epi32(up, 16));
  const __m256i left = _mm256_madd_epi16(left_pairs, shares);
  const __m256i rise = _mm256_sub_epi32(_mm256_madd_epi16(right_pairs, shares), left);
  const __m256i right = _mm256_load_si256(reinterpret_cast<const __m256i*>(block.right + i));
  return _mm256_add_epi32(_mm256_slli_epi32(left, kFractionBits), _mm256_mullo_epi32(rise, right));
}

/// Three pairs side by side of each of eight rays.
struct Columns {
  CRSM_AVX2 Columns(const ScorePair* pairs, const std::uint32_t* rays) {
    const auto FetchTwo = [&](int ray) CRSM_AVX2 {
      const auto Fetch = [&](int i)
                             CRSM_AVX2 { return _mm_loadu_si128(reinterpret_cast<const __m128i*>(pairs + rays[i])); };
      return _mm256_inserti128_si256(_mm256_castsi128_si256(Fetch(ray)), Fetch(ray + 4), 1);
    };
    const __m256i rays_04 = FetchTwo(0);
    const __m256i rays_15 = FetchTwo(1);
    const __m256i rays_26 = FetchTwo(2);
    const __m256i rays_37 = FetchTwo(3);
    const __m256i left_0145 = _mm256_unpacklo_epi32(rays_04, rays_15);  // and the middle ones
    const __m256i left_2367 = _mm256_unpacklo_epi32(rays_26, rays_37);
    left = _mm256_unpacklo_epi64(left_0145, left_2367);
    middle = _mm256_unpackhi_epi64(left_0145, left_2367);
    right = _mm256_unpacklo_epi64(_mm256_unpackhi_epi32(rays_04, rays_15), _mm256_unpackhi_epi32(rays_26, rays_37));
  }

  __m256i left, middle, right;
};

/// Of the `num` rays of a block: which lanes of the last eight hold one.
CRSM_AVX2 inline __m256i InRest(int num) {
  return _mm256_cmpgt_epi32(_mm256_set1_epi32(num % kLanes), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
}

/// Sums what the rays of a block score, weighted.
CRSM_AVX2 inline __m256i SumWeighted(const FitnessTask& task, const Block& block, int begin, int num) {
  const int num_full = num / kLanes * kLanes;
  const int* weight = task.weight + begin;
  __m256i sums = _mm256_setzero_si256();
  for (int i = 0; i < num_full; i += kLanes) {
    const __m256i weights = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(weight + i));
    sums = _mm256_add_epi64(sums, Weigh(ScoreBilinear(task.pairs, block, i), weights));
  }
  if (num_full == num) return sums;
  const __m256i weights = _mm256_maskload_epi32(weight + num_full, InRest(num));
  return _mm256_add_epi64(sums, Weigh(ScoreBilinear(task.pairs, block, num_full), weights));
}

/// The same of rays that count alike: 32 bits a lane hold the scores of a block.
CRSM_AVX2 inline __m256i SumAlike(const FitnessTask& task, const Block& block, int num) {
  static_assert(std::int64_t{kBlock / kLanes} * 2 * kFullScore * kFractions * kFractions < INT32_MAX);
  const int num_full = num / kLanes * kLanes;
  __m256i sums = _mm256_setzero_si256();
  if (num_full < num) sums = _mm256_and_si256(ScoreBilinear(task.pairs, block, num_full), InRest(num));
  for (int i = 0; i < num_full; i += kLanes) sums = _mm256_add_epi32(sums, ScoreBilinear(task.pairs, block, i));
  return _mm256_add_epi64(_mm256_cvtepi32_epi64(_mm256_castsi256_si128(sums)),
                          _mm256_cvtepi32_epi64(_mm256_extracti128_si256(sums, 1)));
}

/// Eight rays at a time. The places of many are computed before the first is fetched, so that the processor need not
/// wait for them.
__attribute__((target("avx2"))) std::int64_t SumBilinear(const FitnessTask& task) {
  const Lanes lanes(task, kFineTileBits);
  Block block;
  __m256i sums = _mm256_setzero_si256();
  for (int begin = 0; begin < task.num_rays; begin += kBlock) {
    const int num = std::min(kBlock, task.num_rays - begin);
    const int num_full = num / kLanes * kLanes;
    const float* ray_x = task.x + begin;
    const float* ray_y = task.y + begin;
    for (int i = 0; i < num_full; i += kLanes) {
      Place(lanes, _mm256_loadu_ps(ray_x + i), _mm256_loadu_ps(ray_y + i), i, block);
    }
    if (num_full < num) {  // what is no ray is placed at the laser, and weighs 0
      const __m256i rest = InRest(num);
      Place(lanes, _mm256_maskload_ps(ray_x + num_full, rest), _mm256_maskload_ps(ray_y + num_full, rest), num_full,
            block);
    }
    sums = _mm256_add_epi64(sums, task.weight ? SumWeighted(task, block, begin, num) : SumAlike(task, block, num));
  }
  const __m128i halves = _mm_add_epi64(_mm256_castsi256_si128(sums), _mm256_extracti128_si256(sums, 1));
  return _mm_extract_epi64(halves, 0) + _mm_extract_epi64(halves, 1);
}

CRSM_AVX2 inline __m256 Here(__m256i pairs) {
  return _mm256_cvtepi32_ps(_mm256_srai_epi32(_mm256_slli_epi32(pairs, 16), 16));
}

CRSM_AVX2 inline __m256 Above(__m256i pairs) { return _mm256_cvtepi32_ps(_mm256_srai_epi32(pairs, 16)); }

/// Quadratic of eight rays.
struct QuadraticAvx2 {
  CRSM_AVX2 QuadraticAvx2(__m256 before, __m256 here, __m256 after, __m256 f) {
    const __m256 half = _mm256_set1_ps(0.5f);
    const __m256 rise = _mm256_sub_ps(here, before);
    bend = _mm256_sub_ps(_mm256_sub_ps(after, here), rise);
    slope = _mm256_add_ps(rise, _mm256_mul_ps(f, bend));
    const __m256 inner = _mm256_add_ps(rise, _mm256_mul_ps(_mm256_mul_ps(half, f), bend));
    value = _mm256_add_ps(_mm256_mul_ps(half, _mm256_add_ps(before, here)), _mm256_mul_ps(f, inner));
  }

  __m256 value, slope, bend;
};

__attribute__((target("avx2"))) SplineSums SumSpline(const FitnessTask& task) {
  const Lanes lanes(task, kTileBits);
  __m256 sums[kSplineSums];
  for (__m256& sum : sums) sum = _mm256_setzero_ps();
  for (int i = 0; i < task.num_rays; i += kLanes) {
    const bool is_full = i + kLanes <= task.num_rays;
    const __m256i is_ray = is_full ? _mm256_set1_epi32(-1) : InRest(task.num_rays);  // what is none weighs 0
    const Turned turned(lanes, _mm256_maskload_ps(task.x + i, is_ray), _mm256_maskload_ps(task.y + i, is_ray));
    const __m256 right = _mm256_sub_ps(turned.at_x, turned.whole_x);
    const __m256 up = _mm256_sub_ps(turned.at_y, turned.whole_y);
    alignas(32) std::uint32_t pair[kLanes];
    _mm256_store_si256(reinterpret_cast<__m256i*>(pair), lanes.FindPairs(turned.x, turned.y));
    const Columns low(task.pairs, pair);
    const Columns high(task.pairs + kPairsInRow, pair);
    const QuadraticAvx2 left(Here(low.left), Above(low.left), Above(high.left), up);
    const QuadraticAvx2 middle(Here(low.middle), Above(low.middle), Above(high.middle), up);
    const QuadraticAvx2 next(Here(low.right), Above(low.right), Above(high.right), up);
    const QuadraticAvx2 of_values(left.value, middle.value, next.value, right);
    const QuadraticAvx2 of_slopes(left.slope, middle.slope, next.slope, right);
    const QuadraticAvx2 of_bends(left.bend, middle.bend, next.bend, right);
    const __m256 s_x = of_values.slope;
    const __m256 s_y = of_slopes.value;
    const __m256 s_xx = of_values.bend;
    const __m256 s_xy = of_slopes.slope;
    const __m256 s_yy = of_bends.value;
    const auto Turn = [&](__m256 by_y, __m256 by_x) CRSM_AVX2 {
      return _mm256_sub_ps(_mm256_mul_ps(by_y, turned.arm_x), _mm256_mul_ps(by_x, turned.arm_y));
    };
    const __m256 x_yaw = Turn(s_xy, s_xx);
    const __m256 y_yaw = Turn(s_yy, s_xy);
    const __m256 radial = _mm256_add_ps(_mm256_mul_ps(s_x, turned.arm_x), _mm256_mul_ps(s_y, turned.arm_y));
    const __m256i weights =
        task.weight ? _mm256_maskload_epi32(task.weight + i, is_ray) : _mm256_srli_epi32(is_ray, 31);
    const __m256 weight = _mm256_cvtepi32_ps(weights);
    const __m256 of_ray[kSplineSums] = {of_values.value,
                                        s_x,
                                        s_y,
                                        Turn(s_y, s_x),
                                        s_xx,
                                        s_xy,
                                        s_yy,
                                        x_yaw,
                                        y_yaw,
                                        _mm256_sub_ps(Turn(y_yaw, x_yaw), radial)};
    for (std::size_t k = 0; k < kSplineSums; ++k) {
      sums[k] = _mm256_add_ps(sums[k], _mm256_mul_ps(weight, of_ray[k]));
    }
  }
  SplineLanes added;
  for (std::size_t k = 0; k < kSplineSums; ++k) _mm256_storeu_ps(added[k].data(), sums[k]);
  return AddLanes(added);
}

}  // namespace

std::optional<FitnessKernel> Avx2FitnessKernel() {
  if (!__builtin_cpu_supports("avx2")) return std::nullopt;
  return FitnessKernel{SumBilinear, SumSpline};
}

}  // namespace crsm

#else

std::optional<crsm::FitnessKernel> crsm::Avx2FitnessKernel() { return std::nullopt; }

#endif
