#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "services/sources/devices/laser_device.hpp"

namespace crsm {

// CoLa A, the protocol of SICK's lasers in letters. Source: SICK, Telegram Listing Ranging sensors (8014631). Knows no
// connection.

/// Bytes in, telegrams out, without the two bytes around each. Counts "garbage": bytes between telegrams, and telegrams
/// that are cut or too long.
class ColaReader {
 public:
  explicit ColaReader(DeviceReport& report) : report_(report) {}

  std::vector<std::string> Take(std::string_view bytes);

 private:
  DeviceReport& report_;
  std::string telegram_;
  bool in_telegram_ = false;
  bool in_garbage_ = false;
};

/// "<STX>text<ETX>"
std::string ColaTelegram(const std::string& text);

/// A telegram with what a laser has measured (sSN LMDscandata).
struct ColaScan {
  DeviceScan scan;  ///< its device_us is the 32 bits of the laser
  unsigned status = 0;
  std::uint16_t telegram_number = 0;
};

inline constexpr unsigned kSickError = 1;  ///< bits of ColaScan::status
inline constexpr unsigned kSickDirtyWarning = 2;
inline constexpr unsigned kSickTooDirty = 4;

/// Nothing if something is missing or cannot be.
std::optional<ColaScan> ParseColaScan(std::string_view telegram);

}  // namespace crsm
