#include "services/map_viewer/page_feed.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "common/math/parse_number.hpp"
#include "common/math/trigonometry.hpp"
#include "common/results/json_text.hpp"
#include "common/scan/scan_counts.hpp"
#include "services/base/process.hpp"
#include "services/map_viewer/history.hpp"
#include "services/map_viewer/little_endian.hpp"

namespace crsm {
namespace {

constexpr std::size_t kMostMapBytes = 256 * 1024;  // of a message: a slow client is told of the robot in between

enum RecordKind : std::uint8_t { kMap = 1, kRobot = 2, kPath = 3, kSamples = 4, kInfo = 5, kTimeline = 6, kThen = 7 };

void AppendRecord(std::string& message, RecordKind kind, const std::string& record) {
  Append(message, kind);
  Append(message, static_cast<std::uint32_t>(record.size()));
  message += record;
}

float Narrow(double value) { return static_cast<float>(value); }

double AngleOf(const std::array<double, 2>& axis) {
  const bool is_known = axis[0] != 0.0 || axis[1] != 0.0;
  return is_known ? std::atan2(axis[1], axis[0]) : std::numeric_limits<double>::quiet_NaN();
}

/// States that are told beside those of scan_match_t.
constexpr std::uint8_t kFloating = 4;
constexpr std::uint8_t kWithoutRays = 5;

/// Of the scan, on whichever piece it is.
std::uint8_t StateOf(const ScanMatch& match) {
  return OutcomeOf(match) == ScanOutcome::kWithoutRays ? kWithoutRays : static_cast<std::uint8_t>(match.state);
}

std::uint8_t PathState(const ScanMatch& match) {
  return OutcomeOf(match) == ScanOutcome::kFloating ? kFloating : StateOf(match);
}

void AppendTile(std::string& tiles, TileIndex index, bool whole, const std::vector<std::uint8_t>& runs) {
  Append(tiles, static_cast<std::int16_t>(index.x));
  Append(tiles, static_cast<std::int16_t>(index.y));
  Append(tiles, static_cast<std::uint8_t>(whole));
  Append(tiles, static_cast<std::uint16_t>(runs.size()));
  tiles.append(runs.begin(), runs.end());
}

/// x y of both ends, f32.
void AppendLoop(std::string& record, const PlacedLoop& loop) {
  for (const Pose2& end : {loop.T_map_older, loop.T_map_newer}) {
    Append(record, Narrow(end.x_m));
    Append(record, Narrow(end.y_m));
  }
}

}  // namespace

std::string PackPath(std::span<const PathSketch::Kept> points) {
  std::string packed;
  Append(packed, static_cast<std::uint32_t>(points.size()));
  for (const auto& [number, match] : points) {
    Append(packed, static_cast<std::uint32_t>(number));
    Append(packed, Narrow(match.T_map_laser.x_m));
    Append(packed, Narrow(match.T_map_laser.y_m));
    Append(packed, PathState(match));
    Append(packed, static_cast<std::int32_t>(match.trajectory));
  }
  return packed;
}

PageFeed::PageFeed(const Scene& scene, std::vector<std::string> names, const Cursor& cursor, bool may_change)
    : scene_(scene), names_(std::move(names)), may_change_(may_change) {
  map_told_ = scene.map().FindVersion(cursor.epoch, cursor.version);
  if (map_told_ > 0) map_generation_ = scene.map().generation();
}

std::optional<Feed::Message> PageFeed::Next() {
  Message message;
  if (timeline_told_ != scene_.timeline().size()) AddTimeline(message.bytes);
  if (robot_told_ != scene_.robot_change() || scan_wanted_) AddRobot(message.bytes);
  if (samples_told_ != scene_.num_samples()) AddSamples(message.bytes);
  if (map_told_ != scene_.map().last_change()) {
    AddMap(message.bytes);
  } else if (moment_changed_) {
    AddThen(message.bytes);
  }
  if (path_generation_ != scene_.path_generation() || path_told_ != scene_.path().kept().size()) {
    AddPath(message.bytes);
  }
  if (info_told_ != scene_.info_change()) AddInfo(message.bytes);
  if (message.bytes.empty()) return std::nullopt;
  return message;
}

void PageFeed::AddMap(std::string& message) {
  const SceneMap& map = scene_.map();
  const bool anew = std::exchange(map_generation_, map.generation()) != map.generation();
  if (anew) map_told_ = 0;
  const ChangeNumber had = map_told_;
  std::string tiles;
  std::uint16_t num_tiles = 0;
  std::ptrdiff_t num_left = 0;
  for (auto change = map.changes().upper_bound(had); change != map.changes().end(); ++change) {
    if (tiles.size() > kMostMapBytes) {
      num_left = std::distance(change, map.changes().end());
      break;
    }
    const SceneMap::Tile& tile = map.tiles().at(change->second);
    const bool whole = tile.changed_before == 0 || tile.changed_before > had;
    const std::vector<std::uint8_t> runs = whole ? PackRuns(SceneMap::Tile().cells, tile.cells) : tile.last_runs;
    AppendTile(tiles, change->second, whole, runs);
    ++num_tiles;
    map_told_ = change->first;
  }
  has_more_ = num_left > 0;
  if (!has_more_) map_told_ = map.last_change();
  AppendMap(message, anew, num_left, num_tiles, tiles);
}

void PageFeed::AddRobot(std::string& message) {
  robot_told_ = scene_.robot_change();
  const auto wanted = std::exchange(scan_wanted_, std::nullopt);
  SceneRobot then;
  if (wanted) then = {scene_.timeline().match(*wanted), scene_.timeline().scan(*wanted)};
  const auto& [match, scan] = wanted ? std::as_const(then) : scene_.robot();
  std::string record;
  Append(record, match.utime);
  Append(record, StateOf(match));
  Append(record, match.trajectory);
  Append(record, static_cast<std::uint8_t>(match.floating));
  Append(record, match.T_map_laser.x_m);
  Append(record, match.T_map_laser.y_m);
  Append(record, match.T_map_laser.yaw_rad);
  Append(record, Narrow(match.fitness));
  for (const std::size_t entry : {0UL, 1UL, 3UL, 5UL}) Append(record, Narrow(match.covariance[entry]));
  for (const double component : match.degenerate_axis) Append(record, Narrow(component));
  Append(record, static_cast<std::uint16_t>(scan.rays.size()));
  for (std::size_t i = 0; i < scan.rays.size(); ++i) {
    Append(record, scan.rays.angle_rad[i]);
    Append(record, scan.rays.range_m[i]);
  }
  Append(record, static_cast<std::uint16_t>(scan.critical.size()));
  for (const int index : scan.critical) Append(record, static_cast<std::uint16_t>(index));
  AppendRecord(message, kRobot, record);
}

bool PageFeed::Hear(std::string_view message, bool is_text) {
  constexpr std::string_view kScan = "scan ";
  constexpr std::string_view kThen = "then ";
  constexpr std::string_view kStart = "start ";
  constexpr std::string_view kMark = "mark ";
  constexpr std::string_view kEdits = "edits ";
  if (!is_text) return false;
  if (message.starts_with(kScan)) return HearScan(message.substr(kScan.size()));
  if (message.starts_with(kThen)) return HearThen(message.substr(kThen.size()));
  if (!may_change_) return false;
  if (message.starts_with(kEdits)) return scene_.TakeEdits(message.substr(kEdits.size()));
  if (message.starts_with(kMark)) return HearMark(message.substr(kMark.size()));
  return message.starts_with(kStart) && HearStart(message.substr(kStart.size()));
}

bool PageFeed::HearScan(std::string_view text) {
  const auto number = ParseNumber<std::size_t>(text);
  if (!number || *number >= scene_.timeline().size()) return false;
  scan_wanted_ = number;
  return true;
}

bool PageFeed::HearThen(std::string_view text) {
  const auto number = ParseNumber<std::size_t>(text);
  if (!scene_.history() || !number || *number >= scene_.timeline().size()) return false;
  const std::size_t moment = scene_.history()->FindMoment(*number);
  moment_changed_ = moment_changed_ || moment_ != moment;
  moment_ = moment;
  return true;
}

bool PageFeed::HearStart(std::string_view text) const {
  constexpr double kFurthest_m = 1e6;  // as wire.cpp takes poses
  std::vector<double> numbers;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.size(), text.find(' ', at));
    const auto number = ParseNumber<double>(text.substr(at, end - at));
    if (!number || numbers.size() == 3 || !(std::abs(*number) <= kFurthest_m)) return false;
    numbers.push_back(*number);
    at = end + 1;
  }
  return numbers.size() == 3 && scene_.StartAt({numbers[0], numbers[1], WrapAngle(numbers[2])});
}

