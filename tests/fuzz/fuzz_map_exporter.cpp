// WHOLE_MAP and SERVICE_STATUS, as map_exporter takes them: replica, rectangle and summary.

#include "common/map/byte_map.hpp"
#include "common/results/summary.hpp"
#include "input.hpp"
#include "matcher_replica.hpp"
#include "services/settings/command_line.hpp"
#include "services/wire/conversions.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  ByteMap map(1.0);
  std::vector<ScanMatch> matches;
  MapReplica replica(77,
                     {[&](double cell_size_m) {
                        map = ByteMap(cell_size_m);
                        matches.clear();
                      },
                      [&](std::span<const TileChange> changes) {
                        for (const TileChange& change : changes) map.Apply(change);
                      },
                      [&](const ScanMatch& match) { matches.push_back(match); }},
                     MapReplica::View::kWhole);
  Summary summary;
  MessageReader messages({data, size});
  while (const auto bytes = messages.Next()) {
    if (auto page = Decode<map_page_t>(*bytes)) {
      HandleAsAsked(std::move(*page), replica);
    } else if (const auto status = Decode<service_status_t>(*bytes)) {
      for (std::size_t i = 0; i < status->counter_name.size(); ++i) {
        summary.counts[status->name + "." + status->counter_name[i]] = status->counter_value[i];
      }
      summary.timings[status->name] = {status->latency_p50_ms, status->latency_p95_ms, status->latency_p99_ms,
                                       status->latency_max_ms};
      for (std::size_t i = 0; i < status->parameter_name.size(); ++i) {
        const std::string& key = status->parameter_name[i];
        summary.parameters[status->name].emplace_back(key, ReadValue(key, status->parameter_value[i]));
      }
    }
  }
  // The largest rectangle takes a good part of a second: more than there is to learn from it.
  const bool large = map.tiles().rectangle().num_places() > 2048;
  const DenseGrid grid = large ? DenseGrid{} : map.ToDenseGrid();
  RunStatistics statistics;
  for (const ScanMatch& match : matches) statistics.Add(match);
  summary.values = statistics.values();
  summary.explored_area_m2 = ComputeExploredArea(grid);
  FormatSummary(summary);
  return 0;
}
