#include "services/diagnosis/changes_over.hpp"

#include <fmt/core.h>

#include "common/math/parse_number.hpp"
#include "services/base/usage_error.hpp"

namespace crsm {

void ChangesOver::AddFlag(CommandLine& command_line) {
  command_line.AddOption(
      "--changes-over", text_,
      "with --localize: exit with 4 if something of this area, or larger, has come or gone since the "
      "map was made [m2]",
      {kOptionsHeading, "AREA_M2"});
}

void ChangesOver::Check(const Settings& settings) const {
  if (!was_given()) return;
  const auto area_m2 = ParseNumber<double>(text_);
  if (!area_m2 || !(*area_m2 > 0.0 && *area_m2 <= 1e6)) {
    throw UsageError(
        fmt::format("--changes-over {}: must be an area in m2 within 0 and 1,000,000, such as 0.1", text_));
  }
  if (settings.localize.empty()) {
    throw UsageError("--changes-over: compares with a finished map; give --localize RUN as well, or remove it");
  }
}

bool ChangesOver::IsExceededBy(double largest_m2) const {
  return was_given() && largest_m2 >= ParseNumber<double>(text_);
}

}  // namespace crsm