bool PageFeed::HearMark(std::string_view text) const {
  constexpr double kRadius_m = 0.1;  // of a click
  const auto json = nlohmann::json::parse(text, nullptr, false);
  Mark mark;
  try {
    json.at("id").get_to(mark.id);
    json.at("kind").get_to(mark.kind);
    json.at("name").get_to(mark.name);
    for (const nlohmann::json& point : json.at("points")) {
      mark.points.push_back({point.at(0).get<double>(), point.at(1).get<double>()});
    }
  } catch (const nlohmann::json::exception&) {
    return false;
  }
  mark.action = mark.points.empty() ? MarkAction::kRemoved : MarkAction::kMoved;
  mark.in_map_frame = true;
  mark.radius_m = kRadius_m;
  mark.utime = UtimeNow();
  return DescribeFault(mark).empty() && scene_.TakeMark(mark);
}

void PageFeed::AddTimeline(std::string& message) {
  const Timeline& timeline = scene_.timeline();
  timeline_told_ = timeline.size();
  std::string record;
  Append(record, static_cast<std::uint32_t>(timeline.size()));
  const auto AppendAll = [&](const auto& of_match) {
    for (std::size_t i = 0; i < timeline.size(); ++i) Append(record, of_match(timeline.match(i)));
  };
  const auto AppendFirst = [&](float Timeline::Position::*coordinate) {
    for (std::size_t i = 0; i < timeline.size(); ++i) Append(record, timeline.first_position(i).*coordinate);
  };
  AppendAll([](const ScanMatch& match) { return static_cast<double>(match.utime) * 1e-6; });
  AppendAll([](const ScanMatch& match) { return Narrow(match.T_map_laser.x_m); });
  AppendAll([](const ScanMatch& match) { return Narrow(match.T_map_laser.y_m); });
  AppendAll([](const ScanMatch& match) { return Narrow(match.T_map_laser.yaw_rad); });
  AppendFirst(&Timeline::Position::x_m);
  AppendFirst(&Timeline::Position::y_m);
  AppendFirst(&Timeline::Position::yaw_rad);
  AppendAll([](const ScanMatch& match) { return Narrow(match.fitness); });
  AppendAll([](const ScanMatch& match) { return Narrow(AngleOf(match.degenerate_axis)); });
  AppendAll([](const ScanMatch& match) { return static_cast<std::int32_t>(match.trajectory); });
  AppendAll(PathState);
  AppendRecord(message, kTimeline, record);
}

