#include "services/journal/map_parameters.hpp"

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
            {ParameterGroup::kScan, ParameterGroup::kMatch, ParameterGroup::kUpdate, ParameterGroup::kAlgorithm}, {}) {
    std::vector<const char*> argv{"test"};
    for (const std::string& flag : flags) argv.push_back(flag.c_str());
    REQUIRE_FALSE(command_line.Parse(static_cast<int>(argv.size()), argv.data()));
  }
  CommandLine command_line;
};

std::string ValueOf(const ParameterTexts& texts, const std::string& key) {
  for (const auto& [name, value] : texts) {
    if (name == key) return value;
  }
  return "";
}

/// A folder with the journal of a map that was made with these flags.
class MadeWith {
 public:
  explicit MadeWith(const std::vector<std::string>& flags)
      : folder(fs::temp_directory_path() / ("crsm_map_parameters_" + std::to_string(getpid()))) {
    fs::remove_all(folder);
    Journal journal(folder, {false, ListMapParameters(Called(flags).command_line.parameters())});
    journal.Append(nullptr, {1, {}, 0.0, 0, 1, 0, MatchState::kFirst});
  }
  ~MadeWith() { fs::remove_all(folder); }
  const fs::path folder;
};

}  // namespace

TEST_CASE(
    "the parameters of a map are those of the laser and of drawing, as flags say them, and not those of a search") {
  const auto texts =
      ListMapParameters(Called({"--range-max-m", "81.9", "--algorithm", "paper"}).command_line.parameters());
  CHECK(ValueOf(texts, "range_max_m") == "81.9");
  CHECK(ValueOf(texts, "angle_scale") == "1");
  CHECK(ValueOf(texts, "algorithm") == "paper");
  CHECK(ValueOf(texts, "cell_size_m") == "0.05");
  CHECK(ValueOf(texts, "smooth_climb").empty());
  CHECK(ValueOf(texts, "rays_max").empty());
  CHECK(ValueOf(texts, "seed").empty());
}

TEST_CASE("the parameters of a map are taken over, to the last bit, where nobody says anything else") {
  const std::vector<std::string> flags{"--range-max-m", "81.9",  "--update-distance-m", "0.1000000000000001",
                                       "--algorithm",   "paper", "--cell-size-m",       "0.02"};
  const MadeWith map(flags);
  for (std::vector<std::string> said : {std::vector<std::string>{}, {"--range-max-m", "81.90"}, {"--smooth-climb"}}) {
    Called called(said);
    AdoptMapParameters(map.folder, called.command_line);
    CHECK(ListMapParameters(called.command_line.parameters()) ==
          ListMapParameters(Called(flags).command_line.parameters()));
  }
  Called called({"--smooth-climb"});
  AdoptMapParameters(map.folder, called.command_line);
  CHECK(called.command_line.parameters().match.smooth_climb);
}

TEST_CASE("another value is refused by the name of who said it, also where it is the default") {
  const MadeWith map({"--range-max-m", "81.9", "--algorithm", "paper"});
  const auto Refused = [&](const std::vector<std::string>& flags) {
    Called called(flags);
    return ErrorOf([&] { AdoptMapParameters(map.folder, called.command_line); });
  };
  const std::string was = ": the map of " + map.folder.string() + " was made with ";
  CHECK(Refused({"--range-max-m", "40"}) ==
        "--range-max-m 40" + was + "81.9; remove this setting, or set --range-max-m 81.9");
  CHECK(Refused({"--range-max-m", "30"}).find("--range-max-m 30" + was + "81.9") == 0);
  CHECK(Refused({"--algorithm", "crsm"}).find("--algorithm crsm" + was + "paper") == 0);
  CHECK(Refused({"--preset", "urg-04lx"}).find("urg-04lx:") == 0);
  CHECK(Refused({"--profile", "paper"}).find("paper:") == 0);
  const ScratchFile config("seed = 3\nrange_max_m = 40\n");
  CHECK(Refused({"--config", config.path()}).find(config.path() + ":2: range_max_m = 40" + was + "81.9") == 0);
  CHECK(Refused({"--config", config.path(), "--range-max-m", "81.9"}).empty());  // the flag has the last word
}

TEST_CASE("a parameter that this version does not know is refused, and one that the map's did not is left as it is") {
  Called called({"--smooth-climb"});
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
  CHECK(Refused({}) == "the map of " + map.folder.string() +
                           " was made with --range-max-m 81.9 --angle-scale 0.997: give test and ray_selector the same "
                           "flags, or the --preset of its first run");
  CHECK(Refused({"--range-max-m", "81.9"}).find("made with --angle-scale 0.997: give") != std::string::npos);
  CHECK(Refused({"--range-max-m", "81.9", "--angle-scale", "0.997"}).empty());
}

}  // namespace crsm
