#include "services/sources/bags/mcap_bag.hpp"

#include <algorithm>

#include "services/sources/bags/byte_reader.hpp"
#include "services/sources/bags/mcap_format.hpp"

namespace crsm {
namespace {

constexpr std::size_t kOpcodeAndSizeBytes = 9;
constexpr std::size_t kMostHeadBytes = std::size_t{1} << 16;  ///< of a record, all but the text of a schema
constexpr std::uint64_t kFooterBytes = 20;

struct Record {
  McapOpcode opcode{};
  std::uint64_t begin = 0;  ///< of its content
  std::uint64_t end = 0;
  bool is_cut = false;  ///< by the end of the file

  ByteReader Head(ByteRange& bytes) const {
    return ByteReader(bytes.At(begin, static_cast<std::size_t>(std::min<std::uint64_t>(end - begin, kMostHeadBytes))));
  }
};

/// Nothing if no whole record begins there.
std::optional<Record> RecordAt(ByteRange& bytes, std::uint64_t at) {
  ByteReader reader(bytes.At(at, kOpcodeAndSizeBytes));
  const auto opcode = reader.Read<std::uint8_t>();
  const auto size = reader.Read<std::uint64_t>();
  const std::uint64_t begin = at + kOpcodeAndSizeBytes;
  if (!reader.ok() || opcode == 0) return std::nullopt;
  Record record{static_cast<McapOpcode>(opcode), begin, begin + std::min(size, bytes.size() - begin)};
  record.is_cut = size > record.end - begin;
  // Only of a chunk a part is better than nothing.
  return record.is_cut && record.opcode != McapOpcode::kChunk ? std::nullopt : std::optional(record);
}

bool TakeSchema(ByteReader reader, std::map<std::uint16_t, std::string>& schemas) {
  const auto number = reader.Read<std::uint16_t>();
  const std::string_view name = reader.Text();
  constexpr std::size_t kLongest = 1000;  // there may be 65,535
  if (reader.ok()) schemas[number] = name.substr(0, kLongest);
  return reader.ok();
}

struct Channel {
  std::uint16_t number = 0;
  BagTopic topic;
};

std::optional<Channel> ReadChannel(ByteReader reader, const std::map<std::uint16_t, std::string>& schemas) {
  Channel channel;
  channel.number = reader.Read<std::uint16_t>();
  const auto schema = schemas.find(reader.Read<std::uint16_t>());
  channel.topic.name = reader.Text();
  channel.topic.encoding = reader.Text();
  if (schema != schemas.end()) channel.topic.type = schema->second;
  return reader.ok() ? std::optional(channel) : std::nullopt;
}

}  // namespace

bool McapBag::Is(std::string_view start) { return start.starts_with(kMcapMagic); }

McapBag::McapBag(const std::string& path, const WantTopic& want) : ChunkedBag(path, kMcapMagic.size(), want) {}

std::optional<std::vector<BagTopic>> McapBag::ListedTopics() {
  const std::uint64_t tail_bytes = kOpcodeAndSizeBytes + kFooterBytes + kMcapMagic.size();
  if (file().size() < tail_bytes) return std::nullopt;
  const auto footer = RecordAt(file(), file().size() - tail_bytes);
  if (!footer || footer->opcode != McapOpcode::kFooter) return std::nullopt;
  const auto summary_at = footer->Head(file()).Read<std::uint64_t>();
  if (summary_at == 0) return std::nullopt;

  std::vector<BagTopic> topics;
  SchemaNames schemas;
  std::optional<std::uint32_t> num_channels;
  for (std::uint64_t at = summary_at; at < file().size();) {
    const auto record = RecordAt(file(), at);
    if (!record || record->opcode == McapOpcode::kFooter) break;
    at = record->end;
    if (record->opcode == McapOpcode::kSchema) TakeSchema(record->Head(file()), schemas);
    if (record->opcode == McapOpcode::kChannel) {
      if (const auto channel = ReadChannel(record->Head(file()), schemas)) topics.push_back(channel->topic);
    }
    if (record->opcode == McapOpcode::kStatistics) {
      ByteReader statistics = record->Head(file());
      statistics.Read<std::uint64_t>();  // messages
      statistics.Read<std::uint16_t>();  // schemas
      num_channels = statistics.Read<std::uint32_t>();
    }
  }
  // A summary may leave out the channels, or be without statistics: then nothing says that these are all.
  return num_channels == topics.size() ? std::optional(topics) : std::nullopt;
}

bool McapBag::TakeRecord(ByteRange& bytes, std::uint64_t& at, std::optional<BagMessage>& message) {
  const auto record = RecordAt(bytes, at);
  if (!record) return false;
  at = record->end;
  switch (record->opcode) {
    case McapOpcode::kSchema:
      return TakeSchema(record->Head(bytes), schemas_);
    case McapOpcode::kChannel: {
      const auto channel = ReadChannel(record->Head(bytes), schemas_);
      if (channel) AddTopic(channel->number, channel->topic);
      return channel.has_value();
    }
    case McapOpcode::kMessage:
      return TakeMessage(bytes, record->begin, record->end, message);
    case McapOpcode::kChunk:
      return &bytes == &file() && TakeChunk(record->begin, record->end);
    case McapOpcode::kDataEnd:
    case McapOpcode::kFooter:
      if (&bytes != &file()) return false;
      ended_in_order_ = true;
      End();
      return true;
    default:
      return true;
  }
}

bool McapBag::TakeMessage(ByteRange& bytes, std::uint64_t begin, std::uint64_t end,
                          std::optional<BagMessage>& message) {
  constexpr std::size_t kHeadBytes = 22;  // channel, sequence, two times
  if (end - begin < kHeadBytes) return false;
  const std::string* topic = WantedTopic(ByteReader(bytes.At(begin, kHeadBytes)).Read<std::uint16_t>());
  if (!topic) return true;
  message = BagMessage{*topic, {}};
  const std::uint64_t num_bytes = end - begin - kHeadBytes;
  if (num_bytes <= kMostMessageBytes) message->data = bytes.At(begin + kHeadBytes, static_cast<std::size_t>(num_bytes));
  return true;
}

bool McapBag::TakeChunk(std::uint64_t begin, std::uint64_t end) {
  ByteReader reader = Record{McapOpcode::kChunk, begin, end}.Head(file());
  Chunk chunk;
  reader.Read<std::uint64_t>();  // its first time
  reader.Read<std::uint64_t>();  // and its last
  chunk.num_unpacked_bytes = reader.Read<std::uint64_t>();
  chunk.crc = reader.Read<std::uint32_t>();
  chunk.compression = reader.Text();
  chunk.num_bytes = reader.Read<std::uint64_t>();
  chunk.begin = begin + reader.at();
  chunk.is_cut = chunk.num_bytes > end - chunk.begin;
  if (!reader.ok() || (chunk.is_cut && end != file().size())) return false;
  if (chunk.is_cut) chunk.num_bytes = end - chunk.begin;
  OpenChunk(chunk);
  return true;
}

}  // namespace crsm
