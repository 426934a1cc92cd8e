#include "services/slam_eval/placed_scans.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "common/graph/mapper.hpp"
#include "common/scan/deskew.hpp"
#include "services/base/process.hpp"
#include "services/journal/earlier_results.hpp"
#include "services/journal/journal.hpp"
#include "services/journal/map_parameters.hpp"
#include "services/journal/run_folder.hpp"

namespace crsm {

std::vector<PlacedScan> ReadPlacedScans(const std::filesystem::path& results) {
  const RunFolder folder = FindRun(results);
  const std::filesystem::path journal = FindJournal(folder.run).parent_path();
  const auto head = ReadHead(journal);
  if (!head) throw std::runtime_error(fmt::format("{}: its journal has no scans", results.string()));
  if (head->subject.finished_map) {
    throw std::runtime_error(
        fmt::format("{}: was localised on the map of another run: give the folder of that run", results.string()));
  }
  CheckAreOfOneMap(folder.run);
  const Parameters parameters = ReadMapParameters(journal);
  Mapper mapper(parameters.update, parameters.loops);
  mapper.PutOffDrawing();
  std::vector<PlacedScan> scans;
  const std::string notice = ReadJournal(journal, {false, ListMapParameters(parameters)}, OnDamage::kRefuse,
                                         {[&](const CriticalRays* scan, const ScanMatch& match) {
                                            const bool drawn = mapper.Restore(scan, match).delta.drawn;
                                            if (!mapper.closes_loops() && drawn) {
                                              scans.push_back({Deskew(scan->rays, match.twist), match.T_map_laser});
                                            }
                                          },
                                          [&](const GraphUpdate& update) { return mapper.Accept(update); }});
  if (!notice.empty()) Say(fmt::format("slam_eval: {}", notice));
  if (!mapper.closes_loops()) return scans;
  const int component = mapper.FindComponent(folder.piece);
  if (component < 0) {
    throw std::runtime_error(fmt::format("{}: its map has no piece {}", folder.run.string(), folder.piece));
  }
  for (const KeyframeId id : mapper.graph().ids()) {
    if (!mapper.IsKeyframeOf(component, id)) continue;
    scans.push_back({mapper.graph().keyframe(id).rays, At(mapper.best_poses(), id)});
  }
  return scans;
}

}  // namespace crsm
