#pragma once

#include <filesystem>

namespace crsm {

/// Whether a run has left results in a folder. One that saw no scan leaves nothing that is worth keeping: no poses, and
/// one unexplored cell. Without a trajectory such files are not of a run: somebody's own map.
bool HoldsResults(const std::filesystem::path& out);

/// Where results in `out` would be moved: the first of earlier.1, earlier.2 ... in it that is not there. Below the
/// folder itself: beside it there may be another disk, or no right to write.
std::filesystem::path FindPlaceAside(const std::filesystem::path& out);

/// Moves the results in a folder there, and says where. Throws std::filesystem::filesystem_error.
std::filesystem::path MoveAside(const std::filesystem::path& out);

}  // namespace crsm
