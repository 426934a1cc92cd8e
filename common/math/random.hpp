#pragma once

#include <cstdint>

namespace crsm {

/// Random numbers that are the same on every machine: std:: distributions differ between libraries.
/// The generator is SplitMix64 (Steele, Lea and Flood 2014): one addition and a hash a number.
class Random {
 public:
  static constexpr double kMostSigmas = 6.0;

  explicit Random(std::uint64_t seed) : state_(seed) {}

  /// A stream of its own for each (seed, stream), so that a scan's numbers do not depend on the scans before it.
  Random(std::uint64_t seed, std::uint64_t stream) : state_(Hash(seed ^ Hash(stream))) {}

  std::uint64_t Next() { return Hash(state_ += 0x9e3779b97f4a7c15ULL); }

  /// Uniform in [low, high).
  double Uniform(double low, double high) {
    constexpr double kTo53Bits = 1.0 / 9007199254740992.0;
    return low + (high - low) * (static_cast<double>(Next() >> 11) * kTo53Bits);
  }

  /// Normal with mean 0 and standard deviation 1, cut at kMostSigmas: the sum of twelve uniform numbers (Irwin and
  /// Hall), because the logarithm that the exact methods need differs between C libraries.
  double Gaussian() {
    double sum = -kMostSigmas;
    for (int i = 0; i < 12; ++i) sum += Uniform(0.0, 1.0);
    return sum;
  }

 private:
  static std::uint64_t Hash(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
  }

  std::uint64_t state_;
};

}  // namespace crsm
