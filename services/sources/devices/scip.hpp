#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "services/sources/devices/laser_device.hpp"

namespace crsm {

// SCIP 2.0, the protocol of Hokuyo's lasers. Source: Hokuyo C-42-03320B. Knows no connection.

/// An answer, all of whose checksums hold.
struct ScipReply {
  std::string command;             ///< that it answers
  std::string status;              ///< two letters
  std::vector<std::string> lines;  ///< without their checksums
};

/// Bytes in, answers out. Counts "garbage" (no answer at all) and "bad_checksum".
class ScipReader {
 public:
  explicit ScipReader(DeviceReport& report) : report_(report) {}

  /// The command whose answers are scans: where a line ends in its echo, an answer begins, even if the empty line
  /// before it was lost, or is noise.
  void ExpectScans(const std::string& command) { scan_command_ = command; }

  std::vector<ScipReply> Take(std::string_view bytes);

 private:
  void EndLine(std::vector<ScipReply>& replies);
  void EndReply(std::vector<ScipReply>& replies);

  DeviceReport& report_;
  std::string scan_command_;
  std::string line_;
  std::vector<std::string> lines_;  ///< of the answer that is under way
};

/// What a laser says of itself (PP). Steps count counter-clockwise.
struct ScipParameters {
  std::string model;
  int range_min_mm = 0;
  int range_max_mm = 0;
  int steps_per_turn = 0;
  int first_step = 0;
  int last_step = 0;
  int front_step = 0;
  int turns_per_min = 0;
};

/// Nothing if something is missing or cannot be.
std::optional<ScipParameters> ParseScipParameters(const ScipReply& reply);

/// The value of a key in an answer to VV, PP or II; empty if there is none.
std::string FindScipValue(const ScipReply& reply, std::string_view key);

/// A number of any count of letters, 6 bits each; nothing if a letter is none.
std::optional<std::int32_t> DecodeScipNumber(std::string_view letters);

/// A scan in the answer to MD; its device_us is the 24 bits of the laser, in us. Nothing if it is not all there.
std::optional<DeviceScan> ParseScipScan(const ScipReply& reply, const ScipParameters& parameters);

}  // namespace crsm
