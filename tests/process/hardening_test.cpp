// What the linker and the compiler have put into the programs that are installed, as readelf shows it.

#include "catch.hpp"
#include "processes.hpp"

using namespace crsm;

#ifdef CRSM_HARDENED

namespace {

const std::vector<std::string> kPrograms{"laser_publisher", "ray_selector", "rrhc_matcher", "map_updater",
                                         "loop_closer",     "map_exporter", "slam_offline", "slam_eval"};

/// What readelf says of a program.
std::string ReadElf(const std::string& flags, const std::string& path, const TemporaryFolder& folder) {
  const Ended ended = folder.Run("/usr/bin/env", {"readelf", "-W", flags, path});
  REQUIRE(ended.exit_code == 0);
  return ended.output;
}

bool Has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE(
    "every program is hardened: moved in memory, read-only tables, no code on the stack, canaries, checked calls") {
  const TemporaryFolder folder;
  for (const std::string& program : kPrograms) {
    INFO(program);
    const std::string path = std::string(CRSM_BIN_DIR) + "/" + program;
    CHECK(Has(ReadElf("--file-header", path, folder), "DYN"));
    const std::string segments = ReadElf("--segments", path, folder);
    CHECK(Has(segments, "GNU_RELRO"));
    const std::size_t stack = segments.find("GNU_STACK");
    REQUIRE(stack != std::string::npos);
    CHECK_FALSE(Has(segments.substr(stack, segments.find('\n', stack) - stack), "RWE"));
    const std::string dynamic = ReadElf("--dynamic", path, folder);
    CHECK(Has(dynamic, "NOW"));  // with GNU_RELRO: all of it, not only what is bound early
    CHECK(Has(dynamic, "PIE"));
    const std::string symbols = ReadElf("--dyn-syms", path, folder);
    CHECK(Has(symbols, "__stack_chk_fail"));
    CHECK(Has(symbols, "_chk@"));  // memcpy and others, where the compiler knows how much room there is
  }
}

TEST_CASE("what is installed is stripped, and runs") {
  const TemporaryFolder folder;
  const std::string build = std::filesystem::path(CRSM_BIN_DIR).parent_path().string();
  const Ended install = folder.Run("/usr/bin/env", {"cmake", "--install", build, "--prefix", folder / "installed"});
  INFO(install.errors);
  REQUIRE(install.exit_code == 0);
  for (const std::string& program : kPrograms) {
    INFO(program);
    const std::string path = folder / ("installed/bin/" + program);
    const std::string sections = ReadElf("--sections", path, folder);
    CHECK_FALSE(Has(sections, ".symtab"));
    CHECK_FALSE(Has(sections, ".debug_info"));
    CHECK(folder.Run(path, {"--version"}).exit_code == 0);
  }
}

#endif
