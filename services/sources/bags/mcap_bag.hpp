#pragma once

#include "services/sources/bags/chunked_bag.hpp"

namespace crsm {

/// An MCAP file, in chunks or not, these plain or compressed by lz4 or zstd, with a summary or not. One whose recording
/// was killed is read as far as it goes. Source: mcap.dev/spec.
class McapBag : public ChunkedBag {
 public:
  static bool Is(std::string_view start);

  /// Throws std::runtime_error if the file cannot be opened.
  McapBag(const std::string& path, const WantTopic& want);

  std::optional<std::vector<BagTopic>> ListedTopics() override;

 private:
  using SchemaNames = std::map<std::uint16_t, std::string>;

  bool TakeRecord(ByteRange& bytes, std::uint64_t& at, std::optional<BagMessage>& message) override;
  bool TakeMessage(ByteRange& bytes, std::uint64_t begin, std::uint64_t end, std::optional<BagMessage>& message);
  bool TakeChunk(std::uint64_t begin, std::uint64_t end);
  bool EndsInOrder() const override { return ended_in_order_; }

  SchemaNames schemas_;
  bool ended_in_order_ = false;
};

}  // namespace crsm
