#pragma once

#include <string>
#include <vector>

#include "common/map/map_updater.hpp"
#include "common/math/point.hpp"
#include "common/plan/plan_constants.hpp"

namespace crsm {

/// A place with a name, for the room that it lies in.
struct NamedPlace {
  std::string name;
  Point at;  ///< map frame
};

/// One face of a wall: one with rooms on both sides has two, unless it is too thin to tell. The laser was on the left of
/// the way between its ends.
struct PlanWall {
  Point from;  ///< map frame
  Point to;
  double length_m = 0.0;
  double sigma_length_m = 0.0;  ///< standard deviation, by the lines that were fitted
  double sigma_offset_m = 0.0;  ///< of its line, across it
  bool snapped = false;         ///< to a main direction of the building
  friend bool operator==(const PlanWall&, const PlanWall&) = default;
};

/// A gap in a wall that the laser saw through. From jamb to jamb, map frame.
struct PlanDoor {
  Point from;
  Point to;
  friend bool operator==(const PlanDoor&, const PlanDoor&) = default;
};

/// Free space that walls and doors close.
struct PlanRoom {
  std::string name;  ///< of the place that lies in it; empty if none does
  Point middle;      ///< map frame: inside, far from the walls
  double area_m2 = 0.0;
  friend bool operator==(const PlanRoom&, const PlanRoom&) = default;
};

/// A floor plan, in the frame of the map.
struct Plan {
  std::vector<double> directions_rad;  ///< main directions of the building, in [0, pi / 2), each with its right angle
  std::vector<PlanWall> walls;
  std::vector<PlanDoor> doors;
  std::vector<PlanRoom> rooms;  ///< the largest first
  /// So far off the map that it was made from may be; 0 where nobody knows.
  double map_off_m = 0.0;

  double extent_m() const;  ///< the diagonal of what the walls cover
};

/// By so much the length of a wall may be wrong, in one of twenty [m]: by its lines, and by its share of what the map
/// may be off, which a wall that runs through all of the map would have in full.
double BoundLengthError(const Plan& plan, const PlanWall& wall);

/// Makes a floor plan of what a laser saw. Lines are fitted to the hits themselves, not to cells of a map. Things that
/// stand alone and are smaller than a room's wall, and what was seen only once, are left out. names: of rooms.
/// Without scans, or without walls in them, the plan is empty. Throws std::invalid_argument if a pose is not finite.
Plan MakePlan(const std::vector<PlacedScan>& scans, const std::vector<NamedPlace>& names = {},
              const PlanConstants& constants = {});

/// The plan as a drawing for CAD programs: DXF R12, in metres, with the layers WALLS, DOORS, ROOMS and TEXT. title:
/// lines of text below it. Source: AutoCAD DXF reference, release 12.
std::string FormatDxf(const Plan& plan, const std::vector<std::string>& title);

}  // namespace crsm
