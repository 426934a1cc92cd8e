#include "common/logs/utime_index.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <map>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "source_helpers.hpp"

namespace crsm {
namespace {

constexpr std::int64_t kLargest = std::numeric_limits<std::int64_t>::max();

/// $TMPDIR is another one as long as this lives.
class OtherTmpdir {
 public:
  explicit OtherTmpdir(const char* folder) {
    if (const char* earlier = std::getenv("TMPDIR")) earlier_ = earlier;
    setenv("TMPDIR", folder, 1);
  }
  ~OtherTmpdir() { earlier_.empty() ? unsetenv("TMPDIR") : setenv("TMPDIR", earlier_.c_str(), 1); }

 private:
  std::string earlier_;
};

/// No file can be longer as long as this lives: writing fails, as on a disk that is full.
class ShortFiles {
 public:
  explicit ShortFiles(rlim_t most_bytes) : earlier_handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &earlier_limit_);
    const rlimit limit{most_bytes, earlier_limit_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~ShortFiles() {
    setrlimit(RLIMIT_FSIZE, &earlier_limit_);
    std::signal(SIGXFSZ, earlier_handler_);
  }

 private:
  void (*earlier_handler_)(int);
  rlimit earlier_limit_{};
};

}  // namespace

TEST_CASE("of 100,000 rising utimes each is found as the one that it was, and those between them are not") {
  UtimeIndex index;
  CHECK(index.size() == 0);
  for (const std::int64_t utime : {-kLargest - 1, std::int64_t{0}, kLargest}) CHECK_FALSE(index.Find(utime));
  constexpr std::int64_t kFirst = 976052857000000;
  for (std::int64_t i = 0; i < 100000; ++i) {
    CHECK_FALSE(index.Find(kFirst + 20 * i));
    index.Add(kFirst + 20 * i);
  }
  CHECK(index.size() == 100000);
  for (std::int64_t i = 0; i < 100000; i += 97) {
    CHECK(index.Find(kFirst + 20 * i) == i);
    CHECK_FALSE(index.Find(kFirst + 20 * i + 10));
  }
}

TEST_CASE("utimes are found on both sides of where a block of 1,024 ends") {
  UtimeIndex index;
  for (std::int64_t i = 0; i < 2049; ++i) {
    index.Add(10 * i);
    CHECK(index.size() == i + 1);
    CHECK(index.Find(10 * i) == i);
    if (i > 0) CHECK(index.Find(10 * i - 10) == i - 1);
    CHECK_FALSE(index.Find(10 * i + 10));
  }
}

TEST_CASE("utimes that step back, below zero too, are found as the ones that they were") {
  UtimeIndex index;
  for (std::int64_t i = 0; i < 5000; ++i) {
    const std::int64_t utime = 100 * i - (i % 7 == 3 ? 90'050 : 0);
    CHECK_FALSE(index.Find(utime));
    index.Add(utime);
    CHECK(index.Find(utime) == i);
  }
  index.Add(-kLargest - 1);
  index.Add(kLargest);
  CHECK(index.Find(-kLargest - 1) == 5000);
  CHECK(index.Find(kLargest) == 5001);
}

TEST_CASE("random utimes are found as a map in memory finds them") {
  UtimeIndex index;
  std::map<std::int64_t, std::int64_t> expected;
  std::mt19937_64 random(1);
  for (std::int64_t i = 0; i < 20000; ++i) {
    const auto utime = static_cast<std::int64_t>(random() % 30000) - 15000;
    const auto known = expected.find(utime);
    CHECK(index.Find(utime) == (known == expected.end() ? std::nullopt : std::optional(known->second)));
    const auto next = expected.upper_bound(utime);
    CHECK(index.FindNext(utime) == (next == expected.end() ? kLargest : next->first));
    index.Add(utime);
    expected.emplace(utime, i);
  }
}

TEST_CASE("an index that takes the place of another has forgotten what that one had") {
  UtimeIndex index;
  for (std::int64_t utime = 0; utime < 3000; ++utime) index.Add(utime);
  UtimeIndex moved = std::move(index);
  CHECK(moved.Find(17) == 17);
  moved = UtimeIndex();
  CHECK(moved.size() == 0);
  CHECK_FALSE(moved.Find(17));
}

TEST_CASE("where no temporary file can be made the folder is named, and the way out") {
  const OtherTmpdir tmpdir("/no/such/folder");
  CHECK(ErrorOf([] { UtimeIndex(); }) ==
        "a temporary file in /no/such/folder cannot be made: No such file or directory; TMPDIR names another folder");
}

TEST_CASE("on a full disk all utimes are known all the same, and written when there is room again") {
  UtimeIndex index;
  const auto Fill = [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t utime = from; utime < to; ++utime) index.Add(utime);
    for (std::int64_t utime = 0; utime < to; utime += 7) CHECK(index.Find(utime) == utime);
  };
  {
    const ShortFiles short_files(20000);
    Fill(0, 10000);
  }
  Fill(10000, 20000);
}

TEST_CASE("the temporary file has no name: nothing is left in its folder") {
  const ScratchFolder folder;
  const OtherTmpdir tmpdir(folder.path().c_str());
  UtimeIndex index;
  for (std::int64_t utime = 0; utime < 3000; ++utime) index.Add(utime);
  CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("the last utime up to another one is found wherever utimes step back") {
  UtimeIndex index;
  CHECK_FALSE(index.FindLast(kLargest));
  std::mt19937 random(7);
  std::vector<std::int64_t> all;
  for (std::int64_t i = 0; i < 5000; ++i) {
    all.push_back(1000 + 10 * i + static_cast<std::int64_t>(random() % 3000));
    index.Add(all.back());
  }
  std::ranges::sort(all);
  for (const std::int64_t utime : {std::int64_t{0}, all.front() - 1, all.front(), all[2500], all[2500] + 3, kLargest}) {
    const auto behind = std::ranges::upper_bound(all, utime);
    const auto last = index.FindLast(utime);
    REQUIRE(last.has_value() == (behind != all.begin()));
    if (last) CHECK(*last == *std::prev(behind));
  }
}

}  // namespace crsm
