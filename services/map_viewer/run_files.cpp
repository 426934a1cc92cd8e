#include "services/map_viewer/run_files.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <ctime>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "common/logs/regular_file.hpp"
#include "common/logs/stop_request.hpp"
#include "common/logs/temporary_file.hpp"
#include "common/results/map_edits.hpp"
#include "services/journal/run_folder.hpp"
#include "services/map_viewer/mcap_export.hpp"

namespace crsm {
namespace {

constexpr std::string_view kMcap = "run.mcap";

struct Kind {
  std::string_view name;
  const char* content_type;
};
constexpr std::array<Kind, 15> kStoredFiles{{{"map.png", "image/png"},
                                             {"map.pgm", "image/x-portable-graymap"},
                                             {"map.yaml", "text/plain; charset=utf-8"},
                                             {"overview.png", "image/png"},
                                             {"trajectory.tum", "text/plain; charset=utf-8"},
                                             {"graph.g2o", "text/plain; charset=utf-8"},
                                             {"changes.csv", "text/csv; charset=utf-8"},
                                             {"summary.json", "application/json"},
                                             {"marks.csv", "text/csv; charset=utf-8"},
                                             {"marks.geojson", "application/geo+json"},
                                             {"map.tif", "image/tiff"},
                                             {"keepout.png", "image/png"},
                                             {"keepout.yaml", "text/plain; charset=utf-8"},
                                             {"slow.png", "image/png"},
                                             {"slow.yaml", "text/plain; charset=utf-8"}}};

/// A file in a folder.
class StoredFile : public Download {
 public:
  /// Throws std::runtime_error if it is not there, or no regular file: a link may lead out of the folder.
  explicit StoredFile(const std::filesystem::path& path) : descriptor_(OpenRegularFile(path, O_RDONLY | O_NOFOLLOW)) {
    struct stat status {};
    if (fstat(descriptor_, &status) == 0) size_ = static_cast<std::uint64_t>(status.st_size);
  }
  ~StoredFile() override { close(descriptor_); }
  StoredFile(const StoredFile&) = delete;

  std::uint64_t size() const override { return size_; }

  void Read(std::uint64_t offset, std::span<std::uint8_t> bytes) const override {
    while (!bytes.empty()) {
      const ssize_t num = pread(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
      if (num < 0 && errno == EINTR) continue;
      if (num <= 0) throw std::runtime_error("a file has become shorter, or cannot be read");
      offset += static_cast<std::uint64_t>(num);
      bytes = bytes.subspan(static_cast<std::size_t>(num));
    }
  }

 private:
  int descriptor_;
  std::uint64_t size_ = 0;
};

/// One that was made for a client.
class MadeFile : public Download {
 public:
  explicit MadeFile(TemporaryFile file) : file_(std::move(file)) {}
  std::uint64_t size() const override { return file_.size(); }
  void Read(std::uint64_t offset, std::span<std::uint8_t> bytes) const override { file_.Read(offset, bytes); }

