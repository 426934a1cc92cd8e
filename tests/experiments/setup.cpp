#include "tests/experiments/setup.hpp"

#include <cmath>
#include <map>
#include <numeric>

#include "common/match/default_matcher.hpp"
#include "common/scan/paper_selection.hpp"
#include "common/scan/ray_selection.hpp"
#include "tests/parameters_of.hpp"

namespace crsm {
namespace {

std::vector<int> SelectUniform(std::size_t num_rays, int step) {
  std::vector<int> picked;
  for (std::size_t i = 0; i < num_rays; i += static_cast<std::size_t>(step))
    picked.push_back(static_cast<int>(i));  // Eq. 1
  return picked;
}

/// Walks along the contour of the scan and picks a ray each time that another N-th of it lies behind.
std::vector<int> SelectByDensity(const std::vector<double>& displacements, int num_rays) {
  const double total_m = std::accumulate(displacements.begin(), displacements.end(), 0.0);  // Eq. 3
  const double step_m = total_m / num_rays;
  std::vector<int> picked{0};
  double walked_m = 0.0;
  double next_m = step_m;
  for (std::size_t i = 0; i < displacements.size(); ++i) {
    walked_m += displacements[i];
    if (walked_m < next_m || step_m <= 0.0) continue;
    picked.push_back(static_cast<int>(i) + 1);  // Eq. 4
    next_m = step_m * (std::floor(walked_m / step_m) + 1.0);
  }
  return picked;
}

/// The paper's ways to pick rays, sections 4.1 and 4.2, but for segments.
SelectCritical MakeSelection(const std::string& method) {
  constexpr int kSkipStep = 5;      // Eq. 1
  constexpr int kDensityRays = 40;  // N of Eq. 4
  if (method == "all") return [](const ValidRays& rays) { return SelectAll(rays.size()); };
  if (method == "uniform") return [](const ValidRays& rays) { return SelectUniform(rays.size(), kSkipStep); };
  return [](const ValidRays& rays) {
    return rays.size() < 2 ? SelectAll(rays.size()) : SelectByDensity(ComputeDisplacements(rays), kDensityRays);
  };
}

Parameters ShippedParameters(const Run& run) {
  Parameters parameters =
      ParametersOf({"--profile", run.profile, "--preset", run.world == "env4" ? "urg-04lx" : "paper"});
  parameters.match.seed = static_cast<std::uint64_t>(run.seed);
  if (run.world == "env4") parameters.update.cell_size_m = 0.02;  // the paper's, as in the other environments
  return parameters;
}

/// Puts one thing of the other profile into a run, or takes it out.
void Change(const std::string& name, const Parameters& other, Setup& setup) {
  const bool into_paper = setup.parameters.update.algorithm == Algorithm::kPaper;
  Slam::Constants& constants = setup.constants;
  const std::map<std::string, std::function<void()>> changes{
      {"velocity model",
       [&] {
         for (MatchConstants::Prediction* prediction :
              {&constants.match.prediction, &constants.paper_match.prediction}) {
           prediction->motions = 0;
         }
       }},
      {"ray selection", [&] { setup.parts.select = DefaultSelection(other, constants.selection); }},
      {"matcher", [&] { setup.parts.make_matcher = DefaultMatcher(other, constants.match, constants.paper_match); }},
      {"map update",
       [&] {
         setup.parts.select = DefaultSelection(setup.parameters, constants.selection);
         setup.parts.make_matcher = DefaultMatcher(setup.parameters, constants.match, constants.paper_match);
         setup.parameters.update.algorithm = other.update.algorithm;
       }},
      {"sparse updates",
       [&] {
         setup.parameters.update.update_distance_m = into_paper ? 0.2 : 0.0;
         setup.parameters.update.update_angle_rad = into_paper ? 0.17 : 0.0;
       }},
      {"intensity from 0.04 to 0.2",
       [&] {
         constants.paper_drawing.intensity_min = DrawingConstants{}.intensity_min;
         constants.paper_drawing.intensity_max = DrawingConstants{}.intensity_max;
         constants.drawing.intensity_min = PaperDrawingConstants{}.intensity_min;
         constants.drawing.intensity_max = PaperDrawingConstants{}.intensity_max;
       }},
      {"obstacles six times as intense", [&] {
         constants.paper_drawing.occupied_density = DrawingConstants{}.occupied_density;
         constants.drawing.occupied_density = PaperDrawingConstants{}.occupied_density;
       }}};
  changes.at(name)();
}

}  // namespace

Setup SetUp(const Run& run) {
  Setup setup{ShippedParameters(run), {}, {}};
  Slam::Constants& constants = setup.constants;
  constants.match.search.num_evaluations = constants.paper_match.num_evaluations = run.num_evaluations;
  if (run.method != "segments") setup.parts.select = MakeSelection(run.method);
  if (run.changed.empty()) return setup;
  Run other = run;
  other.profile = run.profile == "paper" ? "default" : "paper";
  Change(run.changed, ShippedParameters(other), setup);
  return setup;
}

Band BandOf(const std::string& profile) {
  const PaperSelectionConstants paper;
  if (profile == "paper") return {static_cast<int>(paper.rays_min), static_cast<int>(paper.rays_max)};
  const int most = SelectionParameters{}.rays_max;
  return {static_cast<int>(std::lround(SelectionConstants{}.fewest * most)), most};
}

}  // namespace crsm
