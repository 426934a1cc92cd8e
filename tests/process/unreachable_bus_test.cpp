// A machine without a route for multicast and a server that is not there: each is said as what it is, and the mend
// works.

#include <unistd.h>

#include <cstdio>

#include "catch.hpp"
#include "processes.hpp"

using namespace crsm;

namespace {

const std::string kMend = "ip link set lo up multicast on; ip route add 224.0.0.0/4 dev lo";

/// The words that run a shell's command in a network of its own, without any route and with its loopback down.
std::vector<std::string> Isolated(const std::string& command) { return {"unshare", "-rn", "sh", "-c", command}; }

/// Whether this user may make a network, and has the tool to set it up.
bool MayIsolate(const TemporaryFolder& folder) {
  if (folder.Run("/usr/bin/env", Isolated("command -v ip")).exit_code == 0) return true;
  std::printf("  skipped: no network namespaces here (unshare -rn, ip)\n");
  return false;
}

const std::string kSelector = std::string(CRSM_BIN_DIR) + "/ray_selector --lcm-url udpm://239.255.76.67:7667?ttl=0";

}  // namespace

TEST_CASE("without a route for multicast every service says so, and how to get one") {
  const TemporaryFolder folder;
  if (!MayIsolate(folder)) return;
  for (const std::string service :
       {"ray_selector", "rrhc_matcher", "map_updater", "loop_closer", "map_exporter", "laser_publisher"}) {
    const std::string arguments = service == "map_exporter"      ? " --out " + (folder / "out").string()
                                  : service == "laser_publisher" ? " sim:demo"
                                                                 : "";
    const auto [exit_code, output, said] =
        folder.Run("/usr/bin/env", Isolated(CRSM_BIN_DIR "/" + service + arguments + " --lcm-url udpm://"));
    INFO(said);
    CHECK(exit_code == 1);
    CHECK(said.find(service + ": --lcm-url udpm://") != std::string::npos);
    CHECK(said.find(": no multicast route for LCM; as root: " + kMend + "\n") != std::string::npos);
    CHECK(said.find("server") == std::string::npos);
    CHECK(CountLines(said) == 1);  // LCM itself would take ten
  }
}

TEST_CASE("without a route for multicast run_stack says so once, and starts nothing") {
  const TemporaryFolder folder;
  if (!MayIsolate(folder)) return;
  const std::string out = folder / "out";
  const Ended ended = folder.Run("/usr/bin/env", Isolated(CRSM_BIN_DIR "/run_stack sim:demo --out " + out +
                                                          " --lcm-url udpm://239.255.76.67:7667?ttl=0"));
  INFO(ended.errors);
  CHECK(ended.exit_code == 1);
  CHECK(CountLines(ended.errors) == 1);
  CHECK(ended.errors.find("run_stack: --lcm-url udpm://239.255.76.67:7667") == 0);
  CHECK(ended.errors.find(": no multicast route for LCM; as root: " + kMend + "\n") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(out));
}

TEST_CASE("the mend that is named for a missing route is one") {
  const TemporaryFolder folder;
  if (!MayIsolate(folder)) return;
  Process process("/usr/bin/env", Isolated(kMend + "; exec " + kSelector), folder / "log");
  CHECK(process.AwaitSaid("ray_selector: ready\n"));
}

TEST_CASE("a server that is not there is asked for by its address") {
  const TemporaryFolder folder;
  const Ended ended = folder.Run("ray_selector", {"--lcm-url", "tcpq://localhost:1"});  // LCM says something, too
  INFO(ended.errors);
  CHECK(ended.exit_code == 1);
  CHECK(ended.errors.find("ray_selector: --lcm-url tcpq://localhost:1: no LCM server answers there") !=
        std::string::npos);
}
