#include "tests/experiments/page.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

namespace crsm {

std::string TitleOf(const std::string& world) { return "environment " + world.substr(3); }

std::string Show(double value, int decimals) {
  if (std::isnan(value)) return "not run";
  return std::isinf(value) ? "lost" : fmt::format("{:.{}f}", value, decimals);
}

Spread Page::SpreadOf(Run run, Figure figure, bool low_is_bad) const {
  std::vector<double> values;
  for (run.seed = 1; run.seed <= plan_.num_seeds; ++run.seed) {
    const auto found = outcomes_.find(NameOf(run));
    if (found != outcomes_.end() && !std::isnan(found->second.*figure)) values.push_back(found->second.*figure);
  }
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  // The upper one of two middle values: a mean with an infinite one would say nothing.
  return {values[values.size() / 2], low_is_bad ? values.front() : values.back()};
}

std::string Page::Cells(Run run, Figure figure, int decimals, bool low_is_bad) const {
  std::string cells;
  for (const std::string& profile : kProfiles) {
    run.profile = profile;
    const Spread spread = SpreadOf(run, figure, low_is_bad);
    cells += fmt::format(" {} ({}) |", Show(spread.median, decimals), Show(spread.worst, decimals));
  }
  return cells;
}

void Page::ShowMap(const Run& run) {
  const std::string path = fmt::format("maps/{}/overview.png", NameOf(run));
  if (std::filesystem::exists(out_ / path)) Add("![{}]({})", NameOf(run), path);
}

void Page::Draw(const std::string& name, const std::string& caption, const std::string& settings,
                const std::function<std::string(const std::string& world)>& curves) {
  const std::filesystem::path script = out_ / (name + ".gnuplot");
  std::ofstream file(script);
  file << fmt::format(
      "set terminal svg size 1200,380 background 'white'\nset output '{}'\nset multiplot layout 1,3\n{}",
      (out_ / (name + ".svg")).string(), settings);
  for (const std::string& world : kMapped) file << fmt::format("set title '{}'\n{}\n", TitleOf(world), curves(world));
  file.close();
  if (!file || std::system(fmt::format("gnuplot '{}'", script.string()).c_str()) != 0) {
    throw std::runtime_error(fmt::format("gnuplot cannot draw {}", script.string()));
  }
  Add("![{}]({}.svg)\n", caption, name);
}

void Page::Save() const {
  const std::filesystem::path path = out_ / "results.md";
  std::ofstream file(path);
  if (!(file << text_ && file.flush())) throw std::runtime_error(fmt::format("cannot write {}", path.string()));
}

}  // namespace crsm
