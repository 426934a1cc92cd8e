#include "services/journal/journal_lock.hpp"

#include <fmt/core.h>

#include <stdexcept>
#include <utility>

#include "services/journal/journal.hpp"

namespace crsm {

JournalLock::JournalLock(std::filesystem::path out) : out_(std::move(out)) { Renew(); }

void JournalLock::Renew() {
  const std::filesystem::path path = JournalPath(JournalFolder(out_));
  if ((lock_ && lock_->IsInPlace()) || !std::filesystem::exists(path)) return;
  lock_.reset();
  lock_.emplace("--out", path);
}

void JournalLock::CheckIsInPlace() const {
  if (lock_ && lock_->IsInPlace()) return;
  throw std::runtime_error(
      fmt::format("--out {}: this folder or its journal was removed or moved meanwhile: no results are written; the "
                  "journal has all scans",
                  out_.string()));
}

}  // namespace crsm
