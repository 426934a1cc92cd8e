#include "services/wire/laser_types.hpp"

#include <fmt/format.h>

#include <set>
#include <stdexcept>
#include <utility>

namespace crsm {
namespace {

/// Made when the first type registers, in whatever order the files' constants are made.
std::map<std::uint64_t, LaserType>& Registry() {
  static std::map<std::uint64_t, LaserType> registry;
  return registry;
}

}  // namespace

const std::map<std::uint64_t, LaserType>& LaserTypes() { return Registry(); }

const LaserType* FindLaserType(std::uint64_t fingerprint) {
  const auto found = Registry().find(fingerprint);
  return found == Registry().end() ? nullptr : &found->second;
}

const LaserType* FindLaserType(std::span<const std::uint8_t> bytes) { return FindLaserType(Fingerprint(bytes)); }

std::optional<LaserReading> DecodeLaser(std::span<const std::uint8_t> bytes, const LaserMessageOptions& options) {
  const LaserType* type = FindLaserType(bytes);
  auto reading = type ? type->decode(bytes, options) : std::nullopt;
  if (reading && options.mirrored) reading->scan = Mirror(std::move(reading->scan));
  return reading;
}

std::string LaserTypeNames() {
  std::set<std::string> names;
  for (const auto& [fingerprint, type] : Registry()) names.insert(type.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

bool RegisterLaserType(std::uint64_t fingerprint, LaserType type) {
  const auto [entry, is_new] = Registry().emplace(fingerprint, std::move(type));
  if (!is_new) {
    throw std::logic_error(
        fmt::format("two laser types have the fingerprint {:x}: one is {}", fingerprint, entry->second.name));
  }
  return true;
}

}  // namespace crsm
