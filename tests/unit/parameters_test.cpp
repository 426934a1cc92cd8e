#include "common/parameters.hpp"

#include <set>

#include "catch.hpp"

namespace crsm {
namespace {

/// Counts what is wrong with the list: a default outside its range, a choice without a name, a key without help.
struct Checker {
  int num_wrong = 0;
  std::vector<std::string> keys;

  void See(const ParameterInfo& info) {
    keys.emplace_back(info.key);
    num_wrong += std::string(info.help).empty();
    num_wrong += keys.back().find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") != std::string::npos;
  }
  template <class Number>
  void operator()(const ParameterInfo& info, Number& value, Number low, Number high) {
    See(info);
    num_wrong += !(low < high && value >= low && value <= high);
  }
  void operator()(const ParameterInfo& info, bool&) { See(info); }
  template <class Enum, std::size_t N>
  void operator()(const ParameterInfo& info, Enum& value, const std::array<std::string_view, N>&) {
    See(info);
    num_wrong += static_cast<std::size_t>(value) >= N;
  }
};

}  // namespace

TEST_CASE("every default is within its range and every key is snake_case with a line of help") {
  Parameters parameters;
  Checker checker;
  VisitParameters(parameters, checker);
  CHECK(checker.num_wrong == 0);
}

TEST_CASE("every key stands in the list once") {
  Parameters parameters;
  Checker checker;
  VisitParameters(parameters, checker);
  CHECK(std::set<std::string>(checker.keys.begin(), checker.keys.end()).size() == checker.keys.size());
  const auto list = ListParameters(parameters);
  REQUIRE(list.size() == checker.keys.size());
  for (std::size_t i = 0; i < list.size(); ++i) CHECK(list[i].first == checker.keys[i]);
}

TEST_CASE("the list of some groups has their parameters and no others") {
  using enum ParameterGroup;
  const auto list = ListParameters(Parameters(), {kSeed, kLoops});
  REQUIRE(list.size() == 3);
  CHECK(list[0].first == "seed");
  CHECK(list[1].first == "loops");
  CHECK(list[2].first == "local_map_m");
  CHECK(ListParameters(Parameters(), {}).empty());
  CHECK(ListParameters(Parameters(), {kSeed, kLaser, kScan, kSelection, kUpdate, kLoops, kAlgorithm}) ==
        ListParameters(Parameters()));
}

TEST_CASE("the list gives each value as what it is") {
  Parameters parameters;
  parameters.match.seed = ~std::uint64_t{0};
  parameters.selection.rays_max = 123;
  parameters.loops.loops = false;
  parameters.update.cell_size_m = 0.07;
  parameters.update.algorithm = Algorithm::kPaper;
  const auto list = ListParameters(parameters);
  const auto Value = [&](const std::string& key) {
    for (const auto& [name, value] : list) {
      if (name == key) return value;
    }
    return ParameterValue{std::string("(missing)")};
  };
  CHECK(Value("seed") == ParameterValue{~std::uint64_t{0}});
  CHECK(Value("rays_max") == ParameterValue{std::int64_t{123}});
  CHECK(Value("algorithm") == ParameterValue{std::string("paper")});
  CHECK(Value("loops") == ParameterValue{false});
  CHECK(Value("cell_size_m") == ParameterValue{0.07});
}

}  // namespace crsm
