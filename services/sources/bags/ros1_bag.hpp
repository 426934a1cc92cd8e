#pragma once

#include "services/sources/bags/chunked_bag.hpp"

namespace crsm {

/// A ROS 1 bag of format 2.0, chunks plain or compressed by bz2 or lz4. One whose recording was killed has no index,
/// and is read as far as it goes. Source: wiki.ros.org/Bags/Format/2.0.
class Ros1Bag : public ChunkedBag {
 public:
  static bool Is(std::string_view start);

  /// Throws std::runtime_error if the file cannot be opened, or is of another version.
  Ros1Bag(const std::string& path, const WantTopic& want);

  std::optional<std::vector<BagTopic>> ListedTopics() override;

 private:
  struct Record;
  static std::optional<Record> RecordAt(ByteRange& bytes, std::uint64_t at);
  static std::optional<BagTopic> ReadConnection(ByteRange& bytes, const Record& record);

  bool TakeRecord(ByteRange& bytes, std::uint64_t& at, std::optional<BagMessage>& message) override;
  void TakeChunk(const Record& record, std::uint64_t& at);
  bool EndsInOrder() const override;

  std::uint64_t index_at_ = 0;  ///< in the file; 0 if it was not written
  std::uint32_t num_connections_ = 0;
};

}  // namespace crsm
