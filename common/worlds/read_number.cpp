#include "common/worlds/read_number.hpp"

#include <fmt/format.h>

#include <optional>
#include <stdexcept>

#include "common/math/parse_number.hpp"

namespace crsm {

double ReadNumber(const std::string& place, const std::string& key, const Field& field, const std::string& word) {
  const std::optional<double> number = ParseNumber<double>(word);
  if (!number || !(*number >= field.min && *number <= field.max)) {
    throw std::runtime_error(fmt::format("{}: {} {} is '{}', must be a number from {} to {}", place, key, field.name,
                                         word, field.min, field.max));
  }
  return *number;
}

}  // namespace crsm
