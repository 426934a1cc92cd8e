#include "services/sources/devices/cola.hpp"

#include <bit>
#include <charconv>
#include <cmath>

#include "common/math/trigonometry.hpp"

namespace crsm {
namespace {

constexpr char kBegin = '\x02';
constexpr char kEnd = '\x03';
constexpr std::size_t kLongest = 65536;  // 4096 beams of five letters, thrice

/// The words of a telegram, one after the other. What is no number makes it invalid.
class Words {
 public:
  explicit Words(std::string_view text) : left_(text) {}

  std::string_view Next() {
    const std::size_t end = left_.find(' ');
    const std::string_view word = left_.substr(0, end);
    left_ = end == std::string_view::npos ? std::string_view() : left_.substr(end + 1);
    return word;
  }
  std::uint32_t Number() {
    const std::string_view word = Next();
    std::uint32_t number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number, 16);
    if (error != std::errc() || end != word.data() + word.size()) valid_ = false;
    return number;
  }
  void Skip(std::uint32_t count) {
    for (std::uint32_t i = 0; i < count && !left_.empty(); ++i) Next();
  }
  void Invalidate() { valid_ = false; }

  bool valid() const { return valid_; }
  bool empty() const { return left_.empty(); }

 private:
  std::string_view left_;
  bool valid_ = true;
};

/// The words from "DIST1" on.
void ParseDistances(Words& words, LaserScan& scan) {
  constexpr double kUnit_rad = 1e-4 * kPi / 180.0;
  constexpr double kAhead_rad = kPi / 2.0;      // of SICK, whose 0 deg lies to the right
  constexpr std::uint32_t kFirstDistance = 16;  // what is less says why there is none
  const double scale = std::bit_cast<float>(words.Number());
  const double offset = std::bit_cast<float>(words.Number());
  const auto first = static_cast<std::int32_t>(words.Number());
  const std::uint32_t step = words.Number();
  const std::uint32_t count = words.Number();
  constexpr std::int32_t kTurn = 3600000;
  if (!words.valid() || first < -kTurn || first > kTurn || step == 0 || count < kMinBeams || count > kMaxBeams ||
      std::uint64_t{step} * (count - 1) > kTurn || !(scale >= 1e-3 && scale <= 1e3) || !(std::abs(offset) <= 1e6)) {
    return words.Invalidate();
  }
  scan.angle_min_rad = static_cast<float>(kUnit_rad * first - kAhead_rad);
  scan.angle_step_rad = static_cast<float>(kUnit_rad * step);
  for (std::uint32_t i = 0; i < count && words.valid(); ++i) {
    const std::uint32_t distance = words.Number();
    if (distance > 0xffff) words.Invalidate();
    scan.ranges_m.push_back(distance < kFirstDistance ? 0.0f
                                                      : static_cast<float>((distance * scale + offset) / 1000.0));
  }
}

}  // namespace

std::string ColaTelegram(const std::string& text) { return kBegin + text + kEnd; }

std::vector<std::string> ColaReader::Take(std::string_view bytes) {
  std::vector<std::string> telegrams;
  const auto CountGarbage = [this] {
    if (!in_garbage_) ++report_.counts["garbage"];
    in_garbage_ = true;
  };
  for (const char byte : bytes) {
    if (byte == kBegin) {
      if (in_telegram_) CountGarbage();  // the one before has no end
      in_telegram_ = true;
      in_garbage_ = false;
      telegram_.clear();
    } else if (!in_telegram_) {
      CountGarbage();
    } else if (byte == kEnd) {
      telegrams.push_back(std::move(telegram_));
      telegram_.clear();
      in_telegram_ = false;
    } else if (telegram_.size() >= kLongest) {
      in_telegram_ = false;
      CountGarbage();
    } else {
      telegram_ += byte;
    }
  }
  return telegrams;
}

std::optional<ColaScan> ParseColaScan(std::string_view telegram) {
  Words words(telegram);
  words.Skip(2);  // sSN LMDscandata
  words.Skip(3);  // version, number and serial number of the laser
  ColaScan result;
  words.Number();
  result.status = words.Number();
  result.telegram_number = static_cast<std::uint16_t>(words.Number());
  words.Number();  // of the scan
  const std::uint32_t device_us = words.Number();
  words.Number();  // when it was sent
  words.Skip(5);   // inputs, outputs, layer
  const double scans_per_s = 0.01 * words.Number();
  words.Number();  // of measurements
  const std::uint32_t num_encoders = words.Number();
  words.Skip(num_encoders <= 3 ? 2 * num_encoders : 0);
  const std::uint32_t num_channels = words.Number();
  if (!words.valid() || num_channels == 0 || !(scans_per_s >= 0.1 && scans_per_s <= 1000.0)) return std::nullopt;

  while (!words.empty() && words.Next() != "DIST1") continue;
  LaserScan& scan = result.scan.scan;
  ParseDistances(words, scan);
  if (!words.valid()) return std::nullopt;
  result.scan.turn_s = 1.0 / scans_per_s;
  result.scan.device_us = device_us;
  return result;
}

}  // namespace crsm
