#include "common/logs/carmen_log.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>
#include <utility>

#include "common/logs/left_out.hpp"
#include "common/math/parse_number.hpp"
#include "common/math/trigonometry.hpp"
#include "common/scan/thin_beams.hpp"

namespace crsm {
namespace {

constexpr double kDegree = kPi / 180.0;

struct Times {
  std::int64_t utime;
  std::optional<std::int64_t> logged_utime;  ///< where the logger wrote a time
};

/// The blank-separated fields of a line, one after the other. The first that is missing or wrong makes `good` false for
/// good, so that a line is read straight through and judged at its end.
class Fields {
 public:
  explicit Fields(std::string_view line) : rest_(line) {}

  bool good() const { return good_; }
  std::string_view wrong() const { return wrong_; }  ///< the first word that is; empty where the line ends too early

  bool beams_wrong() const { return beams_wrong_; }

  /// Each word is right, but they are not those of one scan.
  void RefuseBeams() {
    good_ = false;
    beams_wrong_ = true;
  }

  /// The word that was read last is wrong.
  void Refuse() {
    if (std::exchange(good_, false)) wrong_ = word_;
  }

  std::string_view Word() {
    constexpr std::string_view kBlanks = " \t\r";
    const std::size_t begin = std::min(rest_.find_first_not_of(kBlanks), rest_.size());
    const std::size_t end = std::min(rest_.find_first_of(kBlanks, begin), rest_.size());
    const std::string_view word = rest_.substr(begin, end - begin);
    rest_.remove_prefix(end);
    word_ = word;
    if (word.empty()) Refuse();
    return word;
  }

  template <class Number>
  Number Read() {
    const std::string_view word = Word();
    Number number{};
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error != std::errc{} || end != word.data() + word.size()) Refuse();
    return number;
  }

  /// An angle that a laser can have, in radians.
  double ReadAngle() {
    const auto angle_rad = Read<double>();
    if (!IsWithinFullTurn(angle_rad)) Refuse();
    return angle_rad;
  }

  std::size_t ReadCount(std::size_t min, std::size_t max) {
    const auto count = Read<std::size_t>();
    if (count < min || count > max) Refuse();
    return good_ ? count : 0;
  }

  std::vector<float> ReadRanges(std::size_t count) {
    std::vector<float> ranges_m(count);
    for (float& range_m : ranges_m) range_m = Read<float>();
    return ranges_m;
  }

  void SkipNumbers(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) Read<double>();
  }

  Pose2 ReadPose() {
    const auto x_m = Read<double>();
    const auto y_m = Read<double>();
    const auto yaw_rad = Read<double>();
    return {x_m, y_m, yaw_rad};
  }

  /// ipc_timestamp, host, logger_timestamp, and the line is over: a wrong number of beams shows here.
  Times ReadTimesAndEnd() {
    const std::optional<std::int64_t> utime = ParseUtime(Word());
    if (!utime) Refuse();
    Word();
    const std::optional<std::int64_t> logged_utime = ParseUtime(Word());
    if (rest_.find_first_not_of(" \t\r") != std::string_view::npos) {
      Word();
      Refuse();
    }
    return {utime.value_or(0), logged_utime};
  }

 private:
  std::string_view rest_;
  std::string_view word_;
  std::string_view wrong_;
  bool good_ = true;
  bool beams_wrong_ = false;
};

double FlaserStep(std::size_t num_beams) {
  switch (num_beams) {
    case 180:
    case 181:
      return 1.0 * kDegree;
    case 360:
    case 361:
      return 0.5 * kDegree;
    case 720:
    case 721:
      return 0.25 * kDegree;
    default:
      return 180.0 * kDegree / (static_cast<double>(num_beams) - 1.0);
  }
}

/// A line of a laser: a scan, and where the robot stood by its odometry.
struct Line {
  LaserScan scan;
  Pose2 T_odom_robot;
  std::optional<std::int64_t> logged_utime;

  void Take(const Times& times) {
    scan.utime = times.utime;
    logged_utime = times.logged_utime;
  }
};

