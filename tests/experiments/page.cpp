#include "tests/experiments/page.hpp"

#include <algorithm>
#include <cmath>

namespace crsm {

std::string TitleOf(const std::string& world) { return "environment " + world.substr(3); }

std::string Show(double value, int decimals) {
  if (std::isnan(value)) return "not run";
  return std::isinf(value) ? "lost" : fmt::format("{:.{}f}", value, decimals);
}

Spread Page::SpreadOf(Run run, Figure figure) const {
  std::vector<double> values;
  for (run.seed = 1; run.seed <= plan_.num_seeds; ++run.seed) {
    const auto found = outcomes_.find(NameOf(run));
    if (found != outcomes_.end() && !std::isnan(found->second.*figure)) values.push_back(found->second.*figure);
  }
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  // The upper one of two middle values: a mean with an infinite one would say nothing.
  return {values[values.size() / 2], values.back()};
}

std::string Page::Cells(Run run, Figure figure, int decimals) const {
  std::string cells;
  for (const std::string& profile : kProfiles) {
    run.profile = profile;
    const Spread spread = SpreadOf(run, figure);
    cells += fmt::format(" {} ({}) |", Show(spread.median, decimals), Show(spread.worst, decimals));
  }
  return cells;
}

}  // namespace crsm
