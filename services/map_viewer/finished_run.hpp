#pragma once

#include <functional>
#include <memory>
#include <string>

#include "services/map_viewer/scene.hpp"

namespace crsm {

/// A scene of what a run has come to, from the journal in the folder of its results: no bus and no other process is
/// needed. The map of a run that was localised on that of another one is its map.png: its journal has poses only. Of
/// RUN/pieces/N it is the piece of that number, with its scans alone.
/// Throws std::runtime_error in one line if there is no journal, if it is damaged in the middle, or if that map or
/// piece is not there.
std::unique_ptr<Scene> ReadFinishedRun(const std::string& results);

/// The same as it came to be: `changed` is called after each scan, and `scene` is then as it was known at that time;
/// its map and path are brought up to date fifty times and at the end. Throws as ReadFinishedRun.
void ReplayRun(const std::string& results, Scene& scene, const std::function<void()>& changed);

}  // namespace crsm