Line ReadFlaser(Fields& fields) {
  Line line;
  LaserScan& scan = line.scan;
  const std::size_t num_beams = fields.ReadCount(kMinBeams, kMostBeamsRead);
  scan.angle_min_rad = static_cast<float>(-90.0 * kDegree);
  scan.angle_step_rad = static_cast<float>(FlaserStep(num_beams));
  scan.ranges_m = fields.ReadRanges(num_beams);
  fields.SkipNumbers(3);  // the pose of the laser
  line.T_odom_robot = fields.ReadPose();
  line.Take(fields.ReadTimesAndEnd());
  return line;
}

Line ReadRobotLaser(Fields& fields) {
  Line line;
  LaserScan& scan = line.scan;
  fields.SkipNumbers(1);  // type
  scan.angle_min_rad = static_cast<float>(fields.ReadAngle());
  fields.SkipNumbers(1);  // field of view
  scan.angle_step_rad = static_cast<float>(fields.ReadAngle());
  if (scan.angle_step_rad == 0.0f) fields.Refuse();
  auto max_range_m = fields.Read<float>();
  fields.SkipNumbers(2);  // accuracy, remission mode
  scan.ranges_m = fields.ReadRanges(fields.ReadCount(kMinBeams, kMostBeamsRead));
  fields.SkipNumbers(fields.ReadCount(0, kMostBeamsRead));  // remissions
  fields.SkipNumbers(3);                                    // the pose of the laser
  line.T_odom_robot = fields.ReadPose();
  fields.SkipNumbers(5);  // speeds, safety
  line.Take(fields.ReadTimesAndEnd());

  if (!(max_range_m > 0.0f)) max_range_m = std::numeric_limits<float>::infinity();  // the log does not know it
  std::replace_if(
      scan.ranges_m.begin(), scan.ranges_m.end(), [&](float range_m) { return range_m >= max_range_m; }, 0.0f);
  return line;
}

/// What is wrong with a line.
std::string Describe(const GzipFile::Line& line, const Fields& fields) {
  constexpr std::size_t kMostShown = 20;
  if (line.too_long) return " is longer than any line of a laser";
  if (fields.beams_wrong()) return " has beams over more than a full turn: its angles must be radians";
  if (fields.wrong().empty()) return " ends before its last field";
  return " is wrong at '" + std::string(fields.wrong().substr(0, kMostShown)) + "'";
}

bool IsLaser(std::string_view kind) { return kind == "FLASER" || kind == "ROBOTLASER1"; }

std::optional<Line> ReadLaser(std::string_view kind, Fields& fields) {
  Line line = kind == "FLASER" ? ReadFlaser(fields) : ReadRobotLaser(fields);
  const LaserScan& scan = line.scan;
  if (fields.good() && !AreBeamAngles(scan.angle_min_rad, scan.angle_step_rad, scan.ranges_m.size())) {
    fields.RefuseBeams();
  }
  return fields.good() ? std::optional(std::move(line)) : std::nullopt;
}

/// Of the first scans of a log. What is wrong with lines is counted when they are read for good.
LogClock StudyClock(const std::string& path) {
  constexpr int kMostLines = 10'000;
  LogClock clock;
  GzipFile file(path);
  for (int i = 0; i < kMostLines && !clock.HasStudiedEnough(); ++i) {
    const auto line = file.ReadLine();
    if (!line) break;
    Fields fields(line->text);
    const std::string_view kind = fields.Word();
    if (line->too_long || !IsLaser(kind)) continue;
    if (const auto laser = ReadLaser(kind, fields)) clock.Study(laser->scan, laser->logged_utime);
  }
  return clock;
}

/// Its digits without the point, and how many of them stand before it; nothing of a text that is no number.
struct Decimal {
  std::string digits;
  int num_before_point;

  /// 0 beyond what is written.
  int Digit(int at) const {
    return at >= 0 && at < static_cast<int>(digits.size()) ? digits[static_cast<std::size_t>(at)] - '0' : 0;
  }
};

