#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "common/logs/replacement.hpp"
#include "common/results/results.hpp"

namespace crsm {

/// A grid of at least one cell as PNG bytes, as of EncodeMap.
using EncodeGrid = std::function<std::string(const DenseGrid&)>;

/// What makes pictures: WriteResults has OpenCV for it, the library has not.
struct Encoders {
  EncodeGrid map;
  std::function<std::string(const Results&)> overview;  ///< empty: there is no overview.png
};

/// Throws std::runtime_error that names the folder.
void MakeFolder(const std::filesystem::path& dir);

/// The files of WriteResults, which take their places when `files` renames them. Throws as that does.
void AddResults(const Results& results, const Encoders& encoders, Replacement& files);

/// WritePiece with another encoder.
void WritePiece(const std::filesystem::path& dir, int number, const DenseGrid& grid, const MatchSequence& matches,
                const EncodeGrid& encode);

}  // namespace crsm
