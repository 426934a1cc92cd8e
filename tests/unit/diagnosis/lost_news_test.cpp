#include "services/diagnosis/lost_news.hpp"

#include "catch.hpp"

namespace crsm {
namespace {

using Said = std::vector<std::string>;

/// What is said of scans every 0.1 s, one letter each: 'l' of a lost one, 'b' of one without rays. From t = 100 s on.
Said ListNews(const std::string& states) {
  LostNews news;
  Said said;
  const LineLimit::Clock::time_point now{std::chrono::hours(1)};
  ScanMatch match;
  match.utime = 100'000'000;
  for (const char state : states) {
    match.state = state == 'o' ? MatchState::kOk : MatchState::kLost;
    match.num_critical = state == 'b' ? 0 : 70;
    if (const auto line = news.Add(match, now)) said.push_back(*line);
    match.utime += 100'000;
  }
  return said;
}

std::string Lost(int num) { return std::string(static_cast<std::size_t>(num), 'l'); }

}  // namespace

TEST_CASE("a robot that is lost is said after ten scans, each time that their number doubles, and when it is found") {
  CHECK(ListNews("ooo" + Lost(50) + "ooo") ==
        Said{"the robot is lost: 10 lost scans since t = 100.300 s, which are not in the map",
             "the robot is lost: 20 lost scans since t = 100.300 s, which are not in the map",
             "the robot is lost: 40 lost scans since t = 100.300 s, which are not in the map",
             "the robot is found again after 50 lost scans"});
}

TEST_CASE("scans without rays are told apart from lost ones") {
  CHECK(ListNews("o" + Lost(6) + "bbbbo") ==
        Said{"the robot is lost: 6 lost scans and 4 without rays since t = 100.100 s, which are not in the map",
             "the robot is found again after 6 lost scans and 4 without rays"});
  CHECK(ListNews("obbbbbbbbbb") ==
        Said{"the robot is lost: 10 scans without rays since t = 100.100 s, which are not in the map"});
}

TEST_CASE("a few lost scans are not said") {
  CHECK(ListNews("").empty());
  CHECK(ListNews("o" + Lost(9) + "o" + Lost(9) + "o").empty());
}

TEST_CASE("a robot that is lost again is said again, but hundreds of times do not flood the terminal") {
  CHECK(ListNews(Lost(10) + "o" + Lost(10) + "o").size() == 4);
  std::string states;
  for (int i = 0; i < 200; ++i) states += Lost(10) + "o";
  CHECK(ListNews(states).size() == 10);
}

}  // namespace crsm
