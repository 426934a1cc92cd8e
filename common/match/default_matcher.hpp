#pragma once

#include "common/match/match_constants.hpp"
#include "common/match/matcher.hpp"
#include "common/match/paper_matcher.hpp"
#include "common/parameters.hpp"

namespace crsm {

/// Makes the matcher that is used where no other is given: ours, or that of the paper.
MakeMatcher DefaultMatcher(const Parameters& parameters, const MatchConstants& ours = {},
                           const PaperMatchConstants& of_paper = {});

}  // namespace crsm
