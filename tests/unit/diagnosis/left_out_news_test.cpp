#include "services/diagnosis/left_out_news.hpp"

#include "catch.hpp"

namespace crsm {
namespace {

using namespace std::chrono_literals;

/// Scans one after the other, and how often it was said that some were left out.
struct Laser {
  LeftOutNews news;
  LeftOutNews::Time now{1h};
  std::vector<std::pair<std::int64_t, std::int64_t>> said;

  void Send(int num_good, int num_bad) {
    for (int i = 0; i < num_good; ++i) news.Take();
    for (int i = 0; i < num_bad; ++i) {
      if (const auto what = news.LeaveOut(now)) said.emplace_back(what->num_left_out, what->num_all);
    }
  }
};

using Said = std::vector<std::pair<std::int64_t, std::int64_t>>;

}  // namespace

TEST_CASE("scans that are left out are said from the third on, also where every second one is good") {
  Laser laser;
  laser.Send(1, 1);
  laser.Send(1, 1);
  CHECK(laser.said.empty());
  laser.Send(1, 1);
  CHECK(laser.said == Said{{3, 6}});
}

TEST_CASE("a handful among many is not said, ten are, and once a minute at most those since the last time") {
  Laser laser;
  laser.Send(2000, 9);
  CHECK(laser.said.empty());
  laser.Send(0, 100);
  CHECK(laser.said == Said{{10, 2010}});
  laser.now += 60s;
  laser.Send(0, 1);
  CHECK(laser.said == Said{{10, 2010}, {100, 100}});
}

}  // namespace crsm