std::optional<Decimal> ParseDecimal(std::string_view text) {
  constexpr int kMostExponent = 1000;
  constexpr std::size_t kMostCharacters = 1000;
  const std::size_t e = std::min(text.find_first_of("eE"), text.size());
  std::string_view exponent = text.substr(std::min(e + 1, text.size()));
  if (exponent.starts_with('+') && !exponent.starts_with("+-")) exponent.remove_prefix(1);  // which from_chars refuses
  const std::optional<int> shift = e == text.size() ? 0 : ParseNumber<int>(exponent);
  const std::string_view number = text.substr(0, e);
  const std::size_t point = std::min(number.find('.'), number.size());
  const std::string_view whole = number.substr(0, point);
  const std::string_view fraction = point < number.size() ? number.substr(point + 1) : "0";
  const auto IsDigits = [](std::string_view part) {
    return !part.empty() && part.find_first_not_of("0123456789") == std::string_view::npos;
  };
  if (!IsDigits(whole) || !IsDigits(fraction) || text.size() > kMostCharacters) return std::nullopt;
  if (!shift || *shift < -kMostExponent || *shift > kMostExponent) return std::nullopt;
  return Decimal{std::string(whole) + std::string(fraction), static_cast<int>(whole.size()) + *shift};
}

}  // namespace

CarmenLog::CarmenLog(const std::string& path) : file_(path), clock_(StudyClock(path)) {}

std::optional<LaserScan> CarmenLog::Next() {
  while (const auto line = file_.ReadLine()) {
    ++num_lines_;
    Fields fields(line->text);
    const std::string_view kind = fields.Word();
    if (!line->too_long && !IsLaser(kind)) continue;
    std::optional<Line> laser = line->too_long ? std::nullopt : ReadLaser(kind, fields);
    if (!laser) {
      if (++counts_["bad_line"] == 1) first_bad_ = "line " + std::to_string(num_lines_) + Describe(*line, fields);
      continue;
    }
    const auto time = clock_.TimeOf(laser->scan, laser->logged_utime);
    if (const auto utime = time ? utimes_.Add(*time) : std::nullopt; !utime) {
      ++counts_["utime_repeated"];
    } else {
      laser->scan.utime = *utime;
      if (const std::string thinned = ThinBeams(laser->scan); thinned_.empty()) thinned_ = thinned;
      T_odom_robot_ = RoundOdometry(laser->T_odom_robot);
      if (!T_odom_robot_) ++counts_["bad_odometry"];
      return std::move(laser->scan);
    }
  }
  if (file_.truncated()) counts_["truncated"] = 1;
  return std::nullopt;
}

std::vector<std::string> CarmenLog::OdometryNotes() const {
  const std::int64_t num_bad = FindCount(counts_, "bad_odometry");
  return {"gives odometry to " + std::to_string(utimes_.size() - num_bad) + " of " + std::to_string(utimes_.size()) +
          " scans (" + OdometryName() + ")"};
}

std::vector<std::string> CarmenLog::Complaints() const {
  std::vector<std::string> complaints;
  if (!thinned_.empty()) complaints.push_back(thinned_);
  const std::int64_t num_all = utimes_.size() + CountLeftOut(counts_);
  const auto Complain = [&](const char* name, const std::string& why) {
    const std::int64_t num = FindCount(counts_, name);
    if (!IsWorthSaying(num, num_all)) return;
    complaints.push_back(std::to_string(num) + " of " + std::to_string(num_all) + " scans are left out: " + why);
  };
  Complain("bad_line", first_bad_);
  Complain("utime_repeated", "their ipc_timestamp repeats that of an earlier scan; each scan needs its own");
  if (std::string stamps = clock_.Complaint("ipc_timestamp"); !stamps.empty()) complaints.push_back(std::move(stamps));
  return complaints;
}

bool HasCarmenLaser(GzipFile& file, int max_lines) {
  for (int i = 0; i < max_lines; ++i) {
    const auto line = file.ReadLine();
    if (!line || line->too_long) return false;
    if (IsLaser(Fields(line->text).Word())) return true;
  }
  return false;
}

std::optional<std::int64_t> ParseUtime(std::string_view seconds) {
  constexpr std::int64_t kMost = 9'000'000'000'000'999'999;
  constexpr int kDigitsOfMicrosecond = 6;
  const auto decimal = ParseDecimal(seconds);
  if (!decimal) return std::nullopt;
  const int end = decimal->num_before_point + kDigitsOfMicrosecond;
  std::int64_t utime = 0;
  for (int i = 0; i < end; ++i) {
    if (utime > kMost / 10) return std::nullopt;
    utime = 10 * utime + decimal->Digit(i);
  }
  if (utime > kMost) return std::nullopt;
  return utime + (decimal->Digit(end) >= 5 ? 1 : 0);
}

}  // namespace crsm
