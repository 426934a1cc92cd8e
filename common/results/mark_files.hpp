#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "common/logs/replacement.hpp"
#include "common/marks/mark.hpp"

namespace crsm {

/// All files that marks are written to.
inline constexpr std::array kMarkFiles{"marks.csv", "marks.geojson", "keepout.png", "keepout.yaml",
                                       "slow.png",  "slow.yaml",     "map.tif"};

/// The places of a map as text: a header, then id,kind,name,x_m,y_m,radius_m,sightings,floating in each line, in the
/// map's frame. radius_m: standard deviation along the direction where it is largest. The corners of an outline are
/// joined by semicolons. ReadMarkList reads it too.
std::string FormatMarksCsv(const std::vector<PlacedMark>& marks);

/// The same as GeoJSON: points and polygons in metres of the map's frame, which is no frame of the earth.
std::string FormatMarksGeoJson(const std::vector<PlacedMark>& marks);

/// Adds marks.csv and marks.geojson, where there are marks.
void AddMarks(const std::vector<PlacedMark>& marks, Replacement& files);

/// The places in the results of a run, from `dir`'s marks.geojson; none where it is not there. Throws
/// std::runtime_error that names the file if it is something else.
std::vector<PlacedMark> ReadMarks(const std::filesystem::path& dir);

/// What a user says of places: a header that names columns, then a line for each sighting. Columns: kind; x_m and y_m
/// in the map's frame, or time_s, as in trajectory.tum, and x_m and y_m from the laser, 0 without; id, name and
/// radius_m may be left out. Sightings of one id are one place; without an id each line is one.
struct ListedMark {
  Mark mark;
  int line = 0;
};
/// Throws std::runtime_error that names the file and the line.
std::vector<ListedMark> ReadMarkList(const std::string& path);

}  // namespace crsm
