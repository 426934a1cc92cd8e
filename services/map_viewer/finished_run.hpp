#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "common/graph/mapper.hpp"
#include "services/map_viewer/scene.hpp"

namespace crsm {

/// Scenes of what a run has come to, from the journal in the folder of its results, by the numbers of its pieces: no
/// bus and no other process is needed. Of RUN and of RUN/pieces/N they are the same: all pieces that have a folder, and
/// that one. 1 is the map that the run shows, with all scans; another piece has its scans alone. Their names are their
/// folders. The map of a run that was localised on that of another one is its map.png: its journal has poses only.
/// Throws std::runtime_error in one line if there is no journal, if it is damaged in the middle, or if that map or
/// piece is not there.
std::map<int, std::unique_ptr<Scene>> ReadFinishedRun(const std::string& results);

/// Throws as ReadFinishedRun.
std::size_t CountScans(const std::string& results);

/// The same as it came to be: `changed` is called after each scan and at the end, and `scene` is then as it was known
/// at that time; its map and path are brought up to date every `step` scans and at the end. Throws as ReadFinishedRun.
void ReplayRun(const std::string& results, std::size_t step, Scene& scene,
               const std::function<void(const Mapper& so_far)>& changed);

}  // namespace crsm
