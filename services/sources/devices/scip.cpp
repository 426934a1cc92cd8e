#include "services/sources/devices/scip.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "common/math/trigonometry.hpp"

namespace crsm {
namespace {

constexpr std::size_t kLongestLine = 256;  // scans have lines of 65 letters, words of makers may be longer
constexpr std::size_t kMostLines = 256;    // 4096 beams of 3 letters are 192 lines
constexpr std::size_t kTimestampLetters = 4;
constexpr std::size_t kRangeLetters = 3;

char ChecksumOf(std::string_view text) {
  unsigned sum = 0;
  for (const char letter : text) sum += static_cast<unsigned char>(letter);
  return static_cast<char>((sum & 0x3f) + 0x30);
}

/// Takes the checksum from the end of a line, and from a line of words the ';' before it, which it does not cover.
/// False if it does not hold.
bool TakeChecksum(std::string& line) {
  if (line.size() < 2) return false;
  const char sum = line.back();
  line.pop_back();
  if (ChecksumOf(line) == sum) return true;
  if (line.back() != ';') return false;
  line.pop_back();
  return ChecksumOf(line) == sum;
}

}  // namespace

std::vector<ScipReply> ScipReader::Take(std::string_view bytes) {
  std::vector<ScipReply> replies;
  for (const char byte : bytes) {
    if (byte == '\n') {
      EndLine(replies);
    } else {
      if (line_.size() >= kLongestLine) line_.erase(0, kLongestLine / 2);  // noise, with an echo at its end maybe
      line_ += byte;
    }
  }
  return replies;
}

void ScipReader::EndLine(std::vector<ScipReply>& replies) {
  if (!line_.empty() && line_.back() == '\r') line_.pop_back();
  const bool begins_scan = !scan_command_.empty() && line_.ends_with(scan_command_);
  if (begins_scan) line_ = scan_command_;
  if (line_.empty() || begins_scan) EndReply(replies);
  if (!line_.empty() && lines_.size() <= kMostLines) lines_.push_back(std::move(line_));
  line_.clear();
}

void ScipReader::EndReply(std::vector<ScipReply>& replies) {
  std::vector<std::string> lines;
  lines.swap(lines_);
  if (lines.empty()) return;
  if (lines.size() < 2 || lines.front().size() < 2) {
    ++report_.counts["garbage"];
    return;
  }
  if (lines[0] == "SCIP2.0") return;  // SCIP 1.1: the laser was asked to speak 2.0, and answers as before
  if (!std::all_of(lines.begin() + 1, lines.end(), TakeChecksum) || lines.size() > kMostLines) {
    ++report_.counts["bad_checksum"];
    return;
  }
  replies.push_back({std::move(lines[0]), std::move(lines[1]), {lines.begin() + 2, lines.end()}});
}

std::string FindScipValue(const ScipReply& reply, std::string_view key) {
  for (const std::string_view line : reply.lines) {
    if (!line.starts_with(key) || line.substr(key.size(), 1) != ":") continue;
    const std::size_t begin = line.find_first_not_of(' ', key.size() + 1);
    return begin == std::string_view::npos ? "" : std::string(line.substr(begin));
  }
  return "";
}

std::optional<ScipParameters> ParseScipParameters(const ScipReply& reply) {
  bool valid = true;
  const auto Number = [&](std::string_view key, int low, int high) {
    const std::string text = FindScipValue(reply, key);
    int number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    valid = valid && error == std::errc() && number >= low && number <= high;
    return number;
  };
  constexpr int kMostSteps = 100000;
  ScipParameters parameters;
  parameters.model = FindScipValue(reply, "MODL");
  parameters.range_min_mm = Number("DMIN", 0, 1000000);
  parameters.range_max_mm = Number("DMAX", parameters.range_min_mm + 1, 1000000);
  parameters.steps_per_turn = Number("ARES", 2, kMostSteps);
  parameters.first_step = Number("AMIN", 0, 9999);  // four digits in MD
  parameters.last_step = Number("AMAX", parameters.first_step + 1, 9999);
  parameters.front_step = Number("AFRT", 0, kMostSteps);
  parameters.turns_per_min = Number("SCAN", 1, 100000);
  valid = valid && parameters.last_step - parameters.first_step < static_cast<int>(kMaxBeams) &&
          parameters.last_step - parameters.first_step < parameters.steps_per_turn;
  return valid ? std::optional(parameters) : std::nullopt;
}

std::optional<std::int32_t> DecodeScipNumber(std::string_view letters) {
  std::int32_t number = 0;
  for (const char letter : letters) {
    const int bits = static_cast<unsigned char>(letter) - 0x30;
    if (bits < 0 || bits > 0x3f) return std::nullopt;
    number = number << 6 | bits;
  }
  return number;
}

std::optional<DeviceScan> ParseScipScan(const ScipReply& reply, const ScipParameters& parameters) {
  if (reply.lines.empty() || reply.lines[0].size() != kTimestampLetters) return std::nullopt;
  const auto timestamp_ms = DecodeScipNumber(reply.lines[0]);
  std::string letters;  // a value may begin in one line and end in the next
  for (std::size_t i = 1; i < reply.lines.size(); ++i) letters += reply.lines[i];
  const auto num_beams = static_cast<std::size_t>(parameters.last_step - parameters.first_step + 1);
  if (!timestamp_ms || letters.size() != kRangeLetters * num_beams) return std::nullopt;

  const double step_rad = 2.0 * kPi / parameters.steps_per_turn;
  DeviceScan result;
  result.turn_s = 60.0 / parameters.turns_per_min;
  // The laser's stamp is of step 0.
  result.device_us = std::int64_t{1000} * *timestamp_ms +
                     std::llround(1e6 * result.turn_s * parameters.last_step / parameters.steps_per_turn);
  result.scan.angle_min_rad = static_cast<float>((parameters.first_step - parameters.front_step) * step_rad);
  result.scan.angle_step_rad = static_cast<float>(step_rad);
  for (std::size_t beam = 0; beam < num_beams; ++beam) {
    const auto range_mm = DecodeScipNumber(std::string_view(letters).substr(kRangeLetters * beam, kRangeLetters));
    if (!range_mm) return std::nullopt;
    const bool seen = *range_mm >= parameters.range_min_mm && *range_mm <= parameters.range_max_mm;
    result.scan.ranges_m.push_back(seen ? static_cast<float>(*range_mm / 1000.0) : 0.0f);  // else an error code
  }
  return result;
}

}  // namespace crsm
