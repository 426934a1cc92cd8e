// SICK's lasers on TCP that speak CoLa A: LMS1xx, LMS5xx, TiM5xx, TiM7xx and others.

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "services/base/printable.hpp"
#include "services/sources/devices/cola.hpp"
#include "services/sources/devices/laser_device.hpp"
#include "services/sources/devices/wrapping_clock.hpp"

namespace crsm {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

class Sick : public LaserDevice {
 public:
  explicit Sick(DeviceReport& report) : report_(report), reader_(report) {}

  std::string Start(Connection& connection) override {
    const auto counts = report_.counts;
    const auto stopped = Ask(connection, "sEN LMDscandata 0", "sEA LMDscandata");  // a killed process left it sending
    if (!stopped) RefuseSilence();
    report_.counts = counts;
    const auto identity = Ask(connection, "sRN DeviceIdent", "sRA DeviceIdent");
    const auto state = Ask(connection, "sRN SCdevicestate", "sRA SCdevicestate");
    if (state && state->ends_with(" 2")) {
      throw DeviceError("reports an internal error: switch its power off for ten seconds; SOPAS ET shows the error");
    }
    CheckWindow(connection);
    const auto begun = Ask(connection, "sEN LMDscandata 1", "sEA LMDscandata");
    if (!begun || !begun->ends_with(" 1")) throw DeviceError("refuses to send scans (sEN LMDscandata)");
    return identity ? Describe(*identity) : "a laser of unknown type";
  }

  void Take(std::string_view bytes, std::vector<DeviceScan>& scans) override {
    for (DeviceScan& scan : early_) scans.push_back(std::move(scan));
    early_.clear();
    for (const std::string& telegram : reader_.Take(bytes)) TakeTelegram(telegram, scans);
  }

  void Stop(Connection& connection) override { connection.Write(ColaTelegram("sEN LMDscandata 0")); }

 private:
  /// The answer that begins so; nothing if there is none, or if the laser does not know the request.
  std::optional<std::string> Ask(Connection& connection, const std::string& request, const std::string& answer) {
    constexpr milliseconds kPatience(500);
    connection.Write(ColaTelegram(request));
    std::optional<std::string> found;
    for (const auto give_up = Clock::now() + kPatience; Clock::now() < give_up;) {
      const std::string bytes = connection.Read(milliseconds(50));
      num_bytes_ += bytes.size();
      for (std::string& telegram : reader_.Take(bytes)) {
        if (telegram.starts_with(answer)) {
          found = std::move(telegram);
        } else if (telegram.starts_with("sFA")) {
          return std::nullopt;
        } else if (found) {
          TakeTelegram(telegram, early_);  // the first scan came with the answer
        }
      }
      if (found) return found;
    }
    return std::nullopt;
  }

  [[noreturn]] void RefuseSilence() const {
    if (num_bytes_ > 0)
      throw NoAnswer("answers, but not in CoLa A: is it a SICK, and is it set to CoLa A (in SOPAS ET)?");
    throw NoAnswer("accepts the connection, but is silent: it needs half a minute to start; is it set to CoLa A?");
  }

  /// Its answer ends in 0: clean, 1: a warning, 2 and 3: too dirty. Some lasers do not know the question.
  void CheckWindow(Connection& connection) {
    const auto window = Ask(connection, "sRN LCMstate", "sRA LCMstate");
    if (window && window->back() == '1') Complain(kSickDirtyWarning);
    if (window && (window->back() == '2' || window->back() == '3')) Complain(kSickTooDirty);
  }

  /// "sRA DeviceIdent 10 LMS10x_FieldEval 10 V1.36-21.10.2010": each text behind its length, in hexadecimal.
  static std::string Describe(const std::string& identity) {
    const std::string text =
        MakePrintable(identity.substr(std::min(identity.size(), std::string("sRA DeviceIdent ").size())));
    const std::size_t name = text.find(' ');
    return name == std::string::npos ? text : text.substr(name + 1);
  }

  void TakeTelegram(const std::string& telegram, std::vector<DeviceScan>& scans) {
    if (!telegram.starts_with("sSN LMDscandata") && !telegram.starts_with("sRA LMDscandata")) return;
    auto parsed = ParseColaScan(telegram);
    if (!parsed) {
      ++report_.counts["bad_scan"];
      return;
    }
    CountSkipped(parsed->telegram_number);
    Complain(parsed->status);
    if (parsed->status & (kSickError | kSickTooDirty)) {
      ++report_.counts["error_status"];  // what it measures then is not to be trusted
      return;
    }
    const auto [device_us, restarted] = clock_.Read(parsed->scan.device_us);
    parsed->scan.device_us = device_us;
    parsed->scan.clock_restarted = restarted;
    scans.push_back(std::move(parsed->scan));
  }

  /// Telegrams that the laser has numbered and that did not come, or came damaged.
  void CountSkipped(std::uint16_t number) {
    if (last_number_) {
      const auto step = static_cast<std::uint16_t>(number - *last_number_);
      if (step > 1 && step < 0x8000) report_.counts["skipped"] += step - 1;
    }
    last_number_ = number;
  }

  void Complain(unsigned status) {
    const unsigned news = status & ~complained_;
    if (news & kSickError) report_.complaints.push_back("reports an internal error: its scans are left out");
    if (news & kSickDirtyWarning) report_.complaints.push_back("its window gets dirty: clean it");
    if (news & kSickTooDirty) {
      report_.complaints.push_back("its window is so dirty that its scans are left out: clean it");
    }
    complained_ = status;
  }

  DeviceReport& report_;
  ColaReader reader_;
  WrappingClock clock_{std::int64_t{1} << 32};
  std::vector<DeviceScan> early_;
  std::optional<std::uint16_t> last_number_;
  unsigned complained_ = 0;
  std::size_t num_bytes_ = 0;
};

}  // namespace

std::unique_ptr<LaserDevice> MakeSick(DeviceReport& report) { return std::make_unique<Sick>(report); }

}  // namespace crsm
