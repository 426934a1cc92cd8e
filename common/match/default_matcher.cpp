#include "common/match/default_matcher.hpp"

#include "common/match/rrhc_matcher.hpp"

namespace crsm {

MakeMatcher DefaultMatcher(const Parameters& parameters, const MatchConstants& ours,
                           const PaperMatchConstants& of_paper) {
  return [=](double cell_size_m) -> std::unique_ptr<Matcher> {
    if (parameters.update.algorithm == Algorithm::kPaper) {
      return std::make_unique<PaperMatcher>(parameters.match.seed, cell_size_m, of_paper);
    }
    return std::make_unique<RrhcMatcher>(parameters.match, cell_size_m, ours);
  };
}

}  // namespace crsm
