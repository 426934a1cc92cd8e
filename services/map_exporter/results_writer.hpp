#pragma once

#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/map/byte_map.hpp"
#include "common/results/png.hpp"
#include "common/results/results.hpp"
#include "common/results/summary.hpp"
#include "common/scan/critical_rays.hpp"
#include "services/map_exporter/trajectory_text.hpp"

namespace crsm {

/// What a run has come to, to be written while it goes on.
struct Snapshot {
  std::int64_t version = 0;                            ///< of the map
  std::optional<double> begun_cell_size_m;             ///< a new map was begun since the last snapshot, with such cells
  std::vector<std::pair<TileIndex, TileBytes>> tiles;  ///< that have changed since
  std::vector<ScanMatch> path;                         ///< enough of the matches to draw it
  std::shared_ptr<const TrajectoryText> text;  ///< of all that do not float; another one where a new map was begun
  CriticalRays last_scan;
  std::vector<PlacedLoop> loops;
  MapPieces pieces;
  std::vector<PlacedMark> marks;
  Summary summary;  ///< all but the explored area
};

/// Writes the results of a run into a folder again and again, in a thread of its own, at a cost that does not grow with
/// the run: map.png and map.yaml only if the map has changed, of trajectory.tum what is new, at its end, line by line.
/// map.pgm, which is many times larger than map.png, is left to the end of the run.
class ResultsWriter {
 public:
  explicit ResultsWriter(std::filesystem::path dir);
  /// Ends what is being written.
  ~ResultsWriter();

  /// Whether a snapshot is being written.
  bool busy() const;

  /// Begins to write. Only while it is not busy.
  void Start(Snapshot snapshot);

  struct Outcome {
    std::int64_t version = 0;
    std::shared_ptr<const TrajectoryText> text;  ///< tells whether it was of the same map
    std::string error;                           ///< empty if all was written; else older files are as they were
    double cpu_s = 0.0;                          ///< that it took
  };
  /// Of a snapshot that was written meanwhile; once.
  std::optional<Outcome> TakeOutcome();

 private:
  void Work();
  void Write(Snapshot& snapshot);
  void TakeMap(const Snapshot& snapshot);
  bool TrajectoryGoesOn(const Snapshot& snapshot) const;
  void AppendTrajectory(std::uint64_t end);

  std::filesystem::path dir_;

  // Of the thread.
  std::optional<ByteMap> map_;
  Results drawn_;  ///< with the last map
  PngEncoder map_encoder_;
  PngEncoder overview_encoder_;
  double explored_area_m2_ = 0.0;
  bool map_written_ = false;
  std::shared_ptr<const TrajectoryText> text_;  ///< of which the first bytes are in the file
  std::uint64_t num_text_bytes_ = 0;

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<Snapshot> waiting_;
  bool busy_ = false;
  bool ended_ = false;
  std::optional<Outcome> outcome_;
  std::thread thread_;
};

}  // namespace crsm
