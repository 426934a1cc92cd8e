#include "services/sources/missing_source.hpp"

#include <filesystem>

#include "catch.hpp"
#include "services/base/usage_error.hpp"
#include "services/sources/devices/serial_ports.hpp"
#include "services/sources/open_laser_source.hpp"
#include "source_helpers.hpp"

namespace crsm {
namespace {

std::string RefusalOf(const std::string& source) {
  try {
    OpenLaserSource(source, {});
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

/// A folder of drives: "logs/corridor.lcm".
struct Drives {
  Drives() {
    std::filesystem::create_directory(folder / "logs");
    folder.Write("logs/corridor.lcm", "");
    folder.Write("logs/office.bag", "");
  }
  std::string operator/(const std::string& name) const { return (folder / name).string(); }
  ScratchFolder folder;
};

DeviceKind KindOf(const std::string& name) {
  for (const DeviceKind& kind : DeviceKinds()) {
    if (kind.name == name) return kind;
  }
  throw std::invalid_argument(name);
}

}  // namespace

TEST_CASE("a mistyped file is answered with the nearest name in its folder") {
  const Drives drives;
  const auto Check = [](const std::string& typed, const std::string& meant) {
    CHECK(RefusalOf(typed) == "there is no file " + typed + (meant.empty() ? "" : "; did you mean " + meant + "?"));
  };
  Check(drives / "logs/coridor.lcm", drives / "logs/corridor.lcm");
  Check(drives / "logs/office.bga", drives / "logs/office.bag");
  Check(drives / "log/corridor.lcm", drives / "logs/corridor.lcm");
  Check(drives / "log/coridor.lcm", "");  // two mistakes
  Check(drives / "logs/nonesuch", "");
  Check(drives / "nowhere/at/all.lcm", "");
}

TEST_CASE("a mistyped kind of source is answered with the nearest one") {
  CHECK(RefusalOf("rplidr:/dev/ttyUSB0") == "there is no file rplidr:/dev/ttyUSB0; did you mean rplidar:/dev/ttyUSB0?");
  CHECK(RefusalOf("hokyuo:tcp://10.0.0.1").ends_with("; did you mean hokuyo:tcp://10.0.0.1?"));
  CHECK(RefusalOf("sm:demo").ends_with("; did you mean sim:demo?"));
  CHECK(RefusalOf("corridr").ends_with("; did you mean sim:corridor?"));
  CHECK(RefusalOf("corridor").ends_with("; did you mean sim:corridor?"));
  CHECK(RefusalOf("lvie").ends_with("; did you mean live?"));
  CHECK(RefusalOf("rplida").ends_with("; did you mean rplidar?"));
}

TEST_CASE("live is for run_stack alone, and a laser needs its port") {
  CHECK_THROWS_AS(OpenLaserSource("live", {}), UsageError);
  CHECK(RefusalOf("live") == "live: only run_stack maps the scans of another program: run_stack live --out DIR");
  CHECK_THROWS_AS(OpenLaserSource("rplidar", {}), UsageError);
  CHECK(RefusalOf("rplidar").find("rplidar: the port of the laser is missing: give rplidar:/dev/") == 0);
  CHECK(RefusalOf("sick") == "sick: the address of the laser is missing: give sick:tcp://ADDRESS");
  CHECK_THROWS_AS(OpenLaserSource("rplidar:", {}), UsageError);
  CHECK(RefusalOf("rplidar:") == RefusalOf("rplidar"));
  CHECK(RefusalOf("sick:") == RefusalOf("sick"));
}

TEST_CASE("a missing port is answered with those that there are, the first of them in the command") {
  CHECK(DescribeMissingPort(KindOf("hokuyo"), {"/dev/ttyACM0", "/dev/ttyUSB1"}) ==
        "hokuyo: the port of the laser is missing: give hokuyo:/dev/ttyACM0; there are /dev/ttyACM0, /dev/ttyUSB1");
  CHECK(DescribeMissingPort(KindOf("hokuyo"), {}) ==
        "hokuyo: the port of the laser is missing: give hokuyo:/dev/NAME; there is no port of a USB laser at all: does "
        "it have power, and is its cable plugged in?");
}

TEST_CASE("a port without /dev/, or an address without tcp://, is answered with the whole of it") {
  const auto Check = [](const std::string& kind, const std::string& typed, const std::string& end) {
    CAPTURE(kind, typed);
    const std::string refusal = DescribeWrongPort(KindOf(kind), typed, {"/dev/ttyACM0", "/dev/ttyUSB1"});
    CHECK(refusal.starts_with(kind + ':' + typed + ": is n"));
    CHECK(refusal.ends_with(end));
  };
  Check("rplidar", "ttyUSB1",
        "neither rplidar:/dev/NAME nor rplidar:tcp://HOST:PORT; did you mean rplidar:/dev/ttyUSB1?");
  Check("rplidar", "ttyUSB1:115200", "; did you mean rplidar:/dev/ttyUSB1:115200?");
  Check("rplidar", "dev/ttyUSB1", "; did you mean rplidar:/dev/ttyUSB1?");
  Check("rplidar", "ttyusb0", "; did you mean rplidar:/dev/ttyUSB1?");  // which is there
  Check("hokuyo", "ttyS0", "; did you mean hokuyo:/dev/ttyS0?");        // which may come
  Check("hokuyo", "laser", "nor hokuyo:tcp://HOST:PORT; there are /dev/ttyACM0, /dev/ttyUSB1");
  Check("hokuyo", "10.0.0.1", "; did you mean hokuyo:tcp://10.0.0.1?");
  Check("hokuyo", "10.0.0.1:10940", "; did you mean hokuyo:tcp://10.0.0.1:10940?");
  Check("hokuyo", "tcp:/10.0.0.1", "; did you mean hokuyo:tcp://10.0.0.1?");
  Check("sick", "scanner", ": is not sick:tcp://HOST:PORT; did you mean sick:tcp://scanner?");
  Check("sick", "ttyUSB1", ": is not sick:tcp://HOST:PORT");
  Check("sick", "dev/ttyUSB1", ": is not sick:tcp://HOST:PORT");
  Check("sick", "tcp:", "; did you mean sick:tcp://?");
  CHECK(RefusalOf("rplidar:ttyUSB77").find("; did you mean rplidar:/dev/ttyUSB") != std::string::npos);
  CHECK_THROWS_AS(OpenLaserSource("rplidar:ttyUSB77", {}), UsageError);
}

TEST_CASE("serial ports are those of USB, and those that udev names after the laser") {
  const ScratchFolder dev;
  for (const char* name : {"ttyUSB1", "ttyUSB0", "ttyACM0", "ttyS0", "null"}) dev.Write(name, "");
  std::filesystem::create_directories(dev / "serial/by-id");
  dev.Write("serial/by-id/usb-Hokuyo", "");
  CHECK(FindSerialPorts(dev.path()) ==
        std::vector<std::string>{dev / "ttyACM0", dev / "ttyUSB0", dev / "ttyUSB1", dev / "serial/by-id/usb-Hokuyo"});
  CHECK(FindSerialPorts(dev / "nowhere").empty());
}

}  // namespace crsm
