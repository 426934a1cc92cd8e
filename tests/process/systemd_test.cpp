// The units in scripts/systemd, as they are installed.

#include <algorithm>
#include <fstream>

#include "catch.hpp"
#include "processes.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kUnits{"crsm-laser-publisher.service",
                                      "crsm-ray-selector.service",
                                      "crsm-rrhc-matcher.service",
                                      "crsm-map-updater.service",
                                      "crsm-loop-closer.service",
                                      "crsm-map-exporter.service",
                                      "crsm_bus.service",
                                      "crsm.target"};

/// What systemd-analyze says about the units in a folder, if its programs are in `programs`.
std::string Verify(const TemporaryFolder& folder, const fs::path& units, const fs::path& programs) {
  std::string script = "cd " + units.string() + " && sed -i 's,^ExecStart=.*/,ExecStart=,; s,^ExecStart=,&" +
                       programs.string() + "/,' crsm-*.service && SYSTEMD_UNIT_PATH=" + units.string() +
                       ": exec systemd-analyze verify --man=no";
  for (const std::string& unit : kUnits) script += " " + unit;
  return folder.Run("/bin/sh", {"-c", script}).errors;
}

/// The value of a key that stands once in a unit; empty if it does not stand there.
std::string ValueOf(const std::string& key, const std::string& unit) {
  std::ifstream file(fs::path(CRSM_SOURCE_DIR "/scripts/systemd") / unit);
  for (std::string line; std::getline(file, line);) {
    if (line.rfind(key + "=", 0) == 0) return line.substr(key.size() + 1);
  }
  return "";
}

}  // namespace

TEST_CASE("what is installed has the programs and units that systemd finds nothing wrong with") {
  const TemporaryFolder folder;
  const fs::path prefix = folder / "usr";
  REQUIRE(folder.Run("/usr/bin/env", {"cmake", "--install", CRSM_BIN_DIR "/..", "--prefix", prefix}).exit_code == 0);
  CHECK(folder.Run(prefix / "bin/map_updater", {"--version"}).exit_code == 0);
  // run_stack finds the other programs beside itself.
  CHECK(folder
            .Run("/usr/bin/env",
                 {"-u", "CRSM_BIN_DIR", prefix / "bin/run_stack", folder.Write(TakeScans("sim:demo", 20), "run.lcm"),
                  "--out", folder / "out", "--lcm-url", MakeBusUrl()})
            .exit_code == 0);
  CHECK(fs::exists(folder / "out/map.png"));
  const fs::path units = prefix / "lib/systemd/system";
  CHECK(fs::exists(units / "crsm-.service.d/common.conf"));
  if (folder.Run("/usr/bin/env", {"systemd-analyze", "--version"}).exit_code != 0) {
    WARN("skipped: systemd-analyze is not installed");
    return;
  }
  CHECK(Verify(folder, units, "/nowhere").find("/nowhere/map_updater is not exec") != std::string::npos);
  const std::string said = Verify(folder, units, prefix / "bin");
  INFO(said);
  CHECK(said.find("crsm") == std::string::npos);
}

TEST_CASE("the units hear and reach this host and multicast, and no other address") {
  const std::string common = "crsm-.service.d/common.conf";
  CHECK(ValueOf("IPAddressDeny", common) == "any");
  CHECK(ValueOf("IPAddressAllow", common) == "localhost multicast");
  CHECK(ValueOf("ExecStart", "crsm_bus.service") == "ip route replace 239.255.76.67/32 dev lo src 127.0.0.1");
}

TEST_CASE("the command of each unit starts its service, the updater's without and with a journal") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  for (const std::string service : {"laser_publisher", "ray_selector", "rrhc_matcher", "map_updater", "loop_closer",
                                    "map_exporter", "map_viewer", "map_updater"}) {
    std::string unit = "crsm-" + service + ".service";
    std::replace(unit.begin(), unit.end(), '_', '-');
    const fs::path state = folder / ValueOf("StateDirectory", unit);
    fs::create_directories(state);
    const std::string own_flags = service == "map_viewer" ? " --http 127.0.0.1:0" : "";  // 8765 may be in use
    const std::string start_before = ValueOf("ExecStartPre", unit);
    Process process(
        "/bin/sh",
        {"-ec", "export LCM_DEFAULT_URL='" + url +
                    "' CRSM_FLAGS='--preset sick --channel-prefix robot1/' CRSM_LASER=sick:tcp://127.0.0.1:9; "
                    "export STATE_DIRECTORY=" +
                    state.string() + "; " + start_before + (start_before.empty() ? "" : "; ") +
                    "exec " CRSM_BIN_DIR "/" + ValueOf("ExecStart", unit) + own_flags},
        folder / "log");
    process.AwaitSaid(": ready");
    INFO(service << ": " << process.errors());
    CHECK(process.IsRunning());
    CHECK(process.Interrupt() == 0);
  }
  CHECK(fs::exists(folder / "crsm/journal/journal.lcm"));
  CHECK(fs::exists(folder / "crsm/map/map.png"));
}