void PageFeed::AddThen(std::string& message) {
  const History& history = *scene_.history();
  has_more_ = AddTilesOfMoment(message);
  if (has_more_) return;
  moment_changed_ = false;
  const History::Moment& moment = history.moment(*moment_);
  std::string record;
  Append(record, static_cast<std::uint8_t>(history.is_end(*moment_)));
  Append(record, moment.num_closed);
  Append(record, static_cast<std::uint16_t>(moment.loops.size()));
  for (const PlacedLoop& loop : moment.loops) AppendLoop(record, loop);
  AppendRecord(message, kThen, record + moment.path);
}

/// Whether there are more.
bool PageFeed::AddTilesOfMoment(std::string& message) {
  const auto& stories = scene_.history()->tiles();
  if (held_.empty()) {
    for (const auto& [index, changes] : stories) held_.push_back(changes.size());
  }
  std::string tiles;
  std::uint16_t num_tiles = 0;
  bool has_more = false;
  auto held = held_.begin();
  for (const auto& [index, changes] : stories) {
    std::size_t& num_held = *held++;
    const std::size_t num = History::CountChanges(changes, *moment_);
    if (num == num_held) continue;
    has_more = tiles.size() > kMostMapBytes;
    if (has_more) break;
    num_held = num;
    AppendTile(tiles, index, true, num == 0 ? std::vector<std::uint8_t>() : changes[num - 1].runs);
    ++num_tiles;
  }
  AppendMap(message, false, has_more ? 1 : 0, num_tiles, tiles);
  return has_more;
}