 private:
  TemporaryFile file_;
};

std::unique_ptr<StoredFile> FindStored(const std::filesystem::path& path) {
  try {
    return std::make_unique<StoredFile>(path);
  } catch (const std::runtime_error&) {
    return nullptr;
  }
}

WebFile MakeFile(const Kind& kind, std::shared_ptr<const Download> bytes) {
  return {std::string(kind.name), kind.content_type, std::move(bytes)};
}

/// Appends a file of less than 8 GiB: a block that says what it is, then its blocks. Source: POSIX pax, "ustar
/// Interchange Format".
void AppendToTar(const char* name, const Download& file, TemporaryFile& tar) {
  constexpr std::size_t kBlock = 512;
  std::string head(kBlock, '\0');
  const auto Put = [&](std::size_t at, const std::string& text) { head.replace(at, text.size(), text); };
  Put(0, name);
  Put(100, "0000644");                                   // mode
  Put(108, "0000000");                                   // owner
  Put(116, "0000000");                                   // group
  Put(124, fmt::format("{:011o}", file.size()));         // bytes
  Put(136, fmt::format("{:011o}", std::time(nullptr)));  // of the last change
  Put(148, "        ");                                  // checksum, until it is known
  Put(156, "0");                                         // a regular file
  Put(257, std::string("ustar\0"
                       "00",
                       8));
  unsigned checksum = 0;
  for (const char c : head) checksum += static_cast<unsigned char>(c);
  Put(148, fmt::format("{:06o}", checksum) + '\0');
  tar.Append({reinterpret_cast<const std::uint8_t*>(head.data()), head.size()});
  std::vector<std::uint8_t> piece;
  for (std::uint64_t at = 0; at < file.size(); at += piece.size()) {
    constexpr std::uint64_t kPieceBytes = 128 * kBlock;
    const auto num = static_cast<std::size_t>(std::min(kPieceBytes, file.size() - at));
    piece.assign((num + kBlock - 1) / kBlock * kBlock, 0);
    file.Read(at, std::span(piece).first(num));
    tar.Append(piece);
  }
}

}  // namespace

/// A run.mcap on its way. `file` and `error` belong to the thread until it is done.
struct RunFiles::Job {
  std::size_t robot = 0;
  std::atomic<bool> done = false;
  std::shared_ptr<const Download> file;
  std::string error;
};

RunFiles::~RunFiles() {
  if (worker_.joinable()) worker_.join();
}

WebPage RunFiles::List(std::size_t robot) const {
  auto list = nlohmann::json::array();
  if (robot < folders_.size()) {
    for (const Kind& kind : kStoredFiles) {
      const auto file = FindStored(std::filesystem::path(folders_[robot]) / kind.name);
      if (file) list.push_back({{"name", kind.name}, {"bytes", file->size()}});
    }
    if (FindStored(std::filesystem::path(folders_[robot]) / kEditedFiles.front())) {
      list.push_back({{"name", kEditedMap}, {"bytes", nullptr}});
    }
    if (FindRun(folders_[robot]).piece == 1) list.push_back({{"name", kMcap}, {"bytes", nullptr}});
  }
  return {200, "application/json", list.dump() + "\n"};
}

WebAnswer RunFiles::Find(std::size_t robot, std::string_view name) {
  const auto* kind =
      std::find_if(kStoredFiles.begin(), kStoredFiles.end(), [&](const Kind& known) { return known.name == name; });
  if (kind == kStoredFiles.end() && name != kMcap && name != kEditedMap)
    return Refuse(404, "no file of a run has this name");
  if (robot >= folders_.size()) return Refuse(404, fmt::format("{}: there when the run has ended", name));
  if (name == kMcap) return MakeMcap(robot);
  if (name == kEditedMap) return MakeEditedMap(robot);
  std::shared_ptr<const StoredFile> file = FindStored(std::filesystem::path(folders_[robot]) / name);
  if (!file) return Refuse(404, fmt::format("{}: this run has no such file", name));
  if (file->size() > most_bytes_) {
    return Refuse(500, fmt::format("{}: has {} bytes, and no more than {} are sent; copy it from the folder of the run",
                                   name, file->size(), most_bytes_));
  }
  return MakeFile(*kind, std::move(file));
}

WebAnswer RunFiles::MakeEditedMap(std::size_t robot) const {
  TemporaryFile tar;
  std::vector<const char*> names(kEditedFiles.begin(), kEditedFiles.end());
  names.push_back(kEditsFile);
  try {
    for (const char* name : names) {
      const auto file = FindStored(std::filesystem::path(folders_[robot]) / name);
      if (!file && name == kEditedFiles.front()) return Refuse(404, "the map of this run is not edited");
      if (!file) continue;
      if (tar.size() + file->size() > most_bytes_) return Refuse(500, "the edited map is larger than what is sent");
      AppendToTar(name, *file, tar);
    }
    constexpr std::array<std::uint8_t, 1024> kEndOfTar{};
    tar.Append(kEndOfTar);
    tar.Flush();
  } catch (const std::runtime_error& error) {
    return Refuse(500, fmt::format("{}: {}", kEditedMap, error.what()));
  }
  return MakeFile({kEditedMap, "application/x-tar"}, std::make_shared<MadeFile>(std::move(tar)));
}

WebAnswer RunFiles::MakeMcap(std::size_t robot) {
  auto job = job_.lock();
  if (job && !job->done && job->robot != robot) {
    return Refuse(503, fmt::format("{}: that of another run is being made; try again in a moment", kMcap));
  }
  if (!job || job->robot != robot) {
    if (worker_.joinable()) worker_.join();  // which is done, or about to end, since nobody waits
    job = std::make_shared<Job>();
    job->robot = robot;
    job_ = job;
    worker_ = std::thread([job, folder = folders_[robot], most_bytes = most_bytes_]() mutable {
      constexpr int kNice = 10;
      setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);  // those who watch the map go first
      try {
        TemporaryFile file;
        const auto Append = [&](std::string_view bytes) {
          if (file.size() + bytes.size() > most_bytes) {
            throw std::runtime_error(fmt::format(
                "has more than {} bytes, and no more are sent; map_viewer DIR --mcap FILE writes it", most_bytes));
          }
          file.Append({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
          return true;
        };
        WriteMcap(folder, Append, [&](std::int64_t, double) { return StopRequested() || job.use_count() == 1; });
        file.Flush();
        job->file = std::make_shared<MadeFile>(std::move(file));
      } catch (const std::exception& error) {
        job->error = error.what();
      }
      job->done = true;
    });
  }
  return WebLater{[job]() -> std::optional<WebReply> {
    if (!job->done) return std::nullopt;
    if (!job->file) return Refuse(500, fmt::format("{}: {}", kMcap, job->error));
    return MakeFile({kMcap, "application/octet-stream"}, job->file);
  }};
}

}  // namespace crsm
