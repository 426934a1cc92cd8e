#include "common/results/results.hpp"

#include "common/results/map_edits.hpp"
#include "common/results/mark_files.hpp"
#include "common/results/mark_masks.hpp"
#include "common/results/pictures.hpp"
#include "common/results/rescue_map.hpp"
#include "common/results/result_files.hpp"
#include "common/scan/scan_counts.hpp"

namespace crsm {
namespace {

std::string EncodeWithOpenCv(const DenseGrid& grid) { return EncodeMap(grid); }

/// What of the marks takes OpenCV.
void AddMarkPictures(const Results& results, Replacement& files) {
  const bool is_empty = results.grid.cells.empty();
  const DenseGrid grid = is_empty ? MakeUnexploredCell(results.grid.cell_size_m) : results.grid;
  AddMasks(grid, results.marks, files);
  if (results.team.empty()) return;
  RescueMap map{grid, {}, results.marks, results.name.empty() ? results.team : results.team + ": " + results.name};
  results.matches.ForEach([&](const ScanMatch& match) {
    if (OutcomeOf(match) == ScanOutcome::kOnMap) map.path.Add(match.T_map_laser);
  });
  files.Write("map.tif", EncodeRescueMap(map));
}

}  // namespace

void WriteResults(const std::filesystem::path& dir, const Results& results) {
  MakeFolder(dir);
  Replacement files(dir);
  AddResults(results, {EncodeWithOpenCv, [](const Results& drawable) { return EncodeOverview(drawable); }}, files);
  AddMarkPictures(results, files);
  files.RemoveOthers(kMarkFiles);
  files.RemoveOthers(kEditedFiles);
  FreeMapPicture(dir);
  files.Rename();
  RemoveOldPictures(dir);
}

void WritePiece(const std::filesystem::path& dir, int number, const DenseGrid& grid, const MatchSequence& matches) {
  WritePiece(dir, number, grid, matches, EncodeWithOpenCv);
}

}  // namespace crsm
