#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/marks/mark_book.hpp"
#include "common/results/mark_files.hpp"
#include "services/journal/match_store.hpp"

namespace crsm {

/// A list of places for a map that is made: --marks FILE.
struct MarksOfFile {
  std::string path;
  std::vector<ListedMark> marks;
};

/// Fixes the marks of a file to the map, hands each that is new to `keep`, and puts it into the book. In one line each,
/// which were left out, and why.
std::vector<std::string> TakeMarks(const MarksOfFile& file, const Mapper& mapper, const MatchStore& matches,
                                   MarkBook& book, const std::function<void(const FixedMark&)>& keep);

}  // namespace crsm
