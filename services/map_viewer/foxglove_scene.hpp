#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "services/map_viewer/scene.hpp"
#include "services/wire/replay_clock.hpp"

namespace crsm {

/// One topic of a scene in the words of Foxglove.
struct FoxgloveTopic {
  enum class Kind { kScan, kPose, kTransform, kPath, kFloatingPath, kLog, kGrid };
  Kind kind = Kind::kScan;
  TileIndex block;  ///< of a grid: which 512 x 512 cells

  friend auto operator<=>(const FoxgloveTopic&, const FoxgloveTopic&) = default;
};

/// A scene as Foxglove and Lichtblick know how to show it: messages of well-known schemas, as JSON. The map is a grid
/// of its own for each block of 512 x 512 cells, since a grid is always sent as a whole.
class FoxgloveScene {
 public:
  /// prefix: before topics and frames, as "robot1/"; empty where there is one scene only. The scene outlives this.
  FoxgloveScene(const Scene& scene, std::string prefix);

  static constexpr int kBlockTiles = 8;  ///< side of a block

  /// All topics that there are so far: more come as the map grows, and with the first news.
  const std::vector<FoxgloveTopic>& Topics();

  std::string NameOf(const FoxgloveTopic& topic) const;
  static std::string SchemaNameOf(const FoxgloveTopic& topic);
  /// The JSON schema of its messages.
  static std::string SchemaOf(const FoxgloveTopic& topic);

  /// When it has changed last, as of the last call of Topics(); 0: there is nothing to tell yet.
  ChangeNumber LastChange(const FoxgloveTopic& topic) const;

  /// The message that tells how it is now.
  std::string Encode(const FoxgloveTopic& topic) const;

  /// Of the last scan, as of the last call of Topics() [ns since the epoch of the log], such that players can play it
  /// (ReplayClock); 0 before the first.
  std::uint64_t time_ns() const { return static_cast<std::uint64_t>(clock_.now()) * 1000; }

 private:
  const Scene& scene_;
  std::string prefix_;
  ReplayClock clock_;
  std::vector<FoxgloveTopic> topics_;
  std::map<TileIndex, ChangeNumber> blocks_;  ///< when each has changed last
  ChangeNumber blocks_known_ = 0;             ///< changes of the map up to this one are in blocks_
  int generation_ = 0;                        ///< of the map
};

/// A layout for Foxglove and Lichtblick that shows the topics of these prefixes, with the grids, which are hidden else.
std::string MakeFoxgloveLayout(const std::vector<std::string>& prefixes);

}  // namespace crsm