void PageFeed::AppendMap(std::string& message, bool anew, std::ptrdiff_t num_left, std::uint16_t num_tiles,
                         const std::string& tiles) const {
  const SceneMap& map = scene_.map();
  std::string record;
  Append(record, static_cast<std::uint8_t>(anew));
  Append(record, map.epoch());
  Append(record, map.version());
  Append(record, static_cast<std::uint32_t>(num_left));
  Append(record, map.cell_size_m());
  Append(record, num_tiles);
  AppendRecord(message, kMap, record + tiles);
}

void PageFeed::AddPath(std::string& message) {
  const auto& kept = scene_.path().kept();
  if (std::exchange(path_generation_, scene_.path_generation()) != scene_.path_generation()) path_told_ = 0;
  std::string record;
  Append(record, static_cast<std::uint32_t>(path_generation_));
  Append(record, static_cast<std::uint32_t>(path_told_));
  record += PackPath(std::span(kept).subspan(path_told_));
  path_told_ = kept.size();
  AppendRecord(message, kPath, record);
}

void PageFeed::AddSamples(std::string& message) {
  const auto& samples = scene_.samples();
  const auto num_new = std::min<std::int64_t>(scene_.num_samples() - samples_told_, std::ssize(samples));
  samples_told_ = scene_.num_samples();
  std::string record;
  Append(record, static_cast<std::uint32_t>(num_new));
  for (auto sample = samples.end() - num_new; sample != samples.end(); ++sample) {
    Append(record, static_cast<double>(sample->utime) * 1e-6);
    Append(record, sample->fitness);
    Append(record, static_cast<std::uint8_t>(sample->state));
  }
  AppendRecord(message, kSamples, record);
}

void PageFeed::AddInfo(std::string& message) {
  info_told_ = scene_.info_change();
  nlohmann::json info = nlohmann::json::parse(scene_.info());
  info["robots"] = names_;
  info["robot"] = scene_.name();
  info["looks"] = !may_change_;
  info["knows_then"] = scene_.history() != nullptr;
  if (!scene_.edits().empty()) info["edits"] = nlohmann::json::parse(scene_.edits());
  info["news"] = {{"number", scene_.num_news()}, {"text", scene_.newest_news()}};
  info["loops"] = nlohmann::json::array();
  for (const PlacedLoop& loop : scene_.loops()) {
    const Pose2& older = loop.T_map_older;
    const Pose2& newer = loop.T_map_newer;
    info["loops"].push_back({older.x_m, older.y_m, newer.x_m, newer.y_m});
  }
  info["marks"] = nlohmann::json::array();
  for (const PlacedMark& mark : scene_.marks()) {
    nlohmann::json points;
    for (const auto& [x_m, y_m] : mark.points) points.push_back({x_m, y_m});
    info["marks"].push_back({{"id", mark.id},
                             {"kind", mark.kind},
                             {"name", mark.name},
                             {"points", points},
                             {"floating", mark.floating},
                             {"sightings", mark.num_sightings},
                             {"sigma_m", std::sqrt(std::max(mark.covariance[0], mark.covariance[2]))}});
  }
  AppendRecord(message, kInfo, ToText(info));
}

}  // namespace crsm
