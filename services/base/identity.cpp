#include "services/base/identity.hpp"

#include <fmt/core.h>

#include <fstream>
#include <random>
#include <string>

#include "common/logs/crc32.hpp"

namespace crsm {

std::int64_t DrawIdentity() {
  std::random_device device;
  return (std::int64_t{device()} << 31 | std::int64_t{device() >> 1}) + 1;
}

std::int64_t IdentityOfThisBoot(std::int64_t identity) {
  std::ifstream file("/proc/sys/kernel/random/boot_id");
  std::string boot;
  file >> boot;
  const auto mixed = static_cast<std::int64_t>(static_cast<std::uint64_t>(identity) ^ Crc32(boot));
  return mixed != 0 ? mixed : identity;
}

std::string FormatIdentity(std::int64_t identity) { return fmt::format("{:016x}", identity); }

}  // namespace crsm
