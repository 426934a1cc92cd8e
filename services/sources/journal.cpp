#include "services/sources/journal.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <stdexcept>

#include "services/runtime/bus.hpp"
#include "services/runtime/conversions.hpp"
#include "services/runtime/service.hpp"
#include "services/sources/lcm_event_log.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

fs::path PathIn(const fs::path& folder) { return folder / "journal.lcm"; }

const char* EpochChannel(bool finished_map) { return finished_map ? kFinishedMapEpochChannel : kMapEpochChannel; }

/// What was read of a journal besides its entries.
struct Contents {
  std::int64_t epoch = 0;  ///< 0: it does not say
  std::int64_t last_utime = 0;
  std::uintmax_t whole_bytes = 0;
};

void CheckSubject(const std::string& path, const std::string& channel, const map_delta_t& head,
                  const JournalSubject& subject) {
  if (channel != EpochChannel(subject.finished_map)) {
    throw std::runtime_error(
        subject.finished_map
            ? fmt::format("{} is of a run that made a map: a localization needs a journal of its own", path)
            : fmt::format("{} is of a run that localised on the map of another folder: name that folder", path));
  }
  if (head.cell_size_m != subject.cell_size_m) {
    throw std::runtime_error(
        fmt::format("{}: its map has cells of {} m, not of {} m: give the --preset or --cell-size-m of its first run",
                    path, head.cell_size_m, subject.cell_size_m));
  }
}

Contents Read(const std::string& path, const JournalSubject& subject, const VisitJournal& visit) {
  LcmEventLog log(path);
  std::optional<CriticalRays> scan;
  Contents contents;
  while (const auto event = log.Next()) {
    if (const auto rays = Decode<critical_rays_t>(Bytes(event->data))) {
      scan = FromMessage(*rays);
    } else if (const auto message = Decode<scan_match_t>(Bytes(event->data))) {
      const ScanMatch match = FromMessage(*message);
      visit(scan && scan->utime == match.utime ? &*scan : nullptr, match);
      contents.last_utime = std::max(contents.last_utime, match.utime);
    } else if (const auto head = Decode<map_delta_t>(Bytes(event->data))) {
      CheckSubject(path, event->channel, *head, subject);
      contents.epoch = head->epoch;
    }
  }
  if (log.num_bad_events() > 0) {
    throw std::runtime_error(fmt::format("{} is damaged in {} places: its map would not be the one that was made", path,
                                         log.num_bad_events()));
  }
  contents.whole_bytes = log.whole_bytes();
  return contents;
}

}  // namespace

Journal::Journal(const fs::path& folder, const JournalSubject& subject) : subject_(subject), epoch_(DrawIdentity()) {
  const fs::path path = PathIn(folder);
  if (fs::exists(path)) {
    throw std::runtime_error(
        fmt::format("{} is there already: --resume goes on with it; or choose another folder", path.string()));
  }
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    throw std::runtime_error(fmt::format("--journal {}: cannot be written: {}", folder.string(), error.message()));
  }
  log_.emplace(path.string(), EventLogWriter::Mode::kNew);
}

Journal::Journal(const fs::path& folder, const JournalSubject& subject, const VisitJournal& visit) : subject_(subject) {
  const fs::path path = PathIn(folder);
  const Contents contents = Read(path.string(), subject, visit);
  epoch_written_ = contents.epoch != 0;
  epoch_ = epoch_written_ ? contents.epoch : DrawIdentity();
  num_cut_bytes_ = fs::file_size(path) - contents.whole_bytes;
  if (num_cut_bytes_ > 0) fs::resize_file(path, contents.whole_bytes);
  log_.emplace(path.string(), EventLogWriter::Mode::kAppend, contents.last_utime);
}

void Journal::Append(const CriticalRays* scan, const ScanMatch& match) {
  if (!epoch_written_) {  // with a scan's utime, so that lcm-logplayer does not wait for decades after it
    map_delta_t head{};
    head.utime = match.utime;
    head.epoch = epoch_;
    head.cell_size_m = subject_.cell_size_m;
    head.num_parts = 1;
    head.asked_utime = -1;
    log_->Write(EpochChannel(subject_.finished_map), head);
    epoch_written_ = true;
  }
  if (scan) log_->Write(kCriticalRaysChannel, ToMessage(*scan));
  log_->Write(kScanMatchChannel, ToMessage(match));
  log_->Flush();
}

void ReadJournal(const fs::path& folder, const JournalSubject& subject, const VisitJournal& visit) {
  Read(PathIn(folder).string(), subject, visit);
}

void TakeOverJournal(const fs::path& earlier, const fs::path& out) {
  const fs::path from = PathIn(JournalFolder(earlier));
  const fs::path to = PathIn(JournalFolder(out));
  std::error_code error;
  if (!fs::exists(from, error)) throw std::runtime_error(fmt::format("there is no file {}", from.string()));
  if (fs::equivalent(from, to, error)) return;
  fs::path half = to;
  half += ".tmp";  // a copy that was cut short is no journal
  fs::create_directories(to.parent_path(), error);
  if (!error) fs::copy_file(from, half, fs::copy_options::overwrite_existing, error);
  if (!error) fs::rename(half, to, error);
  if (error) {
    throw std::runtime_error(fmt::format("{} cannot be copied to {}: {}", from.string(), to.string(), error.message()));
  }
}

void RemoveJournal(const fs::path& out) { fs::remove(PathIn(JournalFolder(out))); }

}  // namespace crsm
