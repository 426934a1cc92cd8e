#include "common/match/fitness_kernel.hpp"

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

/// What is the same for all rays, once in each lane.
struct Lanes {
  CRSM_AVX2 explicit Lanes(const FitnessTask& task)
      : sin(_mm256_set1_ps(task.sin)),
        cos(_mm256_set1_ps(task.cos)),
        offset_x(_mm256_set1_ps(task.offset_x)),
        offset_y(_mm256_set1_ps(task.offset_y)),
        corner_x(_mm256_set1_epi32(task.corner_x)),
        corner_y(_mm256_set1_epi32(task.corner_y)),
        end_x(_mm256_set1_epi32(static_cast<int>(task.tiles.width << kFineTileBits))),
        end_y(_mm256_set1_epi32(static_cast<int>(task.tiles.height << kFineTileBits))),
        pairs_in_tile_row(_mm256_set1_epi32(static_cast<int>((task.tiles.width + 1) * kPairsInTile))),
        fraction_mask(_mm256_set1_epi32(task.fraction_mask)) {}

  __m256 sin, cos, offset_x, offset_y;
  __m256i corner_x, corner_y, end_x, end_y, pairs_in_tile_row, fraction_mask;
};

/// Where the rays of a block end.
struct Block {
  alignas(32) std::uint32_t pair[kBlock];  // of a score and the one above it
  alignas(32) std::int32_t right[kBlock];  // of the pair [1/128 cell]
  alignas(32) std::int32_t up[kBlock];
};

/// Line 5 of section 5.2 for eight rays, from the i-th of the block on.
CRSM_AVX2 inline void Place(const Lanes& lanes, __m256 ray_x, __m256 ray_y, int i, Block& block) {
  const __m256 turned_x = _mm256_sub_ps(_mm256_mul_ps(lanes.cos, ray_x), _mm256_mul_ps(lanes.sin, ray_y));
  const __m256 turned_y = _mm256_add_ps(_mm256_mul_ps(lanes.sin, ray_x), _mm256_mul_ps(lanes.cos, ray_y));
  const __m256 whole_x = _mm256_floor_ps(_mm256_add_ps(turned_x, lanes.offset_x));
  const __m256 whole_y = _mm256_floor_ps(_mm256_add_ps(turned_y, lanes.offset_y));
  const __m256i x = _mm256_min_epu32(_mm256_add_epi32(lanes.corner_x, _mm256_cvttps_epi32(whole_x)), lanes.end_x);
  const __m256i y = _mm256_min_epu32(_mm256_add_epi32(lanes.corner_y, _mm256_cvttps_epi32(whole_y)), lanes.end_y);

  const __m256i cell_mask = _mm256_set1_epi32(kTileMask);
  const __m256i pairs_in_tile_and_row = _mm256_set1_epi32(kPairsInTile << 16 | kPairsInRow);  // of 16 bits each
  const __m256i tile_row = _mm256_mullo_epi32(_mm256_srli_epi32(y, kFineTileBits), lanes.pairs_in_tile_row);
  const __m256i tile_x = _mm256_srli_epi32(x, kFineTileBits);
  const __m256i cell_x = _mm256_and_si256(_mm256_srli_epi32(x, kFractionBits), cell_mask);
  const __m256i cell_y = _mm256_and_si256(_mm256_srli_epi32(y, kFractionBits), cell_mask);
  const __m256i tile_and_row =
      _mm256_madd_epi16(_mm256_or_si256(_mm256_slli_epi32(tile_x, 16), cell_y), pairs_in_tile_and_row);
  const auto Store = [i](auto* to, __m256i value)
                         CRSM_AVX2 { _mm256_store_si256(reinterpret_cast<__m256i*>(to + i), value); };
  Store(block.pair, _mm256_add_epi32(_mm256_add_epi32(tile_row, tile_and_row), cell_x));
  Store(block.right, _mm256_and_si256(x, lanes.fraction_mask));
  Store(block.up, _mm256_and_si256(y, lanes.fraction_mask));
}

/// How a kernel reads eight scores of a block, from the i-th on, times kFractions^2. Scores are fetched one by one,
/// which is faster than to gather them.
struct BilinearAvx2 {
  CRSM_AVX2 static __m256i Score(const ScorePair* pairs, const Block& block, int i) {
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
};

/// Without its last bits, rounded.
template <int bits>
CRSM_AVX2 inline __m256i RoundedShift(__m256i values) {
  return _mm256_srai_epi32(_mm256_add_epi32(values, _mm256_set1_epi32(1 << bits >> 1)), bits);
}

/// SplineWeights of eight points.
struct SplineWeightsAvx2 {
  CRSM_AVX2 explicit SplineWeightsAvx2(const std::int32_t* fractions) {
    const __m256i fraction = _mm256_load_si256(reinterpret_cast<const __m256i*>(fractions));
    before = HalfSquare(_mm256_sub_epi32(_mm256_set1_epi32(kFractions), fraction));
    after = HalfSquare(fraction);
    here = _mm256_sub_epi32(_mm256_set1_epi32(kSplineUnit), _mm256_add_epi32(before, after));
  }

