#pragma once

#include <cstdint>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/map/byte_map.hpp"

namespace crsm {

/// What a page makes of the messages of its feed.
class PageClient {
 public:
  struct PathPoint {
    std::uint32_t scan;
    float x_m;
    float y_m;
    int state;
    std::int32_t trajectory;
  };

  /// Throws std::out_of_range where a message is shorter than it says.
  void Take(std::string_view message) {
    while (!message.empty()) {
      Reader record{message};
      const auto kind = record.Read<std::uint8_t>();
      const auto size = record.Read<std::uint32_t>();
      record.left = record.left.substr(0, size);
      message.remove_prefix(5 + std::size_t{size});
      TakeRecord(kind, record);
    }
  }

  std::map<TileIndex, TileBytes> tiles;
  std::int64_t epoch = 0;
  std::int64_t version = 0;
  bool complete = false;
  int num_left = 0;  ///< tiles
  int num_map_records = 0;
  int num_begun = 0;        ///< with an empty map
  int num_whole_tiles = 0;  ///< that came
  int num_changed_tiles = 0;
  int num_robots = 0;
  std::int64_t robot_utime = 0;
  int robot_state = 0;
  double robot_x_m = 0.0;
  std::int32_t robot_trajectory = 0;
  bool robot_floats = false;
  std::size_t num_rays = 0;
  std::vector<PathPoint> path;
  std::vector<float> fitnesses;
  nlohmann::json info;
  int num_then = 0;
  bool then_is_end = false;
  std::uint32_t then_num_closed = 0;
  std::vector<float> then_loop_x_m;
  std::vector<double> timeline_time_s;
  std::vector<float> timeline_x_m;
  std::vector<float> timeline_first_x_m;
  std::vector<float> timeline_axis_rad;
  std::vector<std::int32_t> timeline_trajectory;
  std::vector<std::uint8_t> timeline_state;

  /// Nothing but unexplored cells is no tile.
  std::map<TileIndex, TileBytes> ExploredTiles() const {
    std::map<TileIndex, TileBytes> explored = tiles;
    std::erase_if(explored, [](const auto& tile) { return tile.second == ByteMap::Tile().cells; });
    return explored;
  }

 private:
  struct Reader {
    std::string_view left;
    template <class Number>
    Number Read() {
      Number number;
      if (left.size() < sizeof(number)) throw std::out_of_range("a message of the viewer ends too soon");
      std::memcpy(&number, left.data(), sizeof(number));
      left.remove_prefix(sizeof(number));
      return number;
    }
  };

  void TakeRecord(int kind, Reader& record) {
    if (kind == 1) return TakeMap(record);
    if (kind == 2) return TakeRobot(record);
    if (kind == 3) return TakePath(record);
    if (kind == 4) return TakeSamples(record);
    if (kind == 5) return void(info = nlohmann::json::parse(record.left));
    if (kind == 6) return TakeTimeline(record);
    if (kind == 7) return TakeThen(record);
    throw std::out_of_range("no such kind of record");
  }

  void TakeMap(Reader& record) {
    ++num_map_records;
    if (record.Read<std::uint8_t>() == 1) {
      tiles.clear();
      ++num_begun;
    }
    epoch = record.Read<std::int64_t>();
    version = record.Read<std::int64_t>();
    num_left = static_cast<int>(record.Read<std::uint32_t>());
    complete = num_left == 0;
    record.Read<double>();
    for (auto left = record.Read<std::uint16_t>(); left > 0; --left) {
      const int x = record.Read<std::int16_t>();
      const int y = record.Read<std::int16_t>();
      const bool whole = record.Read<std::uint8_t>() == 1;
      std::vector<std::uint8_t> runs(record.Read<std::uint16_t>());
      for (std::uint8_t& byte : runs) byte = record.Read<std::uint8_t>();
      TileBytes& cells = tiles.try_emplace({x, y}, ByteMap::Tile().cells).first->second;
      if (whole) cells = ByteMap::Tile().cells;
      if (!UnpackRuns(runs, cells)) throw std::out_of_range("runs of a tile do not fit");
      ++(whole ? num_whole_tiles : num_changed_tiles);
    }
  }

  void TakeRobot(Reader& record) {
    ++num_robots;
    robot_utime = record.Read<std::int64_t>();
    robot_state = record.Read<std::uint8_t>();
    robot_trajectory = record.Read<std::int32_t>();
    robot_floats = record.Read<std::uint8_t>() == 1;
    robot_x_m = record.Read<double>();
    record.left.remove_prefix(2 * sizeof(double) + 7 * sizeof(float));
    num_rays = record.Read<std::uint16_t>();
  }

  void TakeTimeline(Reader& record) {
    const auto num = record.Read<std::uint32_t>();
    const auto ReadAll = [&](auto& values) {
      values.clear();
      for (std::uint32_t i = 0; i < num; ++i) {
        values.push_back(record.Read<typename std::remove_reference_t<decltype(values)>::value_type>());
      }
    };
    ReadAll(timeline_time_s);
    ReadAll(timeline_x_m);
    record.left.remove_prefix(num * 2 * sizeof(float));  // y, yaw
    ReadAll(timeline_first_x_m);
    record.left.remove_prefix(num * 3 * sizeof(float));  // y, yaw of where it was matched first, fitness
    ReadAll(timeline_axis_rad);
    ReadAll(timeline_trajectory);
    ReadAll(timeline_state);
    if (!record.left.empty()) throw std::out_of_range("a time line is longer than its scans");
  }

  void TakeThen(Reader& record) {
    ++num_then;
    then_is_end = record.Read<std::uint8_t>() == 1;
    then_num_closed = record.Read<std::uint32_t>();
    then_loop_x_m.clear();
    for (auto left = record.Read<std::uint16_t>(); left > 0; --left) {
      then_loop_x_m.push_back(record.Read<float>());
      record.left.remove_prefix(3 * sizeof(float));
    }
    path.clear();
    TakePoints(record);
  }

  void TakePath(Reader& record) {
    record.Read<std::uint32_t>();
    path.resize(record.Read<std::uint32_t>());
    TakePoints(record);
  }

  void TakePoints(Reader& record) {
    for (auto left = record.Read<std::uint32_t>(); left > 0; --left) {
      const auto scan = record.Read<std::uint32_t>();
      const auto x_m = record.Read<float>();
      const auto y_m = record.Read<float>();
      const auto state = record.Read<std::uint8_t>();
      path.push_back({scan, x_m, y_m, state, record.Read<std::int32_t>()});
    }
  }

  void TakeSamples(Reader& record) {
    for (auto left = record.Read<std::uint32_t>(); left > 0; --left) {
      record.Read<double>();
      fitnesses.push_back(record.Read<float>());
      record.Read<std::uint8_t>();
    }
  }
};

}  // namespace crsm
