#include "services/map_viewer/foxglove_scene.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "common/map/dense_grid.hpp"
#include "common/results/json_text.hpp"

namespace crsm {
namespace {

using nlohmann::json;
using Kind = FoxgloveTopic::Kind;

constexpr int kBlockCells = FoxgloveScene::kBlockTiles * kTileSide;
constexpr std::int64_t kNanosecondsPerMicrosecond = 1000;
constexpr std::int64_t kMicrosecondsPerSecond = 1'000'000;
constexpr int kUint8 = 1;      // foxglove.NumericType
constexpr int kInfoLevel = 2;  // foxglove.LogLevel

/// Rounds down, also what is left of or below the origin.
TileIndex BlockOf(TileIndex tile) {
  static_assert(FoxgloveScene::kBlockTiles == 8);
  return {tile.x >> 3, tile.y >> 3};
}

json Object(json properties) {
  json required = json::array();
  for (const auto& [name, schema] : properties.items()) required.push_back(name);
  return {{"type", "object"}, {"properties", std::move(properties)}, {"required", std::move(required)}};
}

json ArrayOf(json items) { return {{"type", "array"}, {"items", std::move(items)}}; }

json SchemaProperties(Kind kind) {
  const json number{{"type", "number"}};
  const json integer{{"type", "integer"}, {"minimum", 0}};
  const json text{{"type", "string"}};
  const json vector = Object({{"x", number}, {"y", number}, {"z", number}});
  const json quaternion = Object({{"x", number}, {"y", number}, {"z", number}, {"w", number}});
  const json pose = Object({{"position", vector}, {"orientation", quaternion}});
  json time = Object({{"sec", integer}, {"nsec", integer}});
  time["title"] = "time";
  const json field = Object({{"name", text}, {"offset", integer}, {"type", integer}});
  switch (kind) {
    case Kind::kScan:
      return {{"timestamp", time},
              {"frame_id", text},
              {"pose", pose},
              {"start_angle", number},
              {"end_angle", number},
              {"ranges", ArrayOf(number)},
              {"intensities", ArrayOf(number)}};
    case Kind::kPose:
      return {{"timestamp", time}, {"frame_id", text}, {"pose", pose}};
    case Kind::kTransform:
      return {{"timestamp", time},
              {"parent_frame_id", text},
              {"child_frame_id", text},
              {"translation", vector},
              {"rotation", quaternion}};
    case Kind::kPath:
    case Kind::kFloatingPath:
      return {{"timestamp", time}, {"frame_id", text}, {"poses", ArrayOf(pose)}};
    case Kind::kLog:
      return {{"timestamp", time}, {"level", integer}, {"message", text},
              {"name", text},      {"file", text},     {"line", integer}};
    case Kind::kGrid:
      break;
  }
  return {{"timestamp", time},
          {"frame_id", text},
          {"pose", pose},
          {"column_count", integer},
          {"cell_size", Object({{"x", number}, {"y", number}})},
          {"row_stride", integer},
          {"cell_stride", integer},
          {"fields", ArrayOf(field)},
          {"data", {{"type", "string"}, {"contentEncoding", "base64"}}}};
}

json Position(double x_m, double y_m) { return {{"x", x_m}, {"y", y_m}, {"z", 0.0}}; }

json Orientation(double yaw_rad) {
  const auto [sin, cos] = ComputeSinCos(WrapAngle(0.5 * yaw_rad));
  return {{"x", 0.0}, {"y", 0.0}, {"z", sin}, {"w", cos}};
}

json ToJson(const Pose2& pose) {
  return {{"position", Position(pose.x_m, pose.y_m)}, {"orientation", Orientation(pose.yaw_rad)}};
}

std::string EncodeBase64(std::span<const std::uint8_t> bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < left ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += k <= left ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

/// Ranges at equal steps of the angle, as Foxglove wants them: the smallest step that there is between two rays.
struct EvenRanges {
  double start_rad = 0.0;
  double end_rad = 0.0;
  std::vector<float> range_m;  ///< 0 where nothing was measured
};

EvenRanges SpreadEvenly(const ValidRays& rays) {
  constexpr std::size_t kMostSteps = 8192;
  if (rays.size() == 0) return {};
  EvenRanges even{rays.angle_rad.front(), rays.angle_rad.back(), {}};
  const double width_rad = even.end_rad - even.start_rad;
  double step_rad = std::max(width_rad, 1e-6);
  for (std::size_t i = 1; i < rays.size(); ++i) {
    const double gap_rad = static_cast<double>(rays.angle_rad[i]) - static_cast<double>(rays.angle_rad[i - 1]);
    if (gap_rad > width_rad / kMostSteps) step_rad = std::min(step_rad, gap_rad);
  }
  const auto num_steps = static_cast<std::size_t>(std::lround(width_rad / step_rad));
  even.range_m.assign(num_steps + 1, 0.0F);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const double share = width_rad > 0.0 ? (static_cast<double>(rays.angle_rad[i]) - even.start_rad) / width_rad : 0.0;
    even.range_m[static_cast<std::size_t>(std::lround(share * static_cast<double>(num_steps)))] = rays.range_m[i];
  }
  return even;
}

void AddGrid(const SceneMap& map, TileIndex block, json& message) {
  std::vector<std::uint8_t> cells(std::size_t{kBlockCells} * kBlockCells, kUnexploredByte);
  for (int y = 0; y < FoxgloveScene::kBlockTiles; ++y) {
    for (int x = 0; x < FoxgloveScene::kBlockTiles; ++x) {
      const auto tile =
          map.tiles().find({block.x * FoxgloveScene::kBlockTiles + x, block.y * FoxgloveScene::kBlockTiles + y});
      if (tile == map.tiles().end()) continue;
      for (int row = 0; row < kTileSide; ++row) {
        std::copy_n(tile->second.cells.begin() + row * kTileSide, kTileSide,
                    cells.begin() + (y * kTileSide + row) * kBlockCells + x * kTileSide);
      }
    }
  }
  const double side_m = kBlockCells * map.cell_size_m();
  message["pose"] = ToJson({block.x * side_m, block.y * side_m, 0.0});
  message["column_count"] = kBlockCells;
  message["cell_size"] = {{"x", map.cell_size_m()}, {"y", map.cell_size_m()}};
  message["row_stride"] = kBlockCells;
  message["cell_stride"] = 1;
  message["fields"] = {{{"name", "cell"}, {"offset", 0}, {"type", kUint8}}};
  message["data"] = EncodeBase64(cells);
}

}  // namespace

FoxgloveScene::FoxgloveScene(const Scene& scene, std::string prefix) : scene_(scene), prefix_(std::move(prefix)) {
  for (const Kind kind : {Kind::kScan, Kind::kPose, Kind::kTransform, Kind::kPath, Kind::kFloatingPath}) {
    topics_.push_back({kind, {}});
  }
}

const std::vector<FoxgloveTopic>& FoxgloveScene::Topics() {
  if (scene_.robot_change() != 0) clock_.Follow(std::max<std::int64_t>(0, scene_.robot().match.utime));
  const SceneMap& map = scene_.map();
  if (std::exchange(generation_, map.generation()) != map.generation()) blocks_known_ = 0;
  for (auto change = map.changes().upper_bound(blocks_known_); change != map.changes().end(); ++change) {
    const TileIndex block = BlockOf(change->second);
    if (blocks_.count(block) == 0) topics_.push_back({Kind::kGrid, block});
    blocks_[block] = change->first;
  }
  blocks_known_ = map.last_change();
  const FoxgloveTopic log{Kind::kLog, {}};
  if (scene_.num_news() > 0 && std::ranges::find(topics_, log) == topics_.end()) topics_.push_back(log);
  return topics_;
}

std::string FoxgloveScene::NameOf(const FoxgloveTopic& topic) const {
  switch (topic.kind) {
    case Kind::kScan:
      return fmt::format("/{}scan", prefix_);
    case Kind::kPose:
      return fmt::format("/{}pose", prefix_);
    case Kind::kTransform:
      return fmt::format("/{}tf", prefix_);
    case Kind::kPath:
      return fmt::format("/{}path", prefix_);
    case Kind::kFloatingPath:
      return fmt::format("/{}floating_path", prefix_);
    case Kind::kLog:
      return fmt::format("/{}log", prefix_);
    case Kind::kGrid:
      break;
  }
  return fmt::format("/{}map/{}_{}", prefix_, topic.block.x, topic.block.y);
}

std::string FoxgloveScene::SchemaNameOf(const FoxgloveTopic& topic) {
  switch (topic.kind) {
    case Kind::kScan:
      return "foxglove.LaserScan";
    case Kind::kPose:
      return "foxglove.PoseInFrame";
    case Kind::kTransform:
      return "foxglove.FrameTransform";
    case Kind::kPath:
    case Kind::kFloatingPath:
      return "foxglove.PosesInFrame";
    case Kind::kLog:
      return "foxglove.Log";
    case Kind::kGrid:
      break;
  }
  return "foxglove.Grid";
}

std::string FoxgloveScene::SchemaOf(const FoxgloveTopic& topic) {
  json schema = Object(SchemaProperties(topic.kind));
  schema["title"] = SchemaNameOf(topic);
  return ToText(schema);
}

ChangeNumber FoxgloveScene::LastChange(const FoxgloveTopic& topic) const {
  if (topic.kind == Kind::kGrid) {
    const auto block = blocks_.find(topic.block);
    return block == blocks_.end() ? 0 : block->second;
  }
  if (topic.kind == Kind::kLog) return static_cast<ChangeNumber>(scene_.num_news());
  if (topic.kind != Kind::kPath && topic.kind != Kind::kFloatingPath) return scene_.robot_change();
  constexpr ChangeNumber kMostPoints = 1 << 20;  // of one path
  const auto num_points = static_cast<ChangeNumber>(scene_.path().kept().size());
  return num_points == 0 ? 0 : static_cast<ChangeNumber>(scene_.path_generation()) * kMostPoints + num_points;
}

std::string FoxgloveScene::Encode(const FoxgloveTopic& topic) const {
  const auto& [match, scan] = scene_.robot();
  const std::int64_t utime = clock_.now();
  json message{{"timestamp",
                {{"sec", utime / kMicrosecondsPerSecond},
                 {"nsec", utime % kMicrosecondsPerSecond * kNanosecondsPerMicrosecond}}}};
  message["frame_id"] = prefix_ + "map";
  if (topic.kind == Kind::kScan) {
    const EvenRanges even = SpreadEvenly(scan.rays);
    message["frame_id"] = prefix_ + "laser";
    message["pose"] = ToJson({});
    message["start_angle"] = even.start_rad;
    message["end_angle"] = even.end_rad;
    message["ranges"] = even.range_m;
    message["intensities"] = json::array();
  } else if (topic.kind == Kind::kPose) {
    message["pose"] = ToJson(match.T_map_laser);
  } else if (topic.kind == Kind::kTransform) {
    message["parent_frame_id"] = message["frame_id"];
    message["child_frame_id"] = prefix_ + "laser";
    message["translation"] = Position(match.T_map_laser.x_m, match.T_map_laser.y_m);
    message["rotation"] = Orientation(match.T_map_laser.yaw_rad);
    message.erase("frame_id");
  } else if (topic.kind == Kind::kPath || topic.kind == Kind::kFloatingPath) {
    message["poses"] = json::array();
    for (const auto& [number, at] : scene_.path().kept()) {
      const bool is_wanted = at.floating == (topic.kind == Kind::kFloatingPath);
      if (is_wanted) message["poses"].push_back(ToJson(at.T_map_laser));
    }
  } else if (topic.kind == Kind::kLog) {
    message.erase("frame_id");
    message["level"] = kInfoLevel;
    message["message"] = scene_.newest_news();
    message["name"] = "map_viewer";
    message["file"] = "";
    message["line"] = 0;
  } else {
    AddGrid(scene_.map(), topic.block, message);
  }
  return ToText(message);
}

std::string MakeFoxgloveLayout(const std::vector<std::string>& prefixes) {
  constexpr int kReach = 8;  // blocks each way: 200 m with cells of 0.05 m
  json topics = json::object();
  for (const std::string& prefix : prefixes) {
    for (int y = -kReach; y < kReach; ++y) {
      for (int x = -kReach; x < kReach; ++x) {
        topics[fmt::format("/{}map/{}_{}", prefix, x, y)] = {
            {"visible", true},         {"colorField", "cell"},
            {"colorMode", "gradient"}, {"gradient", {"#000000ff", "#ffffffff"}},
            {"minValue", 0},           {"maxValue", 255}};
      }
    }
    topics[fmt::format("/{}scan", prefix)] = {
        {"visible", true}, {"colorMode", "flat"}, {"flatColor", "#35d0baff"}, {"pointSize", 4}};
    topics[fmt::format("/{}pose", prefix)] = {{"visible", true}, {"color", "#ffb020ff"}};
    topics[fmt::format("/{}path", prefix)] = {{"visible", true}, {"type", "line"}, {"lineWidth", 0.1}};
    topics[fmt::format("/{}floating_path", prefix)] = {
        {"visible", true}, {"type", "line"}, {"lineWidth", 0.05}, {"gradient", {"#b8e64aff", "#b8e64aff"}}};
  }
  const std::string first = prefixes.empty() ? "" : prefixes.front();
  const json view{{"followTf", first + "map"},
                  {"followMode", "follow-none"},
                  {"cameraState", {{"perspective", false}, {"distance", 60}, {"phi", 0}, {"thetaOffset", 90}}},
                  {"topics", topics},
                  {"transforms", json::object()},
                  {"layers", json::object()}};
  return ToText({{"configById", {{"3D!map", view}}},
                 {"globalVariables", json::object()},
                 {"userNodes", json::object()},
                 {"playbackConfig", {{"speed", 1}}},
                 {"layout", "3D!map"}},
                1);
}

}  // namespace crsm
