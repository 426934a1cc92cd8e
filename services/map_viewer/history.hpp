#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/graph/placed_loop.hpp"
#include "services/map_viewer/scene.hpp"

namespace crsm {

/// A finished run as it was known at moments of it: its map, its path and its loops. The last moment is the end.
class History {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{256} << 20;

  struct Moment {
    std::size_t num_scans = 0;      ///< that were known; all of them at the end
    std::uint32_t num_closed = 0;   ///< loops
    std::vector<PlacedLoop> loops;  ///< the newest of them
    std::string path;               ///< as of PackPath
  };

  /// What a tile was from a moment on: as of map_tile_t, of an unexplored one.
  struct TileChange {
    std::size_t moment = 0;
    std::vector<std::uint8_t> runs;
  };
  using TileChanges = std::vector<TileChange>;

  /// A later moment. scene: has its path, its loops and its map, which is the same SceneMap each time. Throws
  /// std::runtime_error where all of it has more than kMostBytes.
  void Add(const Scene& scene, std::size_t num_closed);
  /// The end, with the map that the run has come to.
  void Finish(const SceneMap& map, std::size_t num_scans);

  /// The last one up to a scan, by its number; the first one where there is none.
  std::size_t FindMoment(std::size_t scan) const;
  const Moment& moment(std::size_t number) const { return moments_[number]; }
  bool is_end(std::size_t moment) const { return moment + 1 == moments_.size(); }

  const std::map<TileIndex, TileChanges>& tiles() const { return tiles_; }
  /// How many of the changes of a tile had been made at a moment.
  static std::size_t CountChanges(const TileChanges& changes, std::size_t moment);

 private:
  void Set(TileIndex index, const TileBytes& cells);

  std::vector<Moment> moments_;
  std::map<TileIndex, TileChanges> tiles_;
  ChangeNumber last_change_ = 0;
  std::size_t num_bytes_ = 0;
};

/// Of a finished run that is shown, from its journal, which takes seconds for a run of an hour. Throws as ReplayRun,
/// and std::runtime_error when it is stopped, or where the run has gone on.
std::shared_ptr<const History> ReadHistory(const Scene& end, const std::function<bool()>& is_stopped);

}  // namespace crsm
