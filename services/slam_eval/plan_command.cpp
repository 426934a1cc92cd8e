#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/logs/regular_file.hpp"
#include "common/logs/replacement.hpp"
#include "common/results/read_results.hpp"
#include "services/base/printable.hpp"
#include "services/base/usage_error.hpp"
#include "services/slam_eval/commands.hpp"
#include "services/slam_eval/placed_scans.hpp"
#include "services/slam_eval/plan_drawing.hpp"

namespace crsm {
namespace {

struct PlanOptions {
  std::string results;
  std::string out;
  std::string paper = "a4";
  double scale = 0.0;
  std::string names;
};

/// Lines of `x_m y_m NAME`.
std::vector<NamedPlace> ReadNames(const std::string& path) {
  std::vector<NamedPlace> names;
  std::istringstream lines(ReadWholeFile(path));
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    std::istringstream words(line);
    NamedPlace place;
    words >> place.at.x_m >> place.at.y_m >> std::ws;
    const bool has_place = !words.fail() && std::isfinite(place.at.x_m) && std::isfinite(place.at.y_m);
    std::getline(words, place.name);
    if (!has_place || place.name.empty()) {
      throw std::runtime_error(
          fmt::format("{} line {}: must be a place on the map and a name: x_m y_m NAME", path, number));
    }
    place.name = WithoutControls(place.name);
    names.push_back(place);
  }
  return names;
}

/// "1 room", "2 rooms".
std::string CountOf(std::size_t num, const char* name) {
  return fmt::format("{} {}{}", num, name, num == 1 ? "" : "s");
}

/// What a plan tells of itself, a line each.
std::vector<std::string> MakeTitle(const std::string& results, const Plan& plan) {
  double area_m2 = 0.0;
  for (const PlanRoom& room : plan.rooms) area_m2 += room.area_m2;
  std::vector<std::string> title{fmt::format("{}, {:.1f} m2", CountOf(plan.rooms.size(), "room"), area_m2)};
  try {
    const RunSummary summary = ReadSummary(results);
    title.front() = (summary.made_from.empty() ? results : summary.made_from) + ": " + title.front();
    if (!summary.recorded.empty()) title.push_back("recorded " + summary.recorded);
    if (!summary.mapped.empty()) title.push_back("mapped " + summary.mapped);
    title.push_back(
        fmt::format("the map is {}{}", summary.trust,
                    summary.off_m ? fmt::format(", parts of it may be off by up to {:.2f} m", *summary.off_m) : ""));
  } catch (const std::runtime_error&) {  // of a piece, or of a run that was killed
    title.front() = results + ": " + title.front();
    title.push_back("of this map there is no verdict");
  }
  for (std::string& line : title) line = WithoutControls(line);
  return title;
}

enum class FileKind { kSvg, kPdf, kDxf };

FileKind KindOf(const std::filesystem::path& file) {
  const std::string ending = file.extension().string();
  if (ending == ".svg") return FileKind::kSvg;
  if (ending == ".pdf") return FileKind::kPdf;
  if (ending == ".dxf") return FileKind::kDxf;
  throw UsageError(fmt::format("--out {}: must end in .svg, .pdf or .dxf", file.string()));
}

void RunPlan(const PlanOptions& options) {
  if (options.out.empty()) throw UsageError("--out is missing: give a file that ends in .svg, .pdf or .dxf");
  const std::filesystem::path file(options.out);
  const FileKind kind = KindOf(file);
  if (!(options.scale >= 0.0 && options.scale <= 1e6) || options.scale != std::floor(options.scale)) {  // NaN too
    throw UsageError(
        fmt::format("--scale is {}, must be a whole number within 1 and 1,000,000: 100 for 1:100", options.scale));
  }
  const Paper paper = ParsePaper(options.paper);
  std::error_code error;
  if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error)) {
    throw UsageError(fmt::format("--out {}: is no regular file; choose another one", options.out));
  }
  const std::vector<NamedPlace> names = options.names.empty() ? std::vector<NamedPlace>() : ReadNames(options.names);
  Plan plan = MakePlan(ReadPlacedScans(options.results), names);
  if (plan.walls.empty()) {
    throw std::runtime_error(
        fmt::format("{}: no straight walls were found in its scans, so there is no plan", options.results));
  }
  try {
    plan.map_off_m = ReadSummary(options.results).off_m.value_or(0.0);
  } catch (const std::runtime_error&) {  // MakeTitle says so
  }
  const std::vector<std::string> title = MakeTitle(options.results, plan);
  std::string scale;
  std::string bytes;
  if (kind == FileKind::kDxf) {
    bytes = FormatDxf(plan, title);
  } else {
    const PaperLayout layout = LayOut(plan, paper, static_cast<int>(options.scale));
    bytes = DrawPlan(plan, layout, title, kind == FileKind::kSvg ? DrawingKind::kSvg : DrawingKind::kPdf);
    scale = fmt::format(", {} 1:{}", paper.name, layout.scale);
  }
  Replacement replacement(file.has_parent_path() ? file.parent_path() : ".");
  replacement.Write(file.filename().string(), bytes);
  replacement.Rename();
  double length_m = 0.0;
  for (const PlanWall& wall : plan.walls) length_m += wall.length_m;
  fmt::print("{}: {} of {:.1f} m, {}, {}{}\n", options.out, CountOf(plan.walls.size(), "wall"), length_m,
             CountOf(plan.doors.size(), "door"), CountOf(plan.rooms.size(), "room"), scale);
}

}  // namespace

void AddPlanCommand(Commands& commands) {
  const auto options = std::make_shared<PlanOptions>();
  commands
      .Add("plan", "Draws a floor plan of a finished run: walls, doors and rooms, with lengths and areas",
           [options] { RunPlan(*options); })
      .AddWord("RESULTS", options->results, "folder of a run, or of a piece of its map")
      .AddOption("--out", options->out, "file for the plan: .svg, .pdf or .dxf (R12, metres)")
      .AddOption("--paper", options->paper, "a4 or a3")
      .AddOption("--scale", options->scale, "100 for 1:100; 0 for the largest that fits the paper")
      .AddOption("--names", options->names, "file with the names of rooms: lines of x_m y_m NAME, map frame");
}

}  // namespace crsm
