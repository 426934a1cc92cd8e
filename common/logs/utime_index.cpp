#include "common/logs/utime_index.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>

namespace crsm {
namespace {

constexpr std::size_t kBlockUtimes = 1024;
constexpr std::size_t kBlockBytes = kBlockUtimes * sizeof(std::int64_t);

std::FILE* MakeFile() {
  const char* folder = std::getenv("TMPDIR");
  std::string path = fmt::format("{}/crsm_utimes_XXXXXX", folder && *folder ? folder : "/tmp");
  const int descriptor = mkostemp(path.data(), O_CLOEXEC);
  if (descriptor < 0) throw std::runtime_error(fmt::format("{} cannot be made: {}", path, std::strerror(errno)));
  unlink(path.c_str());
  return fdopen(descriptor, "r+");
}

off_t PlaceOf(std::size_t block, std::size_t byte) { return static_cast<off_t>(block * kBlockBytes + byte); }

}  // namespace

UtimeIndex::UtimeIndex() : file_(MakeFile(), &std::fclose) {}

void UtimeIndex::Add(std::int64_t utime) {
  if (last_.empty()) ranges_.push_back({utime, utime});
  ranges_.back().least = std::min(ranges_.back().least, utime);
  ranges_.back().largest = std::max(ranges_.back().largest, utime);
  largest_ = std::max(largest_, utime);
  last_.push_back(utime);
  if (last_.size() < kBlockUtimes) return;
  WriteBlock(ranges_.size() - 1);
  last_.clear();
}

std::optional<std::int64_t> UtimeIndex::Find(std::int64_t utime) const {
  if (utime > largest_) return std::nullopt;
  for (std::size_t block = 0; block < ranges_.size(); ++block) {
    if (utime < ranges_[block].least || utime > ranges_[block].largest) continue;
    const bool is_last = block == num_written();
    const std::vector<std::int64_t> read = is_last ? std::vector<std::int64_t>() : ReadBlock(block);
    const std::vector<std::int64_t>& utimes = is_last ? last_ : read;
    const auto found = std::find(utimes.begin(), utimes.end(), utime);
    if (found != utimes.end()) return static_cast<std::int64_t>(block * kBlockUtimes) + (found - utimes.begin());
  }
  return std::nullopt;
}

std::int64_t UtimeIndex::size() const { return static_cast<std::int64_t>(num_written() * kBlockUtimes + last_.size()); }

std::size_t UtimeIndex::num_written() const { return last_.empty() ? ranges_.size() : ranges_.size() - 1; }

void UtimeIndex::WriteBlock(std::size_t block) const {
  const char* bytes = reinterpret_cast<const char*>(last_.data());
  for (std::size_t done = 0; done < kBlockBytes;) {  // a disk that is nearly full takes a part at first
    const auto size = pwrite(fileno(file_.get()), bytes + done, kBlockBytes - done, PlaceOf(block, done));
    if (size < 0) {
      throw std::runtime_error(fmt::format("the temporary file of utimes cannot be written: {}", std::strerror(errno)));
    }
    done += static_cast<std::size_t>(size);
  }
}

std::vector<std::int64_t> UtimeIndex::ReadBlock(std::size_t block) const {
  std::vector<std::int64_t> utimes(kBlockUtimes);
  if (pread(fileno(file_.get()), utimes.data(), kBlockBytes, PlaceOf(block, 0)) != static_cast<ssize_t>(kBlockBytes)) {
    throw std::runtime_error(fmt::format("the temporary file of utimes cannot be read: {}", std::strerror(errno)));
  }
  return utimes;
}

}  // namespace crsm
