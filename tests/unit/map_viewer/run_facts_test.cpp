#include "services/map_viewer/run_facts.hpp"

#include <fstream>

#include "catch.hpp"
#include "scratch.hpp"

namespace crsm {
namespace {

nlohmann::json FactsOf(const std::string& summary, std::size_t num_scans = 3) {
  const ScratchFolder folder;
  std::ofstream(folder.path() / "summary.json") << summary;
  return ReadRunFacts(folder.path(), num_scans, "2a");
}

}  // namespace

TEST_CASE("a run that has ended is shown with its verdict, its way and its area") {
  const auto facts = FactsOf(R"({"ended": true, "scans": 3, "path_length_m": 1.5, "explored_area_m2": 2.5,
                                 "verdict": {"trust": "doubtful", "off_x_m": 2, "off_y_m": -1.5, "lines": ["one", 2, "three"]}})");
  CHECK(facts["verdict"]["trust"] == "doubtful");
  CHECK(facts["verdict"]["off_at_m"] == nlohmann::json{2, -1.5});
  CHECK(facts["verdict"]["lines"] == nlohmann::json{"one", "three"});
  CHECK_FALSE(facts["verdict"].contains("doubts"));
  CHECK((facts["way_m"] == 1.5 && facts["area_m2"] == 2.5));
}

TEST_CASE("how far off a map may be is shown along the path, with the drive that would tell, where they are numbers") {
  const auto VerdictOf = [](const std::string& doubts, const std::string& to) {
    return FactsOf(R"({"ended": true, "scans": 3, "verdict": {"trust": "doubtful", "off_m": 2.5, "doubts": )" + doubts +
                   R"(, "way_back": {"from_m": [1, 2], "to_m": )" + to + R"(, "then_off_m": 0.5}}})")["verdict"];
  };
  const auto known = VerdictOf("[[1, 2, 0.5], [3, 4, 2.5]]", "[3, 4]");
  CHECK(known["off_m"] == 2.5);
  CHECK(known["doubts"][1] == nlohmann::json{3, 4, 2.5});
  CHECK(known["way_back"]["to_m"] == nlohmann::json{3, 4});
  for (const char* spoilt : {"7", "[7]", "[[1, 2]]", R"([[1, 2, "x"]])"})
    CHECK_FALSE(VerdictOf(spoilt, "[3, 4]").contains("doubts"));
  for (const char* spoilt : {"7", "[3]", "[3, null]"}) CHECK_FALSE(VerdictOf("[]", spoilt).contains("way_back"));
}

TEST_CASE("no verdict is shown but that of all scans of the run") {
  for (const auto& [summary, why] :
       {std::pair("", "no summary.json"), std::pair("[1]", "no summary.json"), std::pair("{", "no summary.json"),
        std::pair(R"({"ended": false, "scans": 3, "verdict": {"trust": "good"}})", "has not ended"),
        std::pair(R"({"ended": "yes", "scans": 3, "verdict": {"trust": "good"}})", "has not ended"),
        std::pair(R"({"scans": 3, "verdict": {"trust": "good"}})", "has not ended"),
        std::pair(R"({"ended": true, "scans": 4, "verdict": {"trust": "good"}})", "another number of scans"),
        std::pair(R"({"ended": true, "scans": -3, "verdict": {"trust": "good"}})", "another number of scans"),
        std::pair(R"({"ended": true, "identity": "2b", "scans": 3, "verdict": {"trust": "good"}})", "of another map"),
        std::pair(R"({"ended": true, "scans": 3})", "has none"),
        std::pair(R"({"ended": true, "scans": 3, "verdict": 7})", "has none"),
        std::pair(R"({"ended": true, "scans": 3, "verdict": {"trust": 1}})", "has none")}) {
    CAPTURE(summary);
    const auto facts = FactsOf(summary);
    CHECK(facts["verdict"]["trust"] == "none");
    CHECK(facts["verdict"]["lines"][0].get<std::string>().find(why) != std::string::npos);
  }
}

TEST_CASE("a verdict on the map of the journal is shown, also one of which it is not said whose it is") {
  for (const char* identity : {R"("2a")", "null"}) {
    const auto facts = FactsOf(
        std::string(R"({"ended": true, "scans": 3, "verdict": {"trust": "good"}, "identity": )") + identity + "}");
    CHECK(facts["verdict"]["trust"] == "good");
  }
}

}  // namespace crsm
