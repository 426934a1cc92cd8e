#include "services/run_stack/outcome.hpp"

#include <fmt/core.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>

#include "common/diagnosis/verdict.hpp"
#include "common/logs/regular_file.hpp"
#include "services/base/process.hpp"
#include "services/journal/journal.hpp"

namespace crsm {
namespace {

/// Without exceptions: one that cannot be read is no object.
nlohmann::json ReadJson(const std::filesystem::path& path) {
  try {
    return nlohmann::json::parse(ReadWholeFile(path), nullptr, false);
  } catch (const std::runtime_error&) {
    return {};
  }
}

}  // namespace

std::optional<Outcome> ReadOutcome(const std::filesystem::path& summary) {
  const auto json = ReadJson(summary);
  if (!json.is_object()) return std::nullopt;
  Outcome outcome;
  const auto CountOf = [&json](const char* name) {
    const auto count = json.find(name);
    return count != json.end() && count->is_number_integer() ? count->get<std::int64_t>() : 0;
  };
  outcome.ended = json.value("ended", nlohmann::json(false)) == true;
  outcome.counts.on_map = CountOf("on_map");
  outcome.counts.floating = CountOf("floating");
  outcome.counts.lost = CountOf("lost");
  outcome.counts.without_rays = CountOf("without_rays");
  const auto identity = json.find("identity");
  if (identity != json.end() && identity->is_string()) outcome.identity = identity->get<std::string>();
  const auto verdict = json.find("verdict");
  if (verdict == json.end() || !verdict->is_object()) return std::nullopt;
  outcome.trusted = verdict->value("trust", nlohmann::json(Name(Trust::kBad))) != Name(Trust::kBad);
  for (const auto& line : verdict->value("lines", nlohmann::json::array())) {
    if (line.is_string()) outcome.verdict.push_back(line.get<std::string>());
  }
  const auto counts = json.find("counts");
  if (counts == json.end() || !counts->is_object()) return outcome;
  for (const auto& [name, count] : counts->items()) {
    if (!std::string_view(name).ends_with(".dropped_overload") || !count.is_number_integer()) continue;
    outcome.dropped_overload += count.get<std::int64_t>();
  }
  return outcome;
}

int ReportOutcome(const std::filesystem::path& out, bool strict) {
  const std::filesystem::path summary = out / "summary.json";
  const auto outcome = ReadOutcome(summary);
  CheckAreOfOneMap(out);
  if (outcome && !outcome->ended) {
    throw std::runtime_error(fmt::format(
        "{} is of scan {}, when the run had not ended: its end could not be written, and there is no verdict "
        "on the map; its journal has more: --resume {} goes on from there",
        summary.string(), outcome->counts.scans(), out.string()));
  }
  if (outcome) {
    for (const std::string& line : outcome->verdict) fmt::print("{}\n", line);
    if (outcome->dropped_overload > 0)
      fmt::print("{} scans dropped: the machine is too slow\n", outcome->dropped_overload);
    fmt::print("see {}\n", out.string());
  } else if (strict) {
    throw std::runtime_error(fmt::format("--strict: {} has no verdict on the map", summary.string()));
  }
  return strict && !outcome->trusted ? kUntrustedExitCode : EXIT_SUCCESS;
}

}  // namespace crsm
