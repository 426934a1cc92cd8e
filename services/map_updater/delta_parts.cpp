#include "services/map_updater/delta_parts.hpp"

namespace crsm {

std::vector<map_delta_t> MakeParts(const MapDelta& delta, std::int64_t utime, const MapGeometry& geometry,
                                   const AnswerOptions& options, const AfterMatch& after) {
  map_delta_t blank{};
  blank.utime = utime;
  blank.epoch = options.epoch;
  blank.version = delta.version;
  blank.cell_size_m = geometry.cell_size_m();
  GrowingMessage part(blank);
  if (after.T_new_old) part.Add(ToMessage(*after.T_new_old), part.message.T_new_old, part.message.num_corrections);
  part.message.trajectory = after.trajectory;
  part.message.floating = after.floating ? 1 : 0;
  std::vector<map_delta_t> parts;
  for (const TileChange& change : delta.tiles) {
    if (part.AddTile(change, options.most_bytes)) continue;
    parts.push_back(std::move(part.message));
    part = GrowingMessage(blank);
    part.AddTile(change, options.most_bytes);
  }
  parts.push_back(std::move(part.message));
  for (std::size_t i = 0; i < parts.size(); ++i) {
    parts[i].part = static_cast<std::int32_t>(i);
    parts[i].num_parts = static_cast<std::int32_t>(parts.size());
  }
  return parts;
}

}  // namespace crsm
