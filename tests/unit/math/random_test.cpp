#include "common/math/random.hpp"

#include <algorithm>
#include <cmath>

#include "catch.hpp"

namespace crsm {

TEST_CASE("the generator gives the published numbers of SplitMix64") {
  Random random(1234567);
  CHECK(random.Next() == 6457827717110365317ULL);
  CHECK(random.Next() == 3203168211198807973ULL);
  CHECK(random.Next() == 9817491932198370423ULL);
  CHECK(random.Next() == 4593380528125082431ULL);
  CHECK(random.Next() == 16408922859458223821ULL);
}

TEST_CASE("uniform numbers fill [low, high) evenly") {
  constexpr int kNumbers = 100000;
  constexpr int kBins = 10;
  Random random(3);
  int bins[kBins] = {};
  for (int i = 0; i < kNumbers; ++i) {
    const double number = random.Uniform(-2.0, 3.0);
    REQUIRE(number >= -2.0);
    REQUIRE(number < 3.0);
    ++bins[static_cast<int>((number + 2.0) / 5.0 * kBins)];
  }
  // Five standard deviations of a binomial count: sqrt(100000 * 0.1 * 0.9) = 95.
  for (const int count : bins) CHECK(std::abs(count - kNumbers / kBins) < 5 * 95);
}

TEST_CASE("a range of no width gives its one number") { CHECK(Random(1).Uniform(0.5, 0.5) == 0.5); }

TEST_CASE("normal numbers have mean 0, deviation 1 and end at 6") {
  constexpr int kNumbers = 100000;
  Random random(4);
  double sum = 0.0;
  double sum_of_squares = 0.0;
  for (int i = 0; i < kNumbers; ++i) {
    const double number = random.Gaussian();
    REQUIRE(std::abs(number) <= 6.0);
    sum += number;
    sum_of_squares += number * number;
  }
  CHECK(sum / kNumbers == Approx(0.0).margin(5.0 / std::sqrt(kNumbers)));
  CHECK(sum_of_squares / kNumbers == Approx(1.0).margin(5.0 * std::sqrt(2.0 / kNumbers)));
}

TEST_CASE("a stream is the same each time, and other streams and seeds give other numbers") {
  Random first(7, 1000);
  Random again(7, 1000);
  Random other_stream(7, 1001);
  Random other_seed(8, 1000);
  for (int i = 0; i < 100; ++i) {
    const auto number = first.Next();
    CHECK(again.Next() == number);
    CHECK(other_stream.Next() != number);
    CHECK(other_seed.Next() != number);
  }
}

}  // namespace crsm
