#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>

#include "common/logs/read_map.hpp"
#include "common/math/format_number.hpp"
#include "common/metrics/trajectory.hpp"
#include "common/results/map_edits.hpp"
#include "common/results/mark_files.hpp"
#include "common/results/mark_masks.hpp"
#include "common/results/rescue_map.hpp"
#include "common/results/results.hpp"
#include "services/base/process.hpp"
#include "services/slam_eval/commands.hpp"

namespace crsm {

namespace {

struct ExportOptions {
  std::string results;
  std::string out;
  std::string team = "team";
  std::string edits;
};

void RunExport(const ExportOptions& options) {
  const std::filesystem::path results = options.results;
  const std::filesystem::path out = options.out.empty() ? results : std::filesystem::path(options.out);
  const DenseGrid grid = ReadMap(results);
  RescueMap map{grid, {}, ReadMarks(results), options.team + ": " + NameOfRun(results)};
  for (const StampedPose& pose : ReadTrajectory((results / "trajectory.tum").string())) map.path.Add(pose.T_map_laser);
  PrepareFolder(out.string());
  Replacement files(out);
  AddMarks(map.marks, files);
  AddMasks(grid, map.marks, files);
  files.Write("map.tif", EncodeRescueMap(map));
  files.RemoveOthers(kMarkFiles);
  if (!options.edits.empty()) {
    AddEditedMap(grid, map.marks, ReadMapEdits(options.edits), files);
    files.RemoveOthers(kEditedFiles);
  }
  std::string names;
  const auto AddName = [&](const char* name) {
    if (files.Has(name)) names += fmt::format("{}{}", names.empty() ? "" : ", ", name);
  };
  std::ranges::for_each(kMarkFiles, AddName);
  std::ranges::for_each(kEditedFiles, AddName);
  files.Rename();
  fmt::print("{}; in {}: {}\n", FormatCount(std::ssize(map.marks), "place"), out.string(), names);
}

}  // namespace

void AddExportCommand(Commands& commands) {
  const auto options = std::make_shared<ExportOptions>();
  commands
      .Add("export", "the map of a run as a GeoTIFF for the RoboCup Rescue League, and its places as files for others",
           [options] { RunExport(*options); })
      .AddWord("RESULTS", options->results, "folder with map.png, map.yaml, trajectory.tum and maybe marks.geojson")
      .AddOption("--out", options->out, "folder to write to; if empty: RESULTS")
      .AddOption("--team", options->team, "name in the picture")
      .AddOption("--edits", options->edits,
                 "file that says how to crop, erase and turn a copy of the map, as the page writes edits.json");
}

}  // namespace crsm
