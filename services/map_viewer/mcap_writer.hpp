#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/logs/replacement.hpp"
#include "services/sources/bags/mcap_format.hpp"

namespace crsm {

/// Writes an MCAP file, of messages in JSON: in chunks with an index, so that a player can go to any time at once. Not
/// compressed. Source: mcap.dev/spec.
class McapWriter {
 public:
  /// sink: takes the bytes of the file, one after the other.
  explicit McapWriter(Sink sink);

  struct Topic {
    std::string name;
    std::string schema_name;
    std::string schema;  ///< JSON
  };
  /// Returns the number of its channel.
  std::uint16_t AddChannel(const Topic& topic);

  void Write(std::uint16_t channel, std::uint64_t time_ns, std::string_view message);

  /// Writes what ends the file. Nothing may follow.
  void Finish();

 private:
  using Bytes = std::string;
  struct Span {
    std::uint64_t first_ns = 0;
    std::uint64_t last_ns = 0;
    bool empty = true;
    void Add(std::uint64_t time_ns);
  };

  void Put(const Bytes& bytes);
  void PutRecord(McapOpcode opcode, const Bytes& content);
  void EndChunk();
  Bytes MakeStatistics() const;

  Sink sink_;
  std::uint64_t position_ = 0;  ///< in the file
  std::map<std::string, std::uint16_t> schema_ids_;
  std::vector<std::pair<McapOpcode, Bytes>> summary_;  ///< records of schemas and channels
  std::vector<std::uint64_t> num_messages_;            ///< by channel
  Span file_span_;

  // The chunk under way.
  Bytes chunk_;
  Span chunk_span_;
  std::map<std::uint16_t, Bytes> message_index_;  ///< by channel: time and place in the chunk
  std::vector<Bytes> chunk_indices_;
};

}  // namespace crsm
