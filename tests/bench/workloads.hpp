#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/match/fit/rays_in_cells.hpp"
#include "common/match/fit/scored_map.hpp"
#include "common/match/rrhc_matcher.hpp"
#include "common/slam.hpp"

namespace crsm::bench {

/// A room with a scan taken in its middle, the origin, and others like it as they are explored: a map of any size on
/// which the work for one scan stays the same.
class Site {
 public:
  /// num_evaluations: spent on the search of every match, no more and no fewer.
  explicit Site(int num_evaluations);

  /// What the pipeline does for one scan, each step alone. All at a pose a little off the origin.
  std::vector<int> Select() const;
  ScanMatch Match(int num_rays) const;
  MapDelta Update();
  double Evaluate(const RaysInCells& rays) const;

  /// So many rays of the scan, evenly spread.
  RaysInCells PickRays(int num_rays) const;

  /// Draws the room of the next place on a spiral around the others, and takes over what changed. Returns how many
  /// tiles the map has then.
  std::size_t Explore();

  void Apply(const MapDelta& delta) { matcher_.Apply(delta.tiles); }

 private:
  std::vector<int> PickIndices(int num_rays) const;

  RrhcMatcher matcher_;
  MapUpdater updater_;
  ScoredMap map_;
  LaserScan scan_;
  CriticalRays rays_;
  Cell next_room_{1, 0};  ///< of the spiral
};

/// A fixed piece of work: the same instructions at every run.
struct Workload {
  std::string name;
  std::function<void()> run;
};

/// One for each step of the pipeline.
std::vector<Workload> MakeWorkloads();

}  // namespace crsm::bench
