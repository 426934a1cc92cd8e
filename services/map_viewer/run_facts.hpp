#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/diagnosis/changes.hpp"
#include "common/graph/pieces.hpp"
#include "common/scan/scan_counts.hpp"
#include "common/scan/scan_match.hpp"
#include "services/journal/run_folder.hpp"

namespace crsm {

/// How many scans have become what: {"scans", "on_map", "floating", "lost", "without_rays"}.
nlohmann::json DescribeCounts(const ScanCounts& counts);

/// What the summary.json of a run says of it: {"verdict": {"trust", "lines"}, "way_m", "area_m2", "left_out", and what
/// the map was made from: "made_from", "recorded", "version"}. Without a verdict on all of its `num_scans` scans,
/// `trust` is "none", and the line says why. identity: of the map, as of FormatIdentity.
nlohmann::json ReadRunFacts(const std::filesystem::path& results, std::size_t num_scans, const std::string& identity);

/// The folder of a piece of the map of a run.
std::filesystem::path FolderOf(const std::filesystem::path& run, int piece);

/// The pieces of the map of a run, the one that it shows first: [{"piece", "scans", "way_m", "folder"}, ...]; no
/// "folder" where a piece has none.
nlohmann::json ListPieces(const std::filesystem::path& run, const MapPieces& pieces);

/// As ReadRunFacts, of a piece: there is no verdict on it. {"verdict": {"trust", "lines"}, "way_m"}.
nlohmann::json DescribePiece(const RunFolder& results, const MapPieces& pieces);

/// Where the robot of a simulated world really was, as [[x, y], ...] on the map on which `first` is the pose of its
/// first scan; empty where the run has no truth.tum that can be read.
nlohmann::json ReadTruth(const std::filesystem::path& results, const ScanMatch& first);

/// What has changed since the map was made on which a robot localises, by the names of summary.json.
nlohmann::json DescribeChanges(const std::vector<MapChange>& changes);

}  // namespace crsm
