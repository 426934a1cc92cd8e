#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "services/base/file_window.hpp"
#include "services/sources/bags/bag_reader.hpp"

namespace crsm {

/// A file of records, some of which are chunks that hold more of them: what ROS 1 bags and MCAP files share. One chunk
/// at a time is in memory, and of those that are not compressed a window.
class ChunkedBag : public BagReader {
 public:
  std::optional<BagMessage> Next() final;
  double Progress() const final;
  BagDamage damage() const final { return damage_; }

 protected:
  /// Where the records of the file begin.
  ChunkedBag(const std::string& path, std::uint64_t begin, WantTopic want)
      : file_(path), at_(begin), want_(std::move(want)) {}

  /// Takes the record at `at` in a file or a chunk, moves `at` behind it, and leaves in `message` what is wanted. False
  /// if no whole record begins there, nor a chunk that the end of the file cuts.
  virtual bool TakeRecord(ByteRange& bytes, std::uint64_t& at, std::optional<BagMessage>& message) = 0;

  /// Whether the end of the file is where it was meant to be.
  virtual bool EndsInOrder() const = 0;

  struct Chunk {
    std::string compression;  ///< empty for none
    std::uint64_t begin = 0;  ///< of its bytes, in the file
    std::uint64_t num_bytes = 0;
    std::uint64_t num_unpacked_bytes = 0;  ///< the most that they may be, where the chunk is cut
    std::uint32_t crc = 0;                 ///< of what is unpacked; 0: unknown
    bool is_cut = false;                   ///< the file ends before it does
  };
  /// The records of a chunk come next. One that is damaged is counted and passed over.
  void OpenChunk(const Chunk& chunk);

  /// Keeps under which number the file knows a topic.
  void AddTopic(std::uint32_t number, const BagTopic& topic);
  /// The name of a topic that is wanted; nullptr for others.
  const std::string* WantedTopic(std::uint32_t number) const;

  /// Nothing follows.
  void End() { ended_ = true; }

  FileWindow& file() { return file_; }
  const FileWindow& file() const { return file_; }

 private:
  FileWindow file_;
  std::uint64_t at_;
  std::unique_ptr<ByteRange> chunk_;
  std::uint64_t chunk_at_ = 0;
  bool chunk_is_cut_ = false;
  WantTopic want_;
  std::map<std::uint32_t, std::string> wanted_;  ///< names by number
  bool ended_ = false;
  BagDamage damage_;
};

}  // namespace crsm
