#pragma once

#include <bot_core/planar_lidar_t.hpp>
#include <bot_core/pose_t.hpp>
#include <botlab/lidar_nranges_t.hpp>
#include <botlab/lidar_t.hpp>
#include <crsm/critical_rays_t.hpp>
#include <crsm/map_delta_t.hpp>
#include <crsm/map_request_t.hpp>
#include <crsm/scan_match_t.hpp>
#include <crsm/service_status_t.hpp>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

namespace crsm {

/// Walks over an encoded message without decoding it. Decoders that lcm-gen makes trust array counts: a hostile count
/// crashes or exhausts a process that decodes blindly, so every count is held against the bytes that are there first.
class WireReader {
 public:
  explicit WireReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  void Skip(std::size_t size) { ok_ = ok_ && size <= left() ? (at_ += size, true) : false; }

  std::int32_t Int32() {
    if (!ok_ || left() < 4) return ok_ = false, 0;
    const std::uint8_t* byte = bytes_.data() + at_;
    at_ += 4;
    return static_cast<std::int32_t>(std::uint32_t{byte[0]} << 24 | std::uint32_t{byte[1]} << 16 |
                                     std::uint32_t{byte[2]} << 8 | std::uint32_t{byte[3]});
  }

  /// Number of elements of an array; anything beyond `most` is malformed.
  std::int32_t Count(std::int32_t most) {
    const std::int32_t count = Int32();
    ok_ = ok_ && count >= 0 && count <= most;
    return ok_ ? count : 0;
  }

  void Array(std::int32_t count, std::size_t element_size) { Skip(static_cast<std::size_t>(count) * element_size); }

  void String() {
    constexpr std::int32_t kLongest = 1024;
    const std::int32_t size = Count(kLongest);  // with the NUL at the end
    ok_ = ok_ && size >= 1;
    Array(size, 1);
  }

  /// Whether all of the message was walked over and nothing was wrong.
  bool Whole() const { return ok_ && left() == 0; }

 private:
  std::size_t left() const { return bytes_.size() - at_; }

  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 8;  // behind the fingerprint
  bool ok_ = true;
};

// For each type: whether its counts fit the bytes, and whether the values of a decoded message are in range.
void Walk(WireReader& reader, const bot_core::planar_lidar_t*);
void Walk(WireReader& reader, const bot_core::pose_t*);
void Walk(WireReader& reader, const botlab::lidar_t*);
void Walk(WireReader& reader, const botlab::lidar_nranges_t*);
void Walk(WireReader& reader, const critical_rays_t*);
void Walk(WireReader& reader, const scan_match_t*);
void Walk(WireReader& reader, const map_delta_t*);
void Walk(WireReader& reader, const map_request_t*);
void Walk(WireReader& reader, const service_status_t*);
bool ValuesInRange(const bot_core::planar_lidar_t& message);
bool ValuesInRange(const bot_core::pose_t& message);
bool ValuesInRange(const botlab::lidar_t& message);
bool ValuesInRange(const botlab::lidar_nranges_t& message);
bool ValuesInRange(const critical_rays_t& message);
bool ValuesInRange(const scan_match_t& message);
bool ValuesInRange(const map_delta_t& message);
bool ValuesInRange(const map_request_t& message);
bool ValuesInRange(const service_status_t& message);

/// What type a message says it is: its first eight bytes; 0 if it is shorter.
inline std::uint64_t Fingerprint(std::span<const std::uint8_t> bytes) {
  std::uint64_t fingerprint = 0;
  for (std::size_t i = 0; i < 8 && bytes.size() >= 8; ++i) fingerprint = fingerprint << 8 | bytes[i];
  return fingerprint;
}

/// Decodes a message that anybody may have sent: nothing if its fingerprint, a count or a value is wrong.
template <class Message>
std::optional<Message> Decode(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < 8 || bytes.size() > std::numeric_limits<std::int32_t>::max()) return std::nullopt;
  if (Fingerprint(bytes) != static_cast<std::uint64_t>(Message::getHash())) return std::nullopt;
  WireReader reader(bytes);
  Walk(reader, static_cast<const Message*>(nullptr));
  if (!reader.Whole()) return std::nullopt;
  Message message;
  if (message.decode(bytes.data(), 0, static_cast<int>(bytes.size())) != static_cast<int>(bytes.size()))
    return std::nullopt;
  if (!ValuesInRange(message)) return std::nullopt;
  return message;
}

}  // namespace crsm
