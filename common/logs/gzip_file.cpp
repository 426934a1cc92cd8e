#include "common/logs/gzip_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "common/logs/regular_file.hpp"
#include "common/logs/stop_request.hpp"

namespace crsm {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{1} << 16;

}  // namespace

GzipFile::GzipFile(const std::string& path)
    : path_(path), file_(gzdopen(OpenRegularFile(path, O_RDONLY), "rb"), gzclose) {
  if (!file_) throw std::runtime_error(fmt::format("cannot read {}: there is no memory", path));
  gzbuffer(file_.get(), kChunkBytes);
  std::error_code error;
  file_bytes_ = std::filesystem::file_size(path, error);
  if (error) file_bytes_ = 0;
}

std::string_view GzipFile::Peek(std::size_t size) {
  if (end_ - begin_ < size && !at_end_) {
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_),
              buffer_.begin() + static_cast<std::ptrdiff_t>(end_), buffer_.begin());
    end_ -= begin_;
    begin_ = 0;
    while (end_ < size && !at_end_) {
      // Twice of what is there: each byte is copied a bounded number of times however little is taken at once.
      buffer_.resize(std::max(buffer_.size(), 2 * end_ + kChunkBytes));
      FillBuffer();
    }
  }
  return {buffer_.data() + begin_, end_ - begin_};
}

void GzipFile::FillBuffer() {
  while (end_ < buffer_.size() && !at_end_) {
    if (StopRequested()) {
      at_end_ = true;
      return;
    }
    const auto wanted = static_cast<unsigned>(std::min(buffer_.size() - end_, kChunkBytes));
    const int got = gzread(file_.get(), buffer_.data() + end_, wanted);
    if (got > 0) {
      end_ += static_cast<std::size_t>(got);
      read_bytes_ += static_cast<std::uint64_t>(got);
      continue;
    }
    at_end_ = true;
    int error = Z_OK;
    gzerror(file_.get(), &error);
    if (error == Z_ERRNO) throw std::runtime_error(fmt::format("cannot read {}: {}", path_, std::strerror(errno)));
    truncated_ = error != Z_OK && error != Z_STREAM_END;
  }
}

std::optional<GzipFile::Line> GzipFile::ReadLine() {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";  // which some editors put before a text
  if (!std::exchange(is_within_, true) && Peek(kByteOrderMark.size()).starts_with(kByteOrderMark)) {
    Skip(kByteOrderMark.size());
  }
  bool too_long = false;
  std::size_t searched = 0;
  while (true) {
    const std::string_view ahead = Peek(searched + 1);
    if (ahead.empty() && !too_long) return std::nullopt;
    const std::size_t end = ahead.find('\n', searched);
    const bool found = end != std::string_view::npos;
    if (found || ahead.size() == searched) {  // ... or nothing more came: the last line
      const std::string_view text = ahead.substr(0, found ? end : ahead.size());
      Skip(text.size() + (found ? 1 : 0));
      too_long = too_long || text.size() > kMaxLineBytes;
      return Line{too_long ? std::string_view{} : text, too_long};
    }
    searched = ahead.size();
    if (searched > kMaxLineBytes) {
      too_long = true;
      Skip(searched);
      searched = 0;
    }
  }
}

bool GzipFile::is_compressed() const { return gzdirect(file_.get()) == 0; }

double GzipFile::Progress() const {
  if (at_end_ && begin_ == end_) return 1.0;
  if (file_bytes_ == 0 || read_bytes_ == 0) return 0.0;
  // zlib knows how far it is in the compressed file; of what it has given, a part still waits in the buffer.
  const double read = static_cast<double>(gzoffset(file_.get())) / static_cast<double>(file_bytes_);
  const double taken = 1.0 - static_cast<double>(end_ - begin_) / static_cast<double>(read_bytes_);
  return std::clamp(read * taken, 0.0, 1.0);
}

}  // namespace crsm
