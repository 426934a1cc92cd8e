#include "services/sources/bags/chunked_bag.hpp"

#include <algorithm>

#include "common/logs/crc32.hpp"
#include "common/logs/stop_request.hpp"
#include "services/sources/bags/decompress.hpp"

namespace crsm {
namespace {

/// A part of a file.
class FilePart : public ByteRange {
 public:
  FilePart(FileWindow& file, std::uint64_t begin, std::uint64_t size) : file_(file), begin_(begin), size_(size) {}

  std::uint64_t size() const override { return size_; }
  std::string_view At(std::uint64_t offset, std::size_t count) override {
    offset = std::min(offset, size_);
    return file_.At(begin_ + offset, static_cast<std::size_t>(std::min<std::uint64_t>(count, size_ - offset)));
  }

 private:
  FileWindow& file_;
  std::uint64_t begin_;
  std::uint64_t size_;
};

std::uint32_t ComputeCrc(ByteRange& bytes) {
  constexpr std::size_t kPieceBytes = std::size_t{1} << 18;
  std::uint32_t crc = 0;
  for (std::uint64_t at = 0; at < bytes.size();) {
    const std::string_view piece = bytes.At(at, kPieceBytes);
    if (piece.empty()) break;  // the file was cut off meanwhile
    crc = Crc32(piece, crc);
    at += piece.size();
  }
  return crc;
}

}  // namespace

std::optional<BagMessage> ChunkedBag::Next() {
  while (!ended_ && !StopRequested()) {
    std::optional<BagMessage> message;
    if (chunk_) {
      const bool is_over = chunk_at_ >= chunk_->size();
      if (is_over || !TakeRecord(*chunk_, chunk_at_, message)) {
        if (!is_over && !chunk_is_cut_) ++damage_.num_bad_chunks;
        chunk_.reset();
      }
    } else if (at_ >= file_.size() || !TakeRecord(file_, at_, message)) {
      damage_.truncated = at_ < file_.size() || !EndsInOrder();
      ended_ = true;
    }
    if (message) return message;
  }
  return std::nullopt;
}

void ChunkedBag::OpenChunk(const Chunk& chunk) {
  std::unique_ptr<ByteRange> opened;
  if (chunk.compression.empty()) {
    opened = std::make_unique<FilePart>(file_, chunk.begin, chunk.num_bytes);
  } else if (chunk.num_bytes <= kMostChunkBytes) {
    const auto num_bytes = static_cast<std::size_t>(chunk.num_bytes);
    opened = Decompress({chunk.compression, file_.At(chunk.begin, num_bytes), chunk.num_unpacked_bytes, chunk.is_cut});
  }
  const bool is_checked = chunk.crc != 0 && !chunk.is_cut;
  if (!opened || (is_checked && ComputeCrc(*opened) != chunk.crc)) {
    ++damage_.num_bad_chunks;
    return;
  }
  chunk_ = std::move(opened);
  chunk_at_ = 0;
  chunk_is_cut_ = chunk.is_cut;
}

void ChunkedBag::AddTopic(std::uint32_t number, const BagTopic& topic) {
  if (want_(topic)) {
    wanted_[number] = topic.name;
  } else {
    wanted_.erase(number);
  }
}

const std::string* ChunkedBag::WantedTopic(std::uint32_t number) const {
  const auto found = wanted_.find(number);
  return found == wanted_.end() ? nullptr : &found->second;
}

double ChunkedBag::Progress() const {
  if (ended_ || file_.size() == 0) return 1.0;
  return std::min(1.0, static_cast<double>(at_) / static_cast<double>(file_.size()));
}

}  // namespace crsm
