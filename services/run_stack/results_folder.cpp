#include "services/run_stack/results_folder.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "common/logs/regular_file.hpp"
#include "common/results/read_results.hpp"
#include "services/base/process.hpp"
#include "services/journal/journal.hpp"

namespace crsm {

namespace fs = std::filesystem;

ResultsFolder::ResultsFolder(const fs::path& out, const EarlierResults& earlier)
    : out_(out), made_from_(earlier.resume.empty() ? "" : ReadMadeFrom(earlier.resume)) {
  PrepareFolder(out_.string());
  const PathLock out_lock("--out", out_);  // for the time being: map_exporter will want it
  std::error_code error;
  if (fs::exists(log_folder(), error)) log_lock_.emplace("--out", log_folder());
  MakeRoom("run_stack", out_, earlier);
  fs::create_directories(log_folder(), error);
  if (error) throw std::runtime_error(fmt::format("--out {}: cannot be written: {}", out_.string(), error.message()));
  log_lock_.reset();
  log_lock_.emplace("--out", log_folder());
  fs::rename(summary(), earlier_summary(), error);  // so that none of an earlier run is taken for one of this
}

ResultsFolder::~ResultsFolder() {
  std::error_code error;
  if (!fs::exists(summary(), error)) fs::rename(earlier_summary(), summary(), error);
  fs::remove(earlier_summary(), error);
}

std::optional<std::uintmax_t> ResultsFolder::JournalBytes() const {
  std::error_code error;
  const auto size = fs::file_size(JournalPath(journal_folder()), error);
  return error ? std::nullopt : std::optional(size);
}

std::string ResultsFolder::WhyNotWritable() const {
  const std::string block(4096, '\0');  // a name alone may find room on a full disk
  const fs::path path = log_folder() / ".probe";
  std::string why;
  try {
    const int descriptor = OpenRegularFile(path, O_WRONLY | O_CREAT);
    if (write(descriptor, block.data(), block.size()) < std::ssize(block)) why = std::strerror(errno);
    close(descriptor);
  } catch (const std::runtime_error& error) {
    why = error.what();
  }
  std::error_code ignored;
  fs::remove(path, ignored);
  return why;
}

bool ResultsFolder::IsInPlace() {
  const bool has_journal = JournalBytes().has_value();
  had_journal_ = had_journal_ || has_journal;
  return log_lock_->IsInPlace() && has_journal == had_journal_ && (!has_journal || HasOwnJournal());
}

bool ResultsFolder::HasOwnJournal() {
  try {
    const auto head = ReadHead(journal_folder());
    if (!identity_ && head) identity_ = head->epoch;
    return !identity_ || (head && head->epoch == *identity_);
  } catch (const std::runtime_error&) {  // it was removed meanwhile
    return false;
  }
}

}  // namespace crsm
