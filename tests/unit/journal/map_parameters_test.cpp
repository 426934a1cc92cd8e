#include "services/journal/map_parameters.hpp"

#include <map>

#include "catch.hpp"
#include "services/base/usage_error.hpp"
#include "source_helpers.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

/// A program of all parameters, called with these flags.
class Called {
 public:
  explicit Called(const std::vector<std::string>& flags)
      : command_line(
            "test", "",
            {ParameterGroup::kSeed, ParameterGroup::kScan, ParameterGroup::kUpdate, ParameterGroup::kAlgorithm}, {}) {
    std::vector<const char*> argv{"test"};
    for (const std::string& flag : flags) argv.push_back(flag.c_str());
    REQUIRE_FALSE(command_line.Parse(static_cast<int>(argv.size()), argv.data()));
  }
  CommandLine command_line;
};

/// A folder with the journal of a map that was made with these flags.
class MadeWith {
 public:
  explicit MadeWith(const std::vector<std::string>& flags) {
    Journal journal(folder, {false, ListMapParameters(Called(flags).command_line.parameters())});
    journal.Append(nullptr, {1, {}, 0.0, 0, 1, 0, MatchState::kFirst});
  }

 private:
  ScratchFolder scratch_;

 public:
  const fs::path folder = scratch_ / "map";
};

}  // namespace

TEST_CASE(
    "the parameters of a map are those of the laser and of drawing, as flags say them, and not those of a search") {
  const auto texts =
      ListMapParameters(Called({"--range-max-m", "81.9", "--algorithm", "paper"}).command_line.parameters());
  const std::map<std::string, std::string> by_key(texts.begin(), texts.end());
  CHECK(by_key.at("range_max_m") == "81.9");
  CHECK(by_key.at("angle_scale") == "1");
  CHECK(by_key.at("algorithm") == "paper");
  CHECK(by_key.at("cell_size_m") == "0.05");
  for (const char* key : {"rays_max", "seed"}) CHECK_FALSE(by_key.contains(key));
}

TEST_CASE("the parameters of a map are taken over, to the last bit, where nobody says anything else") {
  const std::vector<std::string> flags{"--range-max-m", "81.9",  "--update-distance-m", "0.1000000000000001",
                                       "--algorithm",   "paper", "--cell-size-m",       "0.02"};
  const MadeWith map(flags);
  for (std::vector<std::string> said : {std::vector<std::string>{}, {"--range-max-m", "81.90"}, {"--seed", "3"}}) {
    Called called(said);
    AdoptMapParameters(map.folder, called.command_line);
    CHECK(ListMapParameters(called.command_line.parameters()) ==
          ListMapParameters(Called(flags).command_line.parameters()));
  }
  Called called({"--seed", "3"});
  AdoptMapParameters(map.folder, called.command_line);
  CHECK(called.command_line.parameters().match.seed == 3);
}

TEST_CASE("another value is refused by the name of who said it, also where it is the default") {
  const MadeWith map({"--range-max-m", "81.9", "--algorithm", "paper"});
  const auto Refused = [&](const std::vector<std::string>& flags) {
    Called called(flags);
    return ErrorOf([&] { AdoptMapParameters(map.folder, called.command_line); });
  };
  const ScratchFile config("seed = 3\nrange_max_m = 40\n");
  const std::pair<std::vector<std::string>, std::string> cases[] = {
      {{"--range-max-m", "40"}, "--range-max-m 40: the map of " + map.folder.string() + " was made with 81.9; remove"},
      {{"--range-max-m", "30"}, "--range-max-m 30: "},
      {{"--algorithm", "crsm"}, "--algorithm crsm: "},
      {{"--preset", "urg-04lx"}, "urg-04lx:"},
      {{"--profile", "paper"}, "paper:"},
      {{"--config", config.path()}, config.path() + ":2: range_max_m = 40: "}};
  for (const auto& [flags, error] : cases) CHECK(Refused(flags).starts_with(error));
  CHECK(Refused({"--config", config.path(), "--range-max-m", "81.9"}).empty());  // the flag has the last word
}

TEST_CASE("a parameter that this version does not know is refused, and one that the map's did not is left as it is") {
  Called called({"--seed", "3"});
  const auto Refused = [&](const ParameterTexts& of_map) {
    return ErrorOf([&] { called.command_line.Adopt(of_map, "MAP"); });
  };
  CHECK(Refused({{"nonesuch", "3"}}).find("the map of MAP was made with nonesuch = 3: nonesuch: no such key") == 0);
  CHECK(Refused({{"cell_size_m", "x"}}).find("the map of MAP was made with cell_size_m = x: cell_size_m: 'x'") == 0);
  CHECK(Refused({{"cell_size_m", "0.1"}}).empty());
  CHECK(called.command_line.parameters().update.cell_size_m == 0.1);
  CHECK(called.command_line.parameters().scan.range_max_m == Parameters().scan.range_max_m);
}

TEST_CASE("who hears scans of others must have been told the laser's parameters of the map") {
  const MadeWith map({"--range-max-m", "81.9", "--angle-scale", "0.997", "--cell-size-m", "0.1"});
  const auto Refused = [&](const std::vector<std::string>& flags) {
    return ErrorOf([&] { CheckLaserParameters(map.folder, Called(flags).command_line); });
  };
  CHECK(Refused({}).find("made with --range-max-m 81.9 --angle-scale 0.997: give test and ray_selector the same") !=
        std::string::npos);
  CHECK(Refused({"--range-max-m", "81.9"}).find("made with --angle-scale 0.997: give") != std::string::npos);
  CHECK(Refused({"--range-max-m", "81.9", "--angle-scale", "0.997"}).empty());
}

}  // namespace crsm
