#include "services/journal/results_lock.hpp"

#include <fmt/core.h>

#include <stdexcept>
#include <utility>

#include "services/journal/journal.hpp"

namespace crsm {

ResultsLock::ResultsLock(std::string flag, std::filesystem::path out)
    : flag_(std::move(flag)), out_(std::move(out)), folder_(flag_, out_) {
  std::error_code error;
  if (std::filesystem::is_directory(out_ / "log", error)) log_.emplace(flag_, out_ / "log");
  Renew();
}

void ResultsLock::Renew() {
  const std::filesystem::path path = JournalPath(JournalFolder(out_));
  if ((journal_ && journal_->IsInPlace()) || !std::filesystem::exists(path)) return;
  journal_.reset();
  journal_.emplace(flag_, path);
}

void ResultsLock::CheckIsInPlace() const {
  if (folder_.IsInPlace() && journal_ && journal_->IsInPlace()) return;
  throw std::runtime_error(
      fmt::format("{} {}: this folder or its journal was removed, moved or replaced meanwhile: no results are written; "
                  "the journal has all scans",
                  flag_, out_.string()));
}

}  // namespace crsm
