#pragma once

#include <string>
#include <vector>

namespace crsm {

/// What others wrote, for people: bytes that cannot be printed as '?'.
std::string MakePrintable(std::string text);

/// Without what makes a terminal do something, ends a line, or is no text: each such byte becomes a question mark.
/// Letters of all languages stay.
std::string WithoutControls(std::string text);

/// Names that stand in a file, for people: "ENCODERS, LASER", bytes that cannot be printed as '?', at most 20; "none"
/// of none.
std::string ListPrintable(const std::vector<std::string>& names);

}  // namespace crsm
