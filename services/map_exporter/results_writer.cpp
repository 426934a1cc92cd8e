#include "services/map_exporter/results_writer.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "common/results/mark_files.hpp"
#include "common/results/pictures.hpp"
#include "common/results/results.hpp"
#include "services/base/cpu_seconds.hpp"

namespace crsm {
namespace {

constexpr const char* kTrajectory = "trajectory.tum";

}  // namespace

ResultsWriter::ResultsWriter(std::filesystem::path dir) : dir_(std::move(dir)), thread_([this] { Work(); }) {}

ResultsWriter::~ResultsWriter() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

bool ResultsWriter::busy() const {
  const std::lock_guard lock(mutex_);
  return busy_;
}

void ResultsWriter::Start(Snapshot snapshot) {
  {
    const std::lock_guard lock(mutex_);
    waiting_ = std::move(snapshot);
    busy_ = true;
  }
  wake_.notify_one();
}

std::optional<ResultsWriter::Outcome> ResultsWriter::TakeOutcome() {
  const std::lock_guard lock(mutex_);
  return std::exchange(outcome_, std::nullopt);
}

void ResultsWriter::Work() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return waiting_ || ended_; });
    if (!waiting_) return;
    Snapshot snapshot = std::move(*waiting_);
    waiting_.reset();
    lock.unlock();
    Outcome outcome{snapshot.version, snapshot.text, ""};
    const double begun_s = CpuSeconds();
    try {
      Write(snapshot);
    } catch (const std::exception& error) {  // the disk may have room again later
      outcome.error = error.what();
    }
    outcome.cpu_s = CpuSeconds() - begun_s;
    lock.lock();
    outcome_ = std::move(outcome);
    busy_ = false;
  }
}

void ResultsWriter::Write(Snapshot& snapshot) {
  if (snapshot.begun_cell_size_m || !snapshot.tiles.empty()) TakeMap(snapshot);
  snapshot.summary.explored_area_m2 = explored_area_m2_;
  drawn_.matches = std::move(snapshot.path);
  drawn_.last_scan = std::move(snapshot.last_scan);
  drawn_.loops = std::move(snapshot.loops);
  drawn_.pieces = std::move(snapshot.pieces);
  drawn_.marks = std::move(snapshot.marks);
  drawn_.name = NameOfRun(dir_);
  drawn_.summary = snapshot.summary;

  const std::uint64_t text_end = snapshot.text->num_bytes();
  const bool goes_on = TrajectoryGoesOn(snapshot);
  Replacement files(dir_);
  const std::string before = FindPicture(dir_);
  if (!map_written_) {
    const std::string picture = EncodeMap(drawn_.grid, map_encoder_);
    const std::string name = NameNextPicture(dir_);
    files.Write(name, picture);
    files.Write("map.yaml", FormatMapYaml(drawn_.grid, name));
    // Here map.yaml does not name it any more, if it ever did: next time it is written.
    if (before != kMapPicture || !std::filesystem::exists(dir_ / "map.yaml")) files.Write(kMapPicture, picture);
  }
  files.Write("overview.png", EncodeOverview(drawn_, overview_encoder_));
  if (!goes_on) {
    files.Write(kTrajectory, [&](const Sink& sink) { snapshot.text->Copy(0, text_end, sink); });
  }
  if (snapshot.summary.changes) files.Write("changes.csv", FormatChangesCsv(*snapshot.summary.changes));
  AddMarks(drawn_.marks, files);
  files.Write("summary.json", FormatSummary(snapshot.summary));
  if (goes_on) AppendTrajectory(text_end);
  files.Rename();
  if (!map_written_) RemoveOldPictures(dir_, before);
  map_written_ = true;
  text_ = snapshot.text;
  num_text_bytes_ = text_end;
}

void ResultsWriter::TakeMap(const Snapshot& snapshot) {
  if (snapshot.begun_cell_size_m) map_.emplace(*snapshot.begun_cell_size_m);
  for (const auto& [index, cells] : snapshot.tiles) {
    const ByteMap::Tile* tile = map_->tiles().Find(index);
    map_->Apply({index, PackRuns(tile ? tile->cells : kUnexploredBytes, cells)});
  }
  drawn_.grid = map_->ToDenseGrid();
  explored_area_m2_ = ComputeExploredArea(drawn_.grid);
  if (drawn_.grid.cells.empty()) drawn_.grid = MakeUnexploredCell(drawn_.grid.cell_size_m);
  map_written_ = false;
}

/// Whether the file is the one that was written last, and is to have more of the same text.
bool ResultsWriter::TrajectoryGoesOn(const Snapshot& snapshot) const {
  std::error_code error;
  return text_ == snapshot.text && std::filesystem::file_size(dir_ / kTrajectory, error) == num_text_bytes_;
}

/// Where the disk has no room for all of it, nothing is added.
void ResultsWriter::AppendTrajectory(std::uint64_t end) {
  const std::string path = dir_ / kTrajectory;
  const int descriptor = open(path.c_str(), O_WRONLY | O_APPEND | O_NONBLOCK | O_CLOEXEC);
  int error = descriptor < 0 ? errno : 0;
  if (error == 0) {
    std::string lines;  // a reader sees whole ones
    text_->Copy(num_text_bytes_, end, [&](std::string_view piece) {
      lines += piece;
      const std::size_t whole = lines.rfind('\n') + 1;
      if (!WriteAll(descriptor, std::string_view(lines).substr(0, whole))) error = errno;
      lines.erase(0, whole);
      return error == 0;
    });
    if (error == 0 && fdatasync(descriptor) != 0) error = errno;
    if (error != 0 && ftruncate(descriptor, static_cast<off_t>(num_text_bytes_)) != 0) text_.reset();
    close(descriptor);
  }
  if (error != 0) throw std::runtime_error(fmt::format("cannot write {}: {}", path, std::strerror(error)));
  num_text_bytes_ = end;
}

}  // namespace crsm
