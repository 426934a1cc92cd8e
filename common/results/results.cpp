#include "common/results/results.hpp"

#include "common/results/pictures.hpp"
#include "common/results/result_files.hpp"

namespace crsm {
namespace {

std::string EncodeWithOpenCv(const DenseGrid& grid) { return EncodeMap(grid); }

}  // namespace

void WriteResults(const std::filesystem::path& dir, const Results& results) {
  MakeFolder(dir);
  Replacement files(dir);
  AddResults(results, {EncodeWithOpenCv, [](const Results& drawable) { return EncodeOverview(drawable); }}, files);
  FreeMapPicture(dir);
  files.Rename();
  RemoveOldPictures(dir);
}

void WritePiece(const std::filesystem::path& dir, int number, const DenseGrid& grid, const MatchSequence& matches) {
  WritePiece(dir, number, grid, matches, EncodeWithOpenCv);
}

}  // namespace crsm
