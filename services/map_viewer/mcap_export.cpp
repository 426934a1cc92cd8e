#include "services/map_viewer/mcap_export.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <stdexcept>

#include "common/logs/replacement.hpp"
#include "common/logs/stop_request.hpp"
#include "services/base/file_window.hpp"
#include "services/base/process.hpp"
#include "services/base/progress.hpp"
#include "services/map_viewer/finished_run.hpp"
#include "services/map_viewer/foxglove_scene.hpp"
#include "services/map_viewer/mcap_writer.hpp"

namespace crsm {
namespace {

/// Writes what has changed of a scene since it was asked last.
class Recorder {
 public:
  Recorder(const Scene& scene, const Sink& sink) : foxglove_(scene, ""), writer_(sink) {}

  void Record() {
    for (const FoxgloveTopic& topic : foxglove_.Topics()) {
      const ChangeNumber last = foxglove_.LastChange(topic);
      if (last == 0) continue;
      auto known = told_.find(topic);
      if (known == told_.end()) {
        const std::uint16_t channel = writer_.AddChannel(
            {foxglove_.NameOf(topic), FoxgloveScene::SchemaNameOf(topic), FoxgloveScene::SchemaOf(topic)});
        known = told_.emplace(topic, Told{channel, 0}).first;
      }
      if (known->second.change == last) continue;
      known->second.change = last;
      writer_.Write(known->second.channel, foxglove_.time_ns(), foxglove_.Encode(topic));
    }
  }

  void Finish() { writer_.Finish(); }

 private:
  struct Told {
    std::uint16_t channel;
    ChangeNumber change;
  };
  FoxgloveScene foxglove_;
  McapWriter writer_;
  std::map<FoxgloveTopic, Told> told_;
};

/// What is there and is no MCAP file was hardly meant: a journal, say, or a device.
void CheckReplaceable(const std::filesystem::path& file) {
  constexpr std::string_view kMagic = "\x89MCAP";
  std::error_code error;
  if (!std::filesystem::exists(std::filesystem::symlink_status(file, error))) return;
  if (!std::filesystem::is_regular_file(std::filesystem::symlink_status(file, error))) {
    throw std::runtime_error(fmt::format("--mcap {}: is no regular file; choose another one", file.string()));
  }
  const std::string start(FileWindow(file.string()).At(0, kMagic.size()));
  if (start.empty() || start == kMagic) return;
  throw std::runtime_error(
      fmt::format("--mcap {}: is no MCAP file, and would be overwritten; choose another one", file.string()));
}

}  // namespace

void WriteMcap(const std::string& results, const std::filesystem::path& file) {
  CheckReplaceable(file);
  CatchSignals();
  Replacement replacement(file.has_parent_path() ? file.parent_path() : ".");
  Progress progress("map_viewer");
  std::int64_t num_written = 0;
  replacement.Write(file.filename(), [&](const Sink& sink) {
    WriteMcap(results, sink, [&](std::int64_t num_scans, double share) {
      progress.Show([share] { return share; }, num_written = num_scans);
      return StopRequested();
    });
  });
  progress.Finish(num_written);
  replacement.Rename();
}

void WriteMcap(const std::string& results, const Sink& sink,
               const std::function<bool(std::int64_t num_scans, double share)>& is_stopped) {
  constexpr std::size_t kTimes = 50;  // that the map is written
  Scene scene(results);
  Recorder recorder(scene, sink);
  const std::size_t num_scans = CountScans(results);
  const std::size_t step = std::max<std::size_t>(1, num_scans / kTimes);
  std::size_t done = 0;
  ReplayRun(results, step, scene, [&](const Mapper&) {
    done = std::min(done + 1, num_scans);  // the end is told as well
    if (is_stopped(static_cast<std::int64_t>(done), static_cast<double>(done) / static_cast<double>(num_scans)))
      throw std::runtime_error("stopped; nothing was written");
    recorder.Record();
  });
  recorder.Finish();
}

}  // namespace crsm
