// Edits of a map: read, or refused in words; what is read is written so that it is read again, and can be applied.

#include <cstdlib>
#include <stdexcept>

#include "common/results/map_edits.hpp"
#include "input.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  try {
    const MapEdits edits = ParseMapEdits({reinterpret_cast<const char*>(data), size});
    const std::string text = FormatMapEdits(edits);
    if (FormatMapEdits(ParseMapEdits(text)) != text) std::abort();
    ApplyEdits({4, 2, -1, -1, 0.5, {255, 0, 127, 255, 255, 0, 127, 0}}, edits);
  } catch (const std::runtime_error&) {  // is how edits are refused
  }
  return 0;
}
