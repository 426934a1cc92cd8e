#include "services/map_viewer/map_editor.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "common/logs/read_map.hpp"
#include "common/results/json_text.hpp"
#include "common/results/mark_files.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

void WriteEdits(const fs::path& folder, const MapEdits& edits) {
  Replacement files(folder);
  if (!edits.IsEmpty()) AddEditedMap(ReadMap(folder), ReadMarks(folder), edits, files);
  files.RemoveOthers(kEditedFiles);
  files.RemoveOthers(std::array{kEditsFile});
  files.Rename();
}

}  // namespace

MapEditor::MapEditor(std::string folder, Scene& scene) : folder_(std::move(folder)), scene_(scene) {
  const fs::path path = fs::path(folder_) / kEditsFile;
  std::string fault;
  std::error_code ignored;
  try {
    if (fs::exists(path, ignored)) edits_ = ReadMapEdits(path);
  } catch (const std::runtime_error& error) {
    fault = error.what();
  }
  if (access(folder_.c_str(), W_OK) != 0) return;
  scene_.SetEditsHandler([this](std::string_view json) { return Take(json); });
  // A run that went on has another map, and has removed what was made of the earlier one.
  is_wanted_ = !edits_.IsEmpty() && !fs::exists(fs::path(folder_) / kEditedFiles.front(), ignored);
  Tell(!fault.empty() ? "failed" : is_wanted_ ? "writing" : "written", fault);
}

MapEditor::~MapEditor() {
  if (worker_.joinable()) worker_.join();
}

bool MapEditor::Take(std::string_view json) {
  try {
    edits_ = ParseMapEdits(json);
  } catch (const std::runtime_error&) {
    return false;
  }
  is_wanted_ = true;
  Tell("writing");
  return true;
}

void MapEditor::Step() {
  if (job_ && !job_->done) return;
  if (job_) {
    worker_.join();
    const std::unique_ptr<Job> job = std::exchange(job_, nullptr);
    if (!is_wanted_) Tell(job->error.empty() ? "written" : "failed", job->error);
  }
  if (!std::exchange(is_wanted_, false)) return;
  job_ = std::make_unique<Job>();
  worker_ = std::thread([job = job_.get(), folder = folder_, edits = edits_] {
    constexpr int kNice = 10;
    setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);  // those who watch the map go first
    try {
      WriteEdits(folder, edits);
    } catch (const std::exception& error) {
      job->error = error.what();
    }
    job->done = true;
  });
}

void MapEditor::Tell(const char* state, const std::string& why) {
  const nlohmann::json told{{"edits", nlohmann::json::parse(FormatMapEdits(edits_))}, {"state", state}, {"why", why}};
  scene_.SetEdits(ToText(told), state == std::string_view("writing"));
}

}  // namespace crsm
