// Hokuyo's lasers, by SCIP 2.0 on USB, a serial line or TCP: URG-04LX, UTM-30LX, UST-10LX and others.

#include <fmt/format.h>

#include "services/sources/devices/laser_device.hpp"
#include "services/sources/devices/scip.hpp"
#include "services/sources/devices/wrapping_clock.hpp"

namespace crsm {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

/// What is to be done where a laser says that it is broken. A status of 50 to 97 is one of its hardware.
[[noreturn]] void RefuseBroken(const std::string& what) {
  throw DeviceError(
      fmt::format("{}: its motor or its beam has failed: switch its power off for ten seconds; if the error stays, the "
                  "laser needs repair",
                  what));
}

class Hokuyo : public LaserDevice {
 public:
  explicit Hokuyo(DeviceReport& report) : report_(report), reader_(report) {}

  std::string Start(Connection& connection) override {
    // The empty line ends half a command that a killed process may have left.
    connection.Write("\nSCIP2.0\n");
    const auto counts = report_.counts;
    if (!Ask(connection, "QT")) RefuseSilence();
    report_.counts = counts;  // what came until it had stopped is nobody's loss
    const auto version = Ask(connection, "VV");
    const auto specification = Ask(connection, "PP");
    const auto state = Ask(connection, "II");
    if (!version || !specification || !state)
      throw NoAnswer("sends garbled answers: is its cable good, and is its baud rate right?");
    const auto parameters = ParseScipParameters(*specification);
    if (!parameters) throw DeviceError("reports an impossible range or impossible angles (PP)");
    parameters_ = *parameters;
    LetScan(connection, FindScipValue(*state, "STAT"));
    return Describe(FindScipValue(*version, "SERI"));
  }

  void Take(std::string_view bytes, std::vector<DeviceScan>& scans) override {
    for (const ScipReply& reply : reader_.Take(bytes)) {
      if (reply.command != scan_command_) {
        ++report_.counts["garbage"];
      } else if (reply.status == "99") {
        TakeScan(reply, scans);
      } else if (reply.status != "00") {
        TakeStatus(reply.status);
      }
    }
  }

  void Stop(Connection& connection) override { connection.Write("QT\n"); }

 private:
  std::optional<ScipReply> Ask(Connection& connection, const std::string& command) {
    constexpr milliseconds kPatience(400);
    connection.Write(command + '\n');
    for (const auto give_up = Clock::now() + kPatience; Clock::now() < give_up;) {
      const std::string bytes = connection.Read(milliseconds(50));
      num_bytes_ += bytes.size();
      for (const ScipReply& reply : reader_.Take(bytes)) {
        if (reply.command == command) return reply;
      }
    }
    return std::nullopt;
  }

  [[noreturn]] void RefuseSilence() const {
    if (num_bytes_ > 0) {
      throw NoAnswer(
          "sends bytes that no Hokuyo sends: is its baud rate right (hokuyo:PORT:BAUD), and is it a Hokuyo?");
    }
    throw NoAnswer("is silent: does the laser have its own power supply, and is it a Hokuyo?");
  }

  void LetScan(Connection& connection, const std::string& state) {
    const auto beam = Ask(connection, "BM");
    if (beam && beam->status == "01") RefuseBroken(fmt::format("cannot switch its beam on (it says: {})", state));
    // All steps, each for itself, every scan, without end.
    scan_command_ = fmt::format("MD{:04}{:04}01000", parameters_.first_step, parameters_.last_step);
    reader_.ExpectScans(scan_command_);
    connection.Write(scan_command_ + '\n');
  }

  std::string Describe(const std::string& serial) const {
    constexpr double kMm = 1e-3;
    return fmt::format("{}, serial {}: {} beams over {:.0f} deg, {:.2f} to {:.2f} m, {:.3g} scans a second",
                       parameters_.model, serial, parameters_.last_step - parameters_.first_step + 1,
                       360.0 * (parameters_.last_step - parameters_.first_step) / parameters_.steps_per_turn,
                       kMm * parameters_.range_min_mm, kMm * parameters_.range_max_mm,
                       parameters_.turns_per_min / 60.0);
  }

  void TakeScan(const ScipReply& reply, std::vector<DeviceScan>& scans) {
    auto scan = ParseScipScan(reply, parameters_);
    if (!scan) {
      ++report_.counts["bad_scan"];
      return;
    }
    const auto [device_us, restarted] = clock_.Read(scan->device_us);
    scan->device_us = device_us;
    scan->clock_restarted = restarted;
    scans.push_back(std::move(*scan));
  }

  /// Of a laser that is to scan and does not.
  void TakeStatus(const std::string& status) {
    if (status == "98") return;  // it has looked at itself, and goes on
    ++report_.counts["error_status"];
    if (status >= "21" && status <= "49") {
      if (!paused_) report_.complaints.push_back("pauses to check itself for a fault, status " + status);
      paused_ = true;
      return;
    }
    if (status >= "50" && status <= "97") RefuseBroken("reports a hardware fault, status " + status);
    throw DeviceError(fmt::format("does not scan, status {}", status));
  }

  DeviceReport& report_;
  ScipReader reader_;
  ScipParameters parameters_;
  std::string scan_command_;
  WrappingClock clock_{std::int64_t{1000} << 24};
  std::size_t num_bytes_ = 0;
  bool paused_ = false;
};

}  // namespace

std::unique_ptr<LaserDevice> MakeHokuyo(DeviceReport& report) { return std::make_unique<Hokuyo>(report); }

}  // namespace crsm
