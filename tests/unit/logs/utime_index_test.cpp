#include "common/logs/utime_index.hpp"

#include <unordered_map>

#include "catch.hpp"
#include "common/math/random.hpp"

namespace crsm {

TEST_CASE("no utime is in an empty index") {
  const UtimeIndex index;
  CHECK(index.size() == 0);
  for (const std::int64_t utime : {-5, 0, 5}) CHECK_FALSE(index.Find(utime));
}

TEST_CASE("each utime is found at its place, whether they rise, fall or are below zero") {
  for (const std::int64_t step : {1000, -1000}) {
    UtimeIndex index;
    for (std::int64_t k = 0; k < 5000; ++k) {
      index.Add(step * (k - 2500));
      CHECK(index.Find(step * (k - 2500)) == k);
    }
    for (std::int64_t k = 0; k < 5000; k += 7) CHECK(index.Find(step * (k - 2500)) == k);
    for (const std::int64_t utime : {step / 2, step * 2500, step * -2501}) CHECK_FALSE(index.Find(utime));
    CHECK(index.size() == 5000);
  }
}

TEST_CASE("an index knows what a list in memory knows, over a hundred thousand utimes that step back now and then") {
  UtimeIndex index;
  std::unordered_map<std::int64_t, std::int64_t> known;
  Random random(1);
  std::int64_t utime = 976052857337530;
  int num_wrong = 0;
  for (std::int64_t k = 0; k < 100000; ++k) {
    utime += static_cast<std::int64_t>(random.Uniform(0.0, 1.0) < 0.05 ? random.Uniform(-9e5, 0.0)
                                                                       : random.Uniform(0.0, 2e5));
    const auto before = known.find(utime);
    const auto found = index.Find(utime);
    num_wrong += found.has_value() != (before != known.end());
    if (found) continue;
    index.Add(utime);
    known.emplace(utime, index.size() - 1);
  }
  for (const auto& [some_utime, place] : known) {
    if (place % 50 == 0) num_wrong += index.Find(some_utime) != place;
  }
  CHECK(num_wrong == 0);
}

}  // namespace crsm
