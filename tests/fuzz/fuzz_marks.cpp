// Lists of marks: read, or refused in words; and what they say is written so that it is read again.

#include <cstdlib>
#include <stdexcept>

#include "common/results/mark_files.hpp"
#include "input.hpp"

namespace crsm {
namespace {

PlacedMark AsPlaced(const Mark& mark) {
  PlacedMark placed;
  placed.id = mark.id;
  placed.kind = mark.kind;
  placed.name = mark.name;
  placed.num_sightings = 1;
  placed.covariance = {mark.radius_m * mark.radius_m, 0.0, mark.radius_m * mark.radius_m};
  placed.points = mark.points;
  return placed;
}

}  // namespace
}  // namespace crsm

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  const MemoryFile file({data, size});
  std::vector<PlacedMark> marks;
  try {
    for (const auto& [mark, line] : ReadMarkList(file.path())) marks.push_back(AsPlaced(mark));
  } catch (const std::runtime_error&) {  // is how a list is refused
    return 0;
  }
  const std::string csv = FormatMarksCsv(marks);
  const MemoryFile written({reinterpret_cast<const std::uint8_t*>(csv.data()), csv.size()});
  if (ReadMarkList(written.path()).size() != marks.size()) std::abort();
  FormatMarksGeoJson(marks);
  return 0;
}
