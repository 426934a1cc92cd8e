// Slamtec's RPLidars on a serial port: A1, A2, A3 and those that answer the same requests. Source: SLAMTEC, RPLIDAR
// Interface Protocol and Application Notes.

#include <fmt/format.h>

#include <optional>

#include "services/sources/devices/laser_device.hpp"
#include "services/sources/devices/rplidar_samples.hpp"

namespace crsm {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr std::string_view kStop{"\xA5\x25", 2};
constexpr std::string_view kScan{"\xA5\x20", 2};
constexpr std::string_view kGetInfo{"\xA5\x50", 2};
constexpr std::string_view kGetHealth{"\xA5\x52", 2};
constexpr std::string_view kGetSampleRate{"\xA5\x59", 2};
// Descriptors of what is answered: two start bytes, the size of an answer and whether many come, its type.
constexpr std::string_view kScanDescriptor{"\xA5\x5A\x05\x00\x00\x40\x81", 7};
constexpr std::string_view kInfoDescriptor{"\xA5\x5A\x14\x00\x00\x00\x04", 7};
constexpr std::string_view kHealthDescriptor{"\xA5\x5A\x03\x00\x00\x00\x06", 7};
constexpr std::string_view kSampleRateDescriptor{"\xA5\x5A\x04\x00\x00\x00\x15", 7};

/// Speed of the motor of an A2 and later (MOTOR_PWM): a duty cycle of 0 to 1023, behind it the exclusive or of all.
std::string MotorRequest(int duty) {
  std::string request{"\xA5\xF0\x02", 3};
  request += static_cast<char>(duty & 0xff);
  request += static_cast<char>(duty >> 8);
  char checksum = 0;
  for (const char byte : request) checksum = static_cast<char>(checksum ^ byte);
  return request + checksum;
}

unsigned Word(std::string_view bytes, std::size_t at) {
  return static_cast<unsigned char>(bytes[at]) | static_cast<unsigned>(static_cast<unsigned char>(bytes[at + 1])) << 8;
}

class Rplidar : public LaserDevice {
 public:
  explicit Rplidar(DeviceReport& report) : report_(report) {}

  std::string Start(Connection& connection) override {
    StopStreaming(connection);
    const auto info = Ask(connection, kGetInfo, kInfoDescriptor, 20);
    if (!info) RefuseSilence();
    const auto health = Ask(connection, kGetHealth, kHealthDescriptor, 3);
    if (!health) throw NoAnswer("sends garbled answers: is its cable good?");
    CheckHealth(*health);
    const auto rate = Ask(connection, kGetSampleRate, kSampleRateDescriptor, 4);
    const int sample_us = rate && Word(*rate, 0) > 0 ? static_cast<int>(Word(*rate, 0)) : kUsualSample_us;
    const unsigned model = static_cast<unsigned char>((*info)[0]) >> 4;  // the major one: 1 is an A1

    connection.SetDataTerminalReady(false);  // the motor of an A1 turns
    if (model >= 2) connection.Write(MotorRequest(660));
    left_.clear();
    if (!Ask(connection, kScan, kScanDescriptor, 0)) throw NoAnswer("answers, but does not start to scan");
    samples_.emplace(report_, sample_us);
    const unsigned firmware = Word(*info, 1);
    return fmt::format("RPLIDAR of series {}, firmware {}.{}: 360 deg, {:.0f} beams a second", model, firmware >> 8,
                       firmware & 0xff, 1e6 / sample_us);
  }

  void Take(std::string_view bytes, std::vector<DeviceScan>& scans) override {
    if (!left_.empty()) samples_->Take(left_, scans);
    left_.clear();
    samples_->Take(bytes, scans);
  }

  void Stop(Connection& connection) override {
    connection.Write(kStop);
    connection.Write(MotorRequest(0));
    connection.SetDataTerminalReady(true);
  }

 private:
  static constexpr int kUsualSample_us = 500;  // of lasers with a firmware older than 1.17, which do not tell

  /// A killed process may have left it scanning: all that it has sent is thrown away.
  void StopStreaming(Connection& connection) {
    connection.Write(kStop);
    const auto give_up = Clock::now() + milliseconds(300);
    while (Clock::now() < give_up && !connection.Read(milliseconds(30)).empty()) continue;
  }

  /// What is answered to a request, behind its descriptor. What comes behind that is kept in left_.
  std::optional<std::string> Ask(Connection& connection, std::string_view request, std::string_view descriptor,
                                 std::size_t size) {
    constexpr milliseconds kPatience(300);
    connection.Write(request);
    std::string bytes;
    for (const auto give_up = Clock::now() + kPatience; Clock::now() < give_up;) {
      const std::string more = connection.Read(milliseconds(50));
      num_bytes_ += more.size();
      bytes += more;
      const std::size_t found = bytes.find(descriptor);
      if (found == std::string::npos || bytes.size() < found + descriptor.size() + size) continue;
      left_ = bytes.substr(found + descriptor.size() + size);
      return bytes.substr(found + descriptor.size(), size);
    }
    return std::nullopt;
  }

  [[noreturn]] void RefuseSilence() const {
    if (num_bytes_ > 0) {
      throw NoAnswer(
          "sends bytes that no RPLidar sends: is its baud rate right (rplidar:PORT:BAUD), and is it an RPLidar?");
    }
    throw NoAnswer("is silent: does the laser have power, and is its cable plugged in at both ends?");
  }

  /// 0 is good, 1 a warning, 2 an error, in which the laser does not scan.
  void CheckHealth(std::string_view health) {
    const unsigned error = Word(health, 1);
    if (health[0] == 0) return;
    ++report_.counts["error_status"];
    if (health[0] == 1) {
      report_.complaints.push_back(fmt::format("warns of a coming fault, error code {}", error));
      return;
    }
    throw DeviceError(
        fmt::format("has stopped after a fault, error code {}: check by hand that its head turns freely, then unplug "
                    "it and plug it in again",
                    error));
  }

  DeviceReport& report_;
  std::optional<RplidarSamples> samples_;
  std::string left_;  ///< bytes behind the last answer
  std::size_t num_bytes_ = 0;
};

}  // namespace

std::unique_ptr<LaserDevice> MakeRplidar(DeviceReport& report) { return std::make_unique<Rplidar>(report); }

}  // namespace crsm
