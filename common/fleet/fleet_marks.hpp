#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/fleet/fleet_graph.hpp"
#include "common/marks/mark.hpp"

namespace crsm {

/// The places with names of all robots, on the common map.
///
/// An id names a place within its robot. So the places of two robots stay two, and ids and names begin with the robot.
/// A robot that has begun a new map may have a place on both: the one on the map that is shown counts, else the newer.
class FleetMarks {
 public:
  /// These are the places of a map now, and no others. robot: its name.
  void Set(int map, const std::string& robot, std::vector<AnchoredMark> marks) {
    maps_[map] = {robot, std::move(marks)};
  }

  /// Whether the keyframes that places of a map are fixed to are there.
  static bool Fits(const FleetGraph& graph, int map, const std::vector<AnchoredMark>& marks);

  /// Where they lie by the common graph, at most PlacedMark::kMostOnMap. shown: the piece that is shown.
  std::vector<PlacedMark> Place(const FleetGraph& graph, int shown) const;
  /// The same, those for which there is no room included.
  std::size_t Count() const;

 private:
  struct OfMap {
    std::string robot;
    std::vector<AnchoredMark> marks;
  };
  std::map<int, OfMap> maps_;
};

}  // namespace crsm
