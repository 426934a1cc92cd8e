#include "common/results/result_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <system_error>
#include <vector>

#include "common/metrics/trajectory.hpp"
#include "common/results/mark_files.hpp"

namespace crsm {

namespace {

void CheckSize(const DenseGrid& grid) {
  const bool negative = grid.width_cells < 0 || grid.height_cells < 0;
  const auto num_cells = static_cast<std::size_t>(grid.width_cells) * static_cast<std::size_t>(grid.height_cells);
  if (negative || num_cells != grid.cells.size() || (num_cells > 0 && !(grid.cell_size_m > 0.0))) {
    throw std::invalid_argument(fmt::format("WriteResults: a grid of {} x {} cells of {} m cannot hold {} cells",
                                            grid.width_cells, grid.height_cells, grid.cell_size_m, grid.cells.size()));
  }
}

/// Those that are not of another piece.
MatchSequence WithoutFloating(const MatchSequence& matches) {
  return MatchSequence([&matches](const MatchSequence::Visit& visit) {
    matches.ForEach([&](const ScanMatch& match) {
      if (!match.floating) visit(match);
    });
  });
}

/// Piece by piece, however many matches there are.
void FormatTrajectory(const MatchSequence& matches, const Sink& sink) {
  constexpr std::size_t kPieceBytes = std::size_t{1} << 16;
  std::string piece;
  matches.ForEach([&](const ScanMatch& match) {
    AppendPose({match.utime, match.T_map_laser}, piece);
    if (piece.size() < kPieceBytes) return;
    sink(piece);
    piece.clear();
  });
  sink(piece);
}

void WriteMap(const DenseGrid& grid, const EncodeGrid& encode, Replacement& files) {
  files.Write("map.png", encode(grid));
  files.Write("map.pgm", [&](const Sink& sink) { FormatPgm(grid, sink); });
  files.Write("map.yaml", FormatMapYaml(grid));
}

constexpr std::array kFilesOfPiece{"map.png", "map.pgm", "map.yaml", "trajectory.tum"};

bool IsNumber(const std::string& name) {
  return std::all_of(name.begin(), name.end(), [](char digit) { return digit >= '0' && digit <= '9'; });
}

}  // namespace

std::string NameOfRun(const std::filesystem::path& dir) {
  const std::filesystem::path path = std::filesystem::absolute(dir).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).filename().string();  // "a/b/" has none
}

void MakeFolder(const std::filesystem::path& dir) {
  std::error_code error;
  std::filesystem::create_directories(dir, error);
  if (error) throw std::runtime_error(fmt::format("cannot make the folder {}: {}", dir.string(), error.message()));
}

void AddResults(const Results& results, const Encoders& encoders, Replacement& files) {
  CheckSize(results.grid);
  if (results.grid.cells.empty()) {
    Results drawable = results;
    drawable.grid = MakeUnexploredCell(results.grid.cell_size_m);
    return AddResults(drawable, encoders, files);
  }
  WriteMap(results.grid, encoders.map, files);
  if (encoders.overview) files.Write("overview.png", encoders.overview(results));
  files.Write("trajectory.tum", [&](const Sink& sink) {
    results.trajectory_text ? results.trajectory_text(sink) : FormatTrajectory(WithoutFloating(results.matches), sink);
  });
  if (!results.truth.empty()) files.Write("truth.tum", FormatTrajectory(results.truth));
  if (!results.graph_g2o.empty()) files.Write("graph.g2o", results.graph_g2o);
  if (results.summary && results.summary->changes) {
    files.Write("changes.csv", FormatChangesCsv(*results.summary->changes));
  }
  AddMarks(results.marks, files);
  files.Write("summary.json", results.summary ? FormatSummary(*results.summary) : "{}\n");
}

void WritePiece(const std::filesystem::path& dir, int number, const DenseGrid& grid, const MatchSequence& matches,
                const EncodeGrid& encode) {
  const std::filesystem::path folder = dir / "pieces" / std::to_string(number);
  CheckSize(grid);
  MakeFolder(folder);
  Replacement files(folder);
  WriteMap(grid.cells.empty() ? MakeUnexploredCell(grid.cell_size_m) : grid, encode, files);
  files.Write("trajectory.tum", [&](const Sink& sink) { FormatTrajectory(matches, sink); });
  files.Rename();
}

void RemovePieces(const std::filesystem::path& dir) {
  namespace fs = std::filesystem;
  const fs::path pieces = dir / "pieces";
  std::error_code error;
  if (!fs::is_directory(fs::symlink_status(pieces, error))) return;
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(pieces, error)) {
    const bool is_folder = fs::is_directory(entry.symlink_status());
    if (is_folder && IsNumber(entry.path().filename().string())) folders.push_back(entry.path());
  }
  for (const fs::path& folder : folders) {
    for (const char* file : kFilesOfPiece) {
      if (!error) fs::remove(folder / file, error);
    }
    if (!error && fs::is_empty(folder, error)) fs::remove(folder, error);
  }
  if (!error && fs::is_empty(pieces, error)) fs::remove(pieces, error);
  if (error) throw std::runtime_error(fmt::format("cannot clear {}: {}", pieces.string(), error.message()));
}

}  // namespace crsm
