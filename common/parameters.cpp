#include "common/parameters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <type_traits>

#include "common/math/format_number.hpp"

namespace crsm {
namespace {

class Lister {
 public:
  template <class Number>
  requires std::is_arithmetic_v<Number>
  void operator()(const ParameterInfo& info, Number& value, Number, Number) {
    if constexpr (std::is_same_v<Number, int>) {
      Add(info, std::int64_t{value});
    } else {
      Add(info, value);
    }
  }
  void operator()(const ParameterInfo& info, bool& value) { Add(info, value); }
  template <class Enum, std::size_t N>
  void operator()(const ParameterInfo& info, Enum& value, const std::array<std::string_view, N>& names) {
    Add(info, std::string(names.at(static_cast<std::size_t>(value))));
  }

  std::vector<std::pair<ParameterGroup, NamedValues::value_type>> list;

 private:
  void Add(const ParameterInfo& info, ParameterValue value) {
    list.push_back({info.group, {info.key, std::move(value)}});
  }
};

std::vector<std::pair<ParameterGroup, NamedValues::value_type>> ListWithGroups(const Parameters& parameters) {
  Parameters copy = parameters;
  Lister lister;
  VisitParameters(copy, lister);
  return lister.list;
}

}  // namespace

std::string FormatValue(const ParameterValue& value) {
  return std::visit([](const auto& plain) { return fmt::format("{}", plain); }, value);
}

NamedValues ListParameters(const Parameters& parameters) {
  NamedValues values;
  for (auto& [group, value] : ListWithGroups(parameters)) values.push_back(std::move(value));
  return values;
}

NamedValues ListParameters(const Parameters& parameters, const std::vector<ParameterGroup>& groups) {
  NamedValues values;
  for (auto& [group, value] : ListWithGroups(parameters)) {
    if (std::find(groups.begin(), groups.end(), group) != groups.end()) values.push_back(std::move(value));
  }
  return values;
}

void CheckConsistency(const Parameters& parameters) {
  const ScanParameters& scan = parameters.scan;
  if (scan.range_min_m <= scan.range_max_m) return;
  throw std::runtime_error("range_min_m: " + FormatNumber(scan.range_min_m) + " is more than range_max_m, " +
                           FormatNumber(scan.range_max_m));
}

}  // namespace crsm
