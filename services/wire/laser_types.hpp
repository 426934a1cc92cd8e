#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "common/parameters.hpp"
#include "common/scan/laser_scan.hpp"
#include "common/scan/thin_beams.hpp"
#include "services/wire/wire_reader.hpp"

namespace crsm {

/// What a laser's messages do not tell themselves, or wrongly.
struct LaserMessageOptions {
  ScanParameters scan = {};
  bool botlab_clockwise = true;  ///< the angles of a botlab.lidar_t run clockwise
  bool mirrored = false;         ///< scans are mirror images, and are turned round
};

/// A scan as a laser's message has it.
struct LaserReading {
  LaserScan scan;                  ///< its utime >= 0, with kMinBeams to kMaxBeams
  std::string frame = {};          ///< of the laser; empty where the message names none
  std::string thinned = {};        ///< as of ThinBeams
  std::string contradiction = {};  ///< in the message, and what mends it; empty where there is none
};

/// A type of LCM message that a laser speaks: a file in services/wire/lasers/ for each type, or family of types,
/// which registers it. A program that links crsm_lasers knows them all.
struct LaserType {
  std::string name;  ///< package and type

  /// The scan in a message; nothing if the message is malformed.
  std::function<std::optional<LaserReading>(std::span<const std::uint8_t> bytes, const LaserMessageOptions& options)>
      decode;
};

/// All types that are known, by fingerprint.
const std::map<std::uint64_t, LaserType>& LaserTypes();

/// The type with a fingerprint, or that a message says it is of; nullptr if it is no laser's.
const LaserType* FindLaserType(std::uint64_t fingerprint);
const LaserType* FindLaserType(std::span<const std::uint8_t> bytes);

/// The scan in a message of any type that is known; nothing if it is of another one, or malformed.
std::optional<LaserReading> DecodeLaser(std::span<const std::uint8_t> bytes, const LaserMessageOptions& options);

/// The names of the types that are known, each once: "bot_core.planar_lidar_t, botlab.lidar_t".
std::string LaserTypeNames();

/// Makes a type known, before main() where the result is kept in a constant of a file. Throws std::logic_error if one
/// of its fingerprint is known already.
bool RegisterLaserType(std::uint64_t fingerprint, LaserType type);

/// What the messages of a type tell besides their scan; nullptr where they do not.
template <class Message>
struct LaserHeader {
  std::string (*frame_of)(const Message&) = nullptr;
  std::string (*contradiction_of)(const Message&) = nullptr;  ///< as of LaserReading
};

/// The same for a type that lcm-gen made of a file in lcmtypes/. Its ValuesInRange says which values may be read, and
/// to_scan makes of them metres, radians counter-clockwise from straight ahead, and 0 for no return.
template <class Message>
bool RegisterLaserType(const std::string& name, LaserScan (*to_scan)(const Message&, const LaserMessageOptions&),
                       const LaserHeader<Message>& header = {}) {
  const auto decode = [to_scan, header](std::span<const std::uint8_t> bytes,
                                        const LaserMessageOptions& options) -> std::optional<LaserReading> {
    const auto message = Decode<Message>(bytes);
    if (!message) return std::nullopt;
    LaserReading reading{to_scan(*message, options), header.frame_of ? header.frame_of(*message) : ""};
    if (header.contradiction_of) reading.contradiction = header.contradiction_of(*message);
    reading.thinned = ThinBeams(reading.scan);
    return reading;
  };
  return RegisterLaserType(static_cast<std::uint64_t>(Message::getHash()), LaserType{name, decode});
}

}  // namespace crsm
