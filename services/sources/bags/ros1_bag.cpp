#include "services/sources/bags/ros1_bag.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "services/sources/bags/byte_reader.hpp"
#include "services/sources/bags/decompress.hpp"

namespace crsm {
namespace {

constexpr std::string_view kAnyVersion = "#ROSBAG V";
constexpr std::string_view kVersion = "#ROSBAG V2.0\n";
constexpr std::size_t kMostHeaderBytes = std::size_t{1} << 16;

enum Operation : int {
  kMessage = 0x02,
  kBagHeader = 0x03,
  kIndex = 0x04,
  kChunk = 0x05,
  kChunkInfo = 0x06,
  kConnection = 0x07,
};

/// Name and value of each field; nothing if they do not fill `bytes`.
std::optional<std::map<std::string, std::string, std::less<>>> ReadFields(std::string_view bytes) {
  std::map<std::string, std::string, std::less<>> fields;
  ByteReader reader(bytes);
  while (reader.left() > 0) {
    const std::string_view field = reader.Text();
    const std::size_t equals = field.find('=');
    if (!reader.ok() || equals == std::string_view::npos) return std::nullopt;
    fields[std::string(field.substr(0, equals))] = field.substr(equals + 1);
  }
  return fields;
}

}  // namespace

struct Ros1Bag::Record {
  std::map<std::string, std::string, std::less<>> fields;
  std::uint64_t data_at = 0;
  std::uint32_t num_data_bytes = 0;

  std::uint64_t end() const { return data_at + num_data_bytes; }
  std::string Text(std::string_view name) const {
    const auto found = fields.find(name);
    return found == fields.end() ? "" : found->second;
  }
  /// Nothing if it is missing or of another size.
  template <class Number>
  std::optional<Number> Find(std::string_view name) const {
    const auto found = fields.find(name);
    if (found == fields.end() || found->second.size() != sizeof(Number)) return std::nullopt;
    return ByteReader(found->second).Read<Number>();
  }
  int operation() const { return Find<std::uint8_t>("op").value_or(0); }
};

/// Nothing if no whole record begins there.
std::optional<Ros1Bag::Record> Ros1Bag::RecordAt(ByteRange& bytes, std::uint64_t at) {
  ByteReader header_size(bytes.At(at, sizeof(std::uint32_t)));
  const auto num_header_bytes = header_size.Read<std::uint32_t>();
  if (!header_size.ok() || num_header_bytes > kMostHeaderBytes) return std::nullopt;
  ByteReader reader(bytes.At(at + sizeof(std::uint32_t), num_header_bytes + sizeof(std::uint32_t)));
  auto fields = ReadFields(reader.Take(num_header_bytes));
  const auto num_data_bytes = reader.Read<std::uint32_t>();
  if (!reader.ok() || !fields) return std::nullopt;
  Record record{std::move(*fields), at + 2 * sizeof(std::uint32_t) + num_header_bytes, num_data_bytes};
  if (record.operation() == 0) return std::nullopt;
  // Only of a chunk a part is better than nothing.
  if (record.end() > bytes.size() && record.operation() != kChunk) return std::nullopt;
  return record;
}

std::optional<BagTopic> Ros1Bag::ReadConnection(ByteRange& bytes, const Record& record) {
  if (record.num_data_bytes > kMostMessageBytes) return std::nullopt;
  const auto fields = ReadFields(bytes.At(record.data_at, record.num_data_bytes));
  if (!fields) return std::nullopt;
  const auto type = fields->find("type");
  if (type == fields->end()) return std::nullopt;
  return BagTopic{record.Text("topic"), type->second, "ros1"};
}

bool Ros1Bag::Is(std::string_view start) { return start.starts_with(kAnyVersion); }

Ros1Bag::Ros1Bag(const std::string& path, const WantTopic& want) : ChunkedBag(path, kVersion.size(), want) {
  const std::string_view start = file().At(0, kVersion.size());
  if (start != kVersion) {
    throw std::runtime_error(fmt::format("{} is no ROS 1 bag of format 2.0: convert it with rosbag fix", path));
  }
  const auto header = RecordAt(file(), kVersion.size());
  if (!header || header->operation() != kBagHeader) {
    throw std::runtime_error(fmt::format("{} is a ROS 1 bag that is damaged at its beginning", path));
  }
  index_at_ = header->Find<std::uint64_t>("index_pos").value_or(0);
  num_connections_ = header->Find<std::uint32_t>("conn_count").value_or(0);
}

bool Ros1Bag::EndsInOrder() const { return index_at_ != 0 && index_at_ <= file().size(); }

std::optional<std::vector<BagTopic>> Ros1Bag::ListedTopics() {
  std::vector<BagTopic> topics;
  std::uint64_t at = index_at_;
  while (at != 0 && topics.size() < num_connections_) {
    const auto record = RecordAt(file(), at);
    if (!record || record->operation() != kConnection) return std::nullopt;
    const auto topic = ReadConnection(file(), *record);
    if (!topic) return std::nullopt;
    topics.push_back(*topic);
    at = record->end();
  }
  return at == 0 ? std::nullopt : std::optional(topics);
}

bool Ros1Bag::TakeRecord(ByteRange& bytes, std::uint64_t& at, std::optional<BagMessage>& message) {
  const auto record = RecordAt(bytes, at);
  if (!record) return false;
  at = record->end();
  const auto connection = record->Find<std::uint32_t>("conn");
  switch (record->operation()) {
    case kConnection:
      if (const auto topic = ReadConnection(bytes, *record); topic && connection) AddTopic(*connection, *topic);
      break;
    case kMessage:
      if (const std::string* topic = connection ? WantedTopic(*connection) : nullptr) {
        message = BagMessage{*topic, {}};
        if (record->num_data_bytes <= kMostMessageBytes)
          message->data = bytes.At(record->data_at, record->num_data_bytes);
      }
      break;
    case kChunk:
      if (&bytes != &file()) return false;
      TakeChunk(*record, at);
      break;
    default:
      break;
  }
  return true;
}

void Ros1Bag::TakeChunk(const Record& record, std::uint64_t& at) {
  Chunk chunk{record.Text("compression"), record.data_at, record.num_data_bytes,
              record.Find<std::uint32_t>("size").value_or(0)};
  if (chunk.compression == "none") chunk.compression.clear();
  // A chunk has its sizes when it is finished. To one that is not belongs all that follows.
  const bool is_unfinished = record.num_data_bytes == 0 && index_at_ == 0;
  const std::uint64_t left = file().size() - record.data_at;
  chunk.is_cut = is_unfinished || chunk.num_bytes > left;
  if (chunk.is_cut) chunk.num_bytes = left;
  if (is_unfinished) chunk.num_unpacked_bytes = kMostChunkBytes;
  at = chunk.begin + chunk.num_bytes;
  OpenChunk(chunk);
}

}  // namespace crsm
