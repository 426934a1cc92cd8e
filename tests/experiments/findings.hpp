#pragma once

#include "tests/experiments/page.hpp"

namespace crsm {

/// The text of results.md: the default profile beside the paper's best figures; which of the paper's conclusions hold;
/// where the paper profile does worse than the paper prints, and why.
std::string WriteFindings(const Plan& plan, const Outcomes& outcomes);

}  // namespace crsm
