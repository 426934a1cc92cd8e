#include "common/results/results.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <functional>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include "common/metrics/trajectory.hpp"
#include "common/results/pictures.hpp"

namespace crsm {

namespace {

/// Writes all the bytes. False, with errno set, if that fails.
bool WriteAll(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

/// Files of a folder that take the place of older ones together, once all of them are on the disk: one that fills up
/// leaves the older ones as they were.
class Replacement {
 public:
  explicit Replacement(std::filesystem::path dir) : dir_(std::move(dir)) {}
  Replacement(const Replacement&) = delete;
  ~Replacement() {
    for (const std::string& name : names_) unlink(Temporary(name).c_str());
  }

  void Write(const std::string& name, std::string_view bytes) {
    Write(name, [bytes](const Sink& sink) { sink(bytes); });
  }

  /// A file that is made piece by piece, so that it need not fit into memory.
  void Write(const std::string& name, const std::function<void(const Sink&)>& produce) {
    names_.push_back(name);
    const int descriptor = open(Temporary(name).c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (descriptor < 0) Fail(name, errno);
    int error = 0;
    produce([&](std::string_view bytes) {
      if (error == 0 && !WriteAll(descriptor, bytes)) error = errno;
      return error == 0;
    });
    if (error == 0 && fsync(descriptor) != 0) error = errno;
    close(descriptor);
    if (error != 0) Fail(name, error);
  }

  void Rename() {
    for (const std::string& name : names_) {
      if (rename(Temporary(name).c_str(), (dir_ / name).c_str()) != 0) Fail(name, errno);
    }
    names_.clear();
  }

 private:
  /// Bears the process id, so that two processes with the same folder never mix their bytes.
  std::filesystem::path Temporary(const std::string& name) const {
    return dir_ / fmt::format(".{}.{}.tmp", name, getpid());
  }
  [[noreturn]] void Fail(const std::string& name, int error) const {
    throw std::runtime_error(fmt::format("cannot write {}: {}", (dir_ / name).string(), std::strerror(error)));
  }

  std::filesystem::path dir_;
  std::vector<std::string> names_;  ///< of temporary files
};

void CheckSize(const DenseGrid& grid) {
  const bool negative = grid.width_cells < 0 || grid.height_cells < 0;
  const auto num_cells = static_cast<std::size_t>(grid.width_cells) * static_cast<std::size_t>(grid.height_cells);
  if (negative || num_cells != grid.cells.size() || (num_cells > 0 && !(grid.cell_size_m > 0.0))) {
    throw std::invalid_argument(fmt::format("WriteResults: a grid of {} x {} cells of {} m cannot hold {} cells",
                                            grid.width_cells, grid.height_cells, grid.cell_size_m, grid.cells.size()));
  }
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

DenseGrid MakeUnexploredCell(double cell_size_m) {
  return {1, 1, 0, 0, cell_size_m > 0.0 ? cell_size_m : 1.0, {kUnexploredByte}};
}

std::string FormatMapYaml(const DenseGrid& grid) {
  // map_server takes (255 - byte) / 255 for the probability that a cell is occupied.
  return fmt::format(
      "image: map.png\n"
      "resolution: {}\n"
      "origin: [{:.6f}, {:.6f}, 0.0]\n"
      "negate: 0\n"
      "occupied_thresh: 0.65\n"
      "free_thresh: 0.196\n",
      grid.cell_size_m, grid.origin_x_cells * grid.cell_size_m, grid.origin_y_cells * grid.cell_size_m);
}

}  // namespace

void WriteResults(const std::filesystem::path& dir, const Results& results) {
  CheckSize(results.grid);
  if (results.grid.cells.empty()) {
    Results drawable = results;
    drawable.grid = MakeUnexploredCell(results.grid.cell_size_m);
    return WriteResults(dir, drawable);
  }
  std::error_code error;
  std::filesystem::create_directories(dir, error);
  if (error) throw std::runtime_error(fmt::format("cannot make the folder {}: {}", dir.string(), error.message()));
  Replacement files(dir);
  files.Write("map.png", EncodeMap(results.grid));
  files.Write("map.yaml", FormatMapYaml(results.grid));
  files.Write("overview.png", EncodeOverview(results));
  files.Write("trajectory.tum", [&](const Sink& sink) {
    results.trajectory_text ? results.trajectory_text(sink) : FormatTrajectory(results.matches, sink);
  });
  if (!results.truth.empty()) files.Write("truth.tum", FormatTrajectory(results.truth));
  files.Write("summary.json", results.summary_json);
  files.Rename();
}

}  // namespace crsm
