#include "services/run_stack/outcome.hpp"

#include <fmt/core.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>

#include "common/diagnosis/verdict.hpp"
#include "common/logs/regular_file.hpp"
#include "common/math/format_number.hpp"
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

/// Nothing where one of them is no change.
std::optional<std::vector<MapChange>> ReadChanges(const nlohmann::json& list) {
  std::vector<MapChange> changes;
  try {
    for (const auto& one : list) {
      MapChange& change = changes.emplace_back();
      change.kind = one.at("kind") == Name(ChangeKind::kNew) ? ChangeKind::kNew : ChangeKind::kGone;
      change.middle = {one.at("x_m").get<double>(), one.at("y_m").get<double>()};
      change.length_m = one.at("length_m").get<double>();
      change.width_m = one.at("width_m").get<double>();
      change.num_places = one.at("places").get<std::int32_t>();
    }
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
  return changes;
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
  const auto changes = json.find("changes");
  if (changes != json.end() && changes->is_array()) outcome.changes = ReadChanges(*changes);
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

int ReportOutcome(const std::filesystem::path& out, bool strict, const ChangesOver& changes_over) {
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
    if (outcome->changes) {
      for (const std::string& line : FormatChanges(*outcome->changes)) fmt::print("{}\n", line);
    }
    for (const std::string& line : outcome->verdict) fmt::print("{}\n", line);
    if (outcome->dropped_overload > 0)
      fmt::print("{} dropped: the machine is too slow\n", FormatCount(outcome->dropped_overload, "scan"));
    fmt::print("see {}\n", out.string());
  } else if (strict) {
    throw std::runtime_error(fmt::format("--strict: {} has no verdict on the map", summary.string()));
  }
  if (changes_over.was_given() && !(outcome && outcome->changes)) {
    throw std::runtime_error(fmt::format("--changes-over: {} does not say what has changed", summary.string()));
  }
  if (strict && !outcome->trusted) return kUntrustedExitCode;
  const bool has_changed = outcome && outcome->changes && changes_over.IsExceededBy(LargestArea(*outcome->changes));
  return has_changed ? kChangedExitCode : EXIT_SUCCESS;
}

}  // namespace crsm
