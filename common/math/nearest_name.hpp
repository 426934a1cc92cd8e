#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace crsm {

/// Damerau-Levenshtein distance: how many letters must be inserted, removed, replaced, or swapped with their neighbour
/// to make one text of the other. No letter is changed twice (optimal string alignment). Capital and small letters are
/// the same.
std::size_t EditDistance(std::string_view a, std::string_view b);

/// The name that a mistyped `text` stands for: the one with the least distance, the first of several. Empty if all are
/// further away than a third of the letters of `text`.
std::string FindNearestName(std::string_view text, const std::vector<std::string>& names);

/// "; did you mean sick?" for the end of an error, or nothing. `before`: what stands before the name, such as "sim:".
std::string SuggestName(std::string_view text, const std::vector<std::string>& names, std::string_view before = "");

}  // namespace crsm
