#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "common/scan/laser_scan.hpp"
#include "services/runtime/wire_reader.hpp"

namespace crsm {

/// A type of LCM message that a laser speaks: a file in lasers/ for each type, or family of types, which registers it.
struct LaserType {
  std::string name;  ///< package and type

  /// The scan in a message, its utime >= 0, with kMinBeams to kMaxBeams; nothing if the message is malformed.
  std::function<std::optional<LaserScan>(std::span<const std::uint8_t> bytes)> decode;
};

/// All types that are known, by fingerprint.
const std::map<std::uint64_t, LaserType>& LaserTypes();

/// The type that a message says it is of; nullptr if it is no laser's.
const LaserType* FindLaserType(std::span<const std::uint8_t> bytes);

/// The names of the types that are known, each once: "bot_core.planar_lidar_t, botlab.lidar_t".
std::string LaserTypeNames();

/// Makes a type known, before main() where the result is kept in a constant of a file. Throws std::logic_error if one
/// of its fingerprint is known already.
bool RegisterLaserType(std::uint64_t fingerprint, LaserType type);

/// The same for a type that lcm-gen made and that has FieldsOf and ValuesInRange (wire_reader.hpp).
template <class Message>
bool RegisterLaserType(const std::string& name, LaserScan (*to_scan)(const Message&)) {
  const auto decode = [to_scan](std::span<const std::uint8_t> bytes) {
    const auto message = Decode<Message>(bytes);
    return message ? std::optional(to_scan(*message)) : std::nullopt;
  };
  return RegisterLaserType(static_cast<std::uint64_t>(Message::getHash()), LaserType{name, decode});
}

}  // namespace crsm
