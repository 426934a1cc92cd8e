#include "common/parameters.hpp"

#include <fmt/core.h>

#include <stdexcept>
#include <type_traits>

namespace crsm {
namespace {

class Lister {
 public:
  template <class Number>
  requires std::is_arithmetic_v<Number>
  void operator()(const ParameterInfo& info, Number& value, Number, Number) {
    if constexpr (std::is_same_v<Number, int>) {
      list.emplace_back(info.key, std::int64_t{value});
    } else {
      list.emplace_back(info.key, value);
    }
  }
  void operator()(const ParameterInfo& info, bool& value) { list.emplace_back(info.key, value); }
  template <class Enum, std::size_t N>
  void operator()(const ParameterInfo& info, Enum& value, const std::array<std::string_view, N>& names) {
    list.emplace_back(info.key, std::string(names.at(static_cast<std::size_t>(value))));
  }

  std::vector<std::pair<std::string, ParameterValue>> list;
};

template <class Number>
void CheckOrder(const char* lower_key, Number lower, const char* upper_key, Number upper) {
  if (lower <= upper) return;
  throw std::runtime_error(fmt::format("{}: {} is more than {}, {}", lower_key, lower, upper_key, upper));
}

}  // namespace

std::vector<std::pair<std::string, ParameterValue>> ListParameters(const Parameters& parameters) {
  Parameters copy = parameters;
  Lister lister;
  VisitParameters(copy, lister);
  return lister.list;
}

void CheckConsistency(const Parameters& parameters) {
  const ScanParameters& scan = parameters.scan;
  const SelectionParameters& selection = parameters.selection;
  const UpdateParameters& update = parameters.update;
  CheckOrder("range_min_m", scan.range_min_m, "range_max_m", scan.range_max_m);
  CheckOrder("rays_min", selection.rays_min, "rays_max", selection.rays_max);
  CheckOrder("intensity_min", update.intensity_min, "intensity_max", update.intensity_max);
}

}  // namespace crsm
