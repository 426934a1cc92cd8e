#pragma once

#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>

#include "input.hpp"
#include "services/sources/bags/bag_source.hpp"

namespace crsm {

/// Reads a bag to its end. What it gives must be what the wire takes.
inline void ReadBagFile(const std::string& path) {
  try {
    BagSource source(path, {});
    while (const auto scan = source.Next()) {
      if (scan->ranges_m.size() < kMinBeams || scan->ranges_m.size() > kMaxBeams || scan->utime < 0) std::abort();
      const double progress = source.Progress();
      if (!(progress >= 0.0 && progress <= 1.0)) std::abort();
    }
    source.Counts();
    source.Complaints();
    source.OdometryNotes();
  } catch (const std::runtime_error&) {  // is how a log is refused
  }
}

/// The same of made-up bytes behind those that tell the kind of a bag: what begins otherwise is none.
inline void ReadBag(std::string_view magic, std::span<const std::uint8_t> made_up) {
  Bytes content(magic.begin(), magic.end());
  const auto rest = made_up.size() >= magic.size() ? made_up.subspan(magic.size()) : made_up;
  content.insert(content.end(), rest.begin(), rest.end());
  const MemoryFile file(content);
  ReadBagFile(file.path());
}

}  // namespace crsm
