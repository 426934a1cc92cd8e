#include "services/run_stack/outcome.hpp"

#include <fmt/core.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>

namespace crsm {

std::optional<Outcome> ReadOutcome(const std::filesystem::path& summary) {
  std::ifstream file(summary);
  const auto json = nlohmann::json::parse(file, nullptr, false);  // without exceptions
  if (!json.is_object()) return std::nullopt;
  const auto Count = [](const nlohmann::json& object, const std::string& key) -> std::int64_t {
    const auto value = object.find(key);
    return value != object.end() && value->is_number_integer() ? value->get<std::int64_t>() : 0;
  };
  Outcome outcome{Count(json, "scans"), Count(json, "lost")};
  if (const auto trusted = json.find("trusted"); trusted != json.end() && trusted->is_boolean()) {
    outcome.trusted = trusted->get<bool>();
  }
  const auto counts = json.find("counts");
  if (counts == json.end() || !counts->is_object()) return outcome;
  for (const auto& [name, count] : counts->items()) {
    if (std::string_view(name).ends_with(".dropped_overload")) outcome.dropped_overload += Count(*counts, name);
  }
  return outcome;
}

int ReportOutcome(const std::filesystem::path& out, bool strict) {
  const auto outcome = ReadOutcome(out / "summary.json");
  if (outcome) {
    fmt::print("{} scans mapped, {} lost, {} dropped; see {}\n", outcome->scans, outcome->lost,
               outcome->dropped_overload, out.string());
  }
  if (!strict) return EXIT_SUCCESS;
  if (!outcome || !outcome->trusted) {
    throw std::runtime_error(fmt::format("--strict: {} has no verdict on the map", (out / "summary.json").string()));
  }
  return *outcome->trusted ? EXIT_SUCCESS : kUntrustedExitCode;
}

}  // namespace crsm
