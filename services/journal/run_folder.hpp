#pragma once

#include <filesystem>

namespace crsm {

/// What a folder of results is of.
struct RunFolder {
  std::filesystem::path run;  ///< which has the journal
  int piece = 1;              ///< of its map; 1 is the map that the run shows
};

/// RUN/pieces/N holds a piece of a map that is not joined with the rest, without a journal: its scans are in that of
/// RUN. Any other folder is taken for that of a run.
RunFolder FindRun(const std::filesystem::path& results);

}  // namespace crsm