  CRSM_AVX2 static __m256i HalfSquare(__m256i value) {
    return RoundedShift<kSplineSquareShift>(_mm256_madd_epi16(value, value));
  }

  __m256i before, after, here;
};

struct SplineAvx2 {
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

  CRSM_AVX2 static __m256i Score(const ScorePair* pairs, const Block& block, int i) {
    const Columns low(pairs, block.pair + i);
    const Columns high(pairs + kPairsInRow, block.pair + i);
    const SplineWeightsAvx2 x(block.right + i);
    const SplineWeightsAvx2 y(block.up + i);
    const __m256i low_shares = _mm256_or_si256(y.before, _mm256_slli_epi32(y.here, 16));
    const __m256i high_shares = _mm256_slli_epi32(y.after, 16);
    const auto Weighed = [&](__m256i low_pairs, __m256i high_pairs, __m256i share) CRSM_AVX2 {
      const __m256i column =
          _mm256_add_epi32(_mm256_madd_epi16(low_pairs, low_shares), _mm256_madd_epi16(high_pairs, high_shares));
      return _mm256_mullo_epi32(RoundedShift<kSplineColumnShift>(column), share);
    };
    const __m256i left = Weighed(low.left, high.left, x.before);
    const __m256i middle = Weighed(low.middle, high.middle, x.here);
    const __m256i right = Weighed(low.right, high.right, x.after);
    return RoundedShift<kSplineSumShift>(_mm256_add_epi32(_mm256_add_epi32(left, middle), right));
  }
};

/// Of the `num` rays of a block: which lanes of the last eight hold one.
CRSM_AVX2 inline __m256i InRest(int num) {
  return _mm256_cmpgt_epi32(_mm256_set1_epi32(num % kLanes), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
}

/// Sums what the rays of a block score, weighted.
template <class Between>
CRSM_AVX2 inline __m256i SumWeighted(const FitnessTask& task, const Block& block, int begin, int num) {
  const int num_full = num / kLanes * kLanes;
  const int* weight = task.weight + begin;
  __m256i sums = _mm256_setzero_si256();
  for (int i = 0; i < num_full; i += kLanes) {
    const __m256i weights = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(weight + i));
    sums = _mm256_add_epi64(sums, Weigh(Between::Score(task.pairs, block, i), weights));
  }
  if (num_full == num) return sums;
  const __m256i weights = _mm256_maskload_epi32(weight + num_full, InRest(num));
  return _mm256_add_epi64(sums, Weigh(Between::Score(task.pairs, block, num_full), weights));
}

/// The same of rays that count alike: 32 bits a lane hold the scores of a block.
template <class Between>
CRSM_AVX2 inline __m256i SumAlike(const FitnessTask& task, const Block& block, int num) {
  static_assert(std::int64_t{kBlock / kLanes} * 2 * kFullScore * kFractions * kFractions < INT32_MAX);
  const int num_full = num / kLanes * kLanes;
  __m256i sums = _mm256_setzero_si256();
  if (num_full < num) sums = _mm256_and_si256(Between::Score(task.pairs, block, num_full), InRest(num));
  for (int i = 0; i < num_full; i += kLanes) sums = _mm256_add_epi32(sums, Between::Score(task.pairs, block, i));
  return _mm256_add_epi64(_mm256_cvtepi32_epi64(_mm256_castsi256_si128(sums)),
                          _mm256_cvtepi32_epi64(_mm256_extracti128_si256(sums, 1)));
}

/// Eight rays at a time. The places of many are computed before the first is fetched, so that the processor need not
/// wait for them.
template <class Between>
CRSM_AVX2 inline std::int64_t SumScores(const FitnessTask& task) {
  const Lanes lanes(task);
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
    sums = _mm256_add_epi64(
        sums, task.weight ? SumWeighted<Between>(task, block, begin, num) : SumAlike<Between>(task, block, num));
  }
  const __m128i halves = _mm_add_epi64(_mm256_castsi256_si128(sums), _mm256_extracti128_si256(sums, 1));
  return _mm_extract_epi64(halves, 0) + _mm_extract_epi64(halves, 1);
}

__attribute__((target("avx2"))) std::int64_t SumBilinear(const FitnessTask& task) {
  return SumScores<BilinearAvx2>(task);
}
__attribute__((target("avx2"))) std::int64_t SumSpline(const FitnessTask& task) { return SumScores<SplineAvx2>(task); }

}  // namespace

std::optional<FitnessKernel> Avx2FitnessKernel() {
  if (!__builtin_cpu_supports("avx2")) return std::nullopt;
  return FitnessKernel{SumBilinear, SumSpline};
}

}  // namespace crsm

#else

std::optional<crsm::FitnessKernel> crsm::Avx2FitnessKernel() { return std::nullopt; }

#endif
