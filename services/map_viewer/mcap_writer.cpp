#include "services/map_viewer/mcap_writer.hpp"

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "services/map_viewer/little_endian.hpp"

namespace crsm {
namespace {

constexpr std::size_t kChunkBytes = 4 << 20;
constexpr std::uint32_t kNoCrc = 0;

/// Bytes behind their number.
void AppendText(std::string& bytes, std::string_view text) {
  Append(bytes, static_cast<std::uint32_t>(text.size()));
  bytes += text;
}

std::string MakeRecord(McapOpcode opcode, const std::string& content) {
  std::string record;
  Append(record, opcode);
  Append(record, static_cast<std::uint64_t>(content.size()));
  return record + content;
}

}  // namespace

void McapWriter::Span::Add(std::uint64_t time_ns) {
  first_ns = empty ? time_ns : std::min(first_ns, time_ns);
  last_ns = empty ? time_ns : std::max(last_ns, time_ns);
  empty = false;
}

McapWriter::McapWriter(Sink sink) : sink_(std::move(sink)) {
  Put(Bytes(kMcapMagic));
  Bytes header;
  AppendText(header, "");  // no profile
  AppendText(header, "crsm_slam");
  PutRecord(McapOpcode::kHeader, header);
}

std::uint16_t McapWriter::AddChannel(const Topic& topic) {
  if (num_messages_.size() == 0xffff) throw std::invalid_argument("McapWriter: more than 65535 channels");
  const auto [schema, is_new] =
      schema_ids_.try_emplace(topic.schema_name, static_cast<std::uint16_t>(schema_ids_.size() + 1));
  if (is_new) {
    Bytes content;
    Append(content, schema->second);
    AppendText(content, topic.schema_name);
    AppendText(content, "jsonschema");
    AppendText(content, topic.schema);
    summary_.emplace_back(McapOpcode::kSchema, content);
    chunk_ += MakeRecord(McapOpcode::kSchema, content);
  }
  const auto channel = static_cast<std::uint16_t>(num_messages_.size());
  num_messages_.push_back(0);
  Bytes content;
  Append(content, channel);
  Append(content, schema->second);
  AppendText(content, topic.name);
  AppendText(content, "json");
  AppendText(content, "");  // no metadata
  summary_.emplace_back(McapOpcode::kChannel, content);
  chunk_ += MakeRecord(McapOpcode::kChannel, content);
  return channel;
}

void McapWriter::Write(std::uint16_t channel, std::uint64_t time_ns, std::string_view message) {
  Bytes& index = message_index_[channel];
  Append(index, time_ns);
  Append(index, static_cast<std::uint64_t>(chunk_.size()));
  Bytes content;
  Append(content, channel);
  Append(content, static_cast<std::uint32_t>(num_messages_.at(channel)++));
  Append(content, time_ns);  // when it was heard ...
  Append(content, time_ns);  // ... and said
  content += message;
  chunk_ += MakeRecord(McapOpcode::kMessage, content);
  chunk_span_.Add(time_ns);
  file_span_.Add(time_ns);
  if (chunk_.size() >= kChunkBytes) EndChunk();
}

void McapWriter::EndChunk() {
  if (chunk_.empty()) return;
  Bytes content;
  Append(content, chunk_span_.first_ns);
  Append(content, chunk_span_.last_ns);
  Append(content, static_cast<std::uint64_t>(chunk_.size()));
  Append(content, kNoCrc);
  AppendText(content, "");  // no compression
  Append(content, static_cast<std::uint64_t>(chunk_.size()));
  const std::uint64_t chunk_begin = position_;
  PutRecord(McapOpcode::kChunk, content + chunk_);
  const std::uint64_t index_begin = position_;
  Bytes index_offsets;
  for (const auto& [channel, entries] : message_index_) {
    Append(index_offsets, channel);
    Append(index_offsets, position_);
    Bytes index;
    Append(index, channel);
    AppendText(index, entries);
    PutRecord(McapOpcode::kMessageIndex, index);
  }
  Bytes summary;
  Append(summary, chunk_span_.first_ns);
  Append(summary, chunk_span_.last_ns);
  Append(summary, chunk_begin);
  Append(summary, index_begin - chunk_begin);
  AppendText(summary, index_offsets);
  Append(summary, position_ - index_begin);
  AppendText(summary, "");
  Append(summary, static_cast<std::uint64_t>(chunk_.size()));
  Append(summary, static_cast<std::uint64_t>(chunk_.size()));
  chunk_indices_.push_back(std::move(summary));
  chunk_.clear();
  chunk_span_ = {};
  message_index_.clear();
}

McapWriter::Bytes McapWriter::MakeStatistics() const {
  Bytes statistics;
  Append(statistics, std::accumulate(num_messages_.begin(), num_messages_.end(), std::uint64_t{0}));
  Append(statistics, static_cast<std::uint16_t>(schema_ids_.size()));
  Append(statistics, static_cast<std::uint32_t>(num_messages_.size()));
  Append(statistics, std::uint32_t{0});  // attachments
  Append(statistics, std::uint32_t{0});  // metadata
  Append(statistics, static_cast<std::uint32_t>(chunk_indices_.size()));
  Append(statistics, file_span_.first_ns);
  Append(statistics, file_span_.last_ns);
  Bytes counts;
  for (std::size_t channel = 0; channel < num_messages_.size(); ++channel) {
    Append(counts, static_cast<std::uint16_t>(channel));
    Append(counts, num_messages_[channel]);
  }
  AppendText(statistics, counts);
  return statistics;
}

void McapWriter::Finish() {
  EndChunk();
  Bytes data_end;
  Append(data_end, kNoCrc);
  PutRecord(McapOpcode::kDataEnd, data_end);
  const std::uint64_t summary_begin = position_;
  for (const auto& [opcode, content] : summary_) PutRecord(opcode, content);
  PutRecord(McapOpcode::kStatistics, MakeStatistics());
  for (const Bytes& index : chunk_indices_) PutRecord(McapOpcode::kChunkIndex, index);
  Bytes footer;
  Append(footer, summary_begin);
  Append(footer, std::uint64_t{0});  // no offsets within the summary
  Append(footer, kNoCrc);
  PutRecord(McapOpcode::kFooter, footer);
  Put(Bytes(kMcapMagic));
}

void McapWriter::Put(const Bytes& bytes) {
  sink_(bytes);
  position_ += bytes.size();
}

void McapWriter::PutRecord(McapOpcode opcode, const Bytes& content) { Put(MakeRecord(opcode, content)); }

}  // namespace crsm
