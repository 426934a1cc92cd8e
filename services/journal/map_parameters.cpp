#include "services/journal/map_parameters.hpp"

#include <fmt/format.h>

#include "services/base/usage_error.hpp"

namespace crsm {

void AdoptMapParameters(const std::filesystem::path& folder, CommandLine& command_line) {
  if (const auto head = ReadHead(folder)) command_line.Adopt(head->subject.parameters, folder.string());
}

Parameters ReadMapParameters(const std::filesystem::path& folder) {
  using enum ParameterGroup;
  CommandLine of_map("journal", "", {kScan, kUpdate, kLoops}, {});
  AdoptMapParameters(folder, of_map);
  return of_map.parameters();
}

void AdoptEarlierMapParameters(const std::string& resume, CommandLine& command_line) {
  const std::string& earlier = resume.empty() ? command_line.settings().localize : resume;
  if (!earlier.empty()) AdoptMapParameters(JournalFolder(earlier), command_line);
}

void CheckLaserParameters(const std::filesystem::path& folder, const CommandLine& command_line) {
  const auto head = ReadHead(folder);
  if (!head) return;
  const auto wanted = ListTexts(command_line.parameters(), {ParameterGroup::kLaser, ParameterGroup::kScan});
  std::vector<std::string> wrong;
  for (const auto& [key, made_with, value] : FindDifferences(head->subject.parameters, wanted)) {
    wrong.push_back(fmt::format("{} {}", FlagOf(key), made_with));
  }
  if (wrong.empty()) return;
  throw UsageError(fmt::format(
      "the map of {} was made with {}: give {} and ray_selector the same flags, or the --preset of its first run",
      folder.string(), fmt::join(wrong, " "), command_line.program()));
}

}  // namespace crsm
