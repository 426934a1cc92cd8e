#pragma once

#include "tests/experiments/page.hpp"

namespace crsm {

/// The default profile beside the paper's best figures, as the README quotes it; then both profiles.
void WriteSummary(Page& page);

/// Which of the paper's conclusions about its selection methods hold, computed from the figures of the run.
void WriteClaims(Page& page);

/// Where the paper profile does worse than the paper prints, by how much, and why: single matches and the ablation.
void WriteShortfall(Page& page);

}  // namespace crsm
