#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/results/read_results.hpp"
#include "services/base/printable.hpp"
#include "services/journal/journal.hpp"
#include "services/slam_eval/commands.hpp"

namespace crsm {

namespace {

struct SummaryOptions {
  std::vector<std::string> folders;
  bool csv = false;
};

using Row = std::array<std::string, 10>;
constexpr std::size_t kNumTexts = 2;  ///< columns at the left that are no numbers

Row MakeHead() {
  return {"run", "verdict", "scans", "floating", "lost", "without_rays", "left_out", "loops", "fitness", "wall_s"};
}

/// The verdict, unless it is on another map than that of the journal beside it.
std::string DescribeTrust(const std::string& folder, const RunSummary& summary) {
  const bool of_another = !summary.identity.empty() && IsOfAnotherMap(JournalFolder(folder), summary.identity);
  return of_another ? "of another map than its journal" : WithoutControls(summary.trust);
}

Row MakeRow(const std::string& folder, const RunSummary& summary) {
  return {folder,
          DescribeTrust(folder, summary),
          fmt::format("{}", summary.scans),
          fmt::format("{}", summary.floating),
          fmt::format("{}", summary.lost),
          fmt::format("{}", summary.without_rays),
          fmt::format("{}", summary.left_out),
          summary.loops ? fmt::format("{}", *summary.loops) : "-",
          fmt::format("{:.3f}", summary.mean_fitness),
          summary.wall_s ? fmt::format("{:.1f}", *summary.wall_s) : "-"};
}

std::string Quote(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

void PrintCsv(const std::vector<Row>& rows) {
  for (Row row : rows) {
    std::transform(row.begin(), row.end(), row.begin(), Quote);
    fmt::print("{}\n", fmt::join(row, ","));
  }
}

void PrintTable(const std::vector<Row>& rows) {
  std::array<std::size_t, std::tuple_size_v<Row>> widths{};
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  for (const Row& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      line += i < kNumTexts ? fmt::format("{:<{}}  ", row[i], widths[i]) : fmt::format("{:>{}}  ", row[i], widths[i]);
    }
    fmt::print("{}\n", line.substr(0, line.find_last_not_of(' ') + 1));
  }
}

void RunSummaries(const SummaryOptions& options) {
  std::vector<Row> rows{MakeHead()};
  std::vector<std::string> errors;
  for (const std::string& folder : options.folders) {
    try {
      rows.push_back(MakeRow(folder, ReadSummary(folder)));
    } catch (const std::runtime_error& error) {
      errors.emplace_back(error.what());
    }
  }
  options.csv ? PrintCsv(rows) : PrintTable(rows);
  if (errors.empty()) return;
  throw std::runtime_error(
      fmt::format("{} of {} runs have no summary: {}", errors.size(), options.folders.size(), fmt::join(errors, "; ")));
}

}  // namespace

void AddSummaryCommand(Commands& commands) {
  const auto options = std::make_shared<SummaryOptions>();
  commands
      .Add("summary", "Prints one line for each run: its verdict and its main numbers",
           [options] { RunSummaries(*options); })
      .AddWords("RESULTS", options->folders, "folders with summary.json")
      .AddFlag("--csv", options->csv, "print comma-separated values");
}

}  // namespace crsm
