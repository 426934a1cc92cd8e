#pragma once

#include <cstdint>
#include <string>

namespace crsm {

/// A number that no other process draws, not 0. Nothing that is computed depends on it.
std::int64_t DrawIdentity();

/// The same number for the same identity until the machine starts anew, and another one afterwards: a power cut may
/// take back what was told already, and nobody who was told is to go on from there.
std::int64_t IdentityOfThisBoot(std::int64_t identity);

/// As text: a number of JSON would lose its last digits in many readers.
std::string FormatIdentity(std::int64_t identity);

}  // namespace crsm
