#include "common/parameters.hpp"

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

}  // namespace

std::vector<std::pair<std::string, ParameterValue>> ListParameters(const Parameters& parameters) {
  Parameters copy = parameters;
  Lister lister;
  VisitParameters(copy, lister);
  return lister.list;
}

}  // namespace crsm
