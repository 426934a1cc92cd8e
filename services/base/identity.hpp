#pragma once

#include <cstdint>

namespace crsm {

/// A number that no other process draws, not 0. Nothing that is computed depends on it.
std::int64_t DrawIdentity();

/// The same number for the same identity until the machine starts anew, and another one afterwards: a power cut may
/// take back what was told already, and nobody who was told is to go on from there.
std::int64_t IdentityOfThisBoot(std::int64_t identity);

}  // namespace crsm
