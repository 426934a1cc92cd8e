#include "services/sources/map_parameters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <type_traits>

#include "services/runtime/usage_error.hpp"

namespace crsm {
namespace {

class Lister {
 public:
  template <class Value, class... Rest>
  void operator()(const ParameterInfo& info, const Value& value, const Rest&...) {
    static_assert(std::is_arithmetic_v<Value>, "of the parameters of a map none is a choice");
    texts.emplace_back(info.key, fmt::format("{}", value));
  }

  ParameterTexts texts;
};

ParameterTexts ListLaserParameters(const Parameters& parameters) {
  ScanParameters scan = parameters.scan;
  Lister lister;
  VisitScanParameters(scan, lister);
  return lister.texts;
}

}  // namespace

ParameterTexts ListMapParameters(const Parameters& parameters) {
  UpdateParameters update = parameters.update;
  Lister lister{ListLaserParameters(parameters)};
  VisitUpdateParameters(update, lister);
  return lister.texts;
}

void AdoptMapParameters(const std::filesystem::path& folder, CommandLine& command_line) {
  if (const auto head = ReadHead(folder)) command_line.Adopt(head->subject.parameters, folder.string());
}

void CheckLaserParameters(const std::filesystem::path& folder, const CommandLine& command_line) {
  const auto head = ReadHead(folder);
  if (!head) return;
  const ParameterTexts& made_with = head->subject.parameters;
  std::vector<std::string> wrong;
  for (const auto& parameter : ListLaserParameters(command_line.parameters())) {
    const auto found = std::find_if(made_with.begin(), made_with.end(),
                                    [&](const auto& other) { return other.first == parameter.first; });
    if (found != made_with.end() && *found != parameter) {
      wrong.push_back(fmt::format("{} {}", FlagOf(found->first), found->second));
    }
  }
  if (wrong.empty()) return;
  throw UsageError(
      fmt::format("the map of {} was made with {}: give this to {} and ray_selector, or the --preset of "
                  "its first run",
                  folder.string(), fmt::join(wrong, " "), command_line.program()));
}

}  // namespace crsm
