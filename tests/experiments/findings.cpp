#include "tests/experiments/findings.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "tests/experiments/paper_figures.hpp"
#include "tests/experiments/setup.hpp"

namespace crsm {
namespace {

constexpr double kFailedCmse_px2 = 100.0;  // ten cells: the map has another structure than the world

Run Standard(const Page& page, const std::string& world, const std::string& profile,
             const std::string& method = "segments") {
  return {world, profile, method, page.plan().standard_evaluations};
}

/// The least that any row or method of the paper's Tables 1 to 5 reaches with N_HC = 10000.
PaperRow BestPublished(const std::string& world) {
  PaperRow best = kPaperByEvaluations.at(world).at(10000);
  for (const auto& [method, row] : kPaperByMethod.at(world)) {
    best.omse_px2 = std::min(best.omse_px2, row.omse_px2);
    best.cmse_px2 = std::min(best.cmse_px2, row.cmse_px2);
  }
  return best;
}

/// A figure of a selection method: the paper's, or ours of a profile.
using MethodFigure = std::function<double(const std::string& world, const std::string& method)>;

/// What speaks against a claim; "" if nothing does.
using Objection = std::function<std::string(const std::string& world)>;

std::string Verdict(const std::vector<std::string>& worlds, const Objection& objection) {
  std::string objections;
  for (const std::string& world : worlds) {
    const std::string found = objection(world);
    if (!found.empty())
      objections += fmt::format("{} env. {}: {}", objections.empty() ? "" : ";", world.substr(3), found);
  }
  return objections.empty() ? "**confirmed**" : "**refuted**:" + objections;
}

std::string JudgeLeast(const MethodFigure& figure) {
  return Verdict(kMapped, [&](const std::string& world) -> std::string {
    const auto Less = [&](const std::string& a, const std::string& b) { return figure(world, a) < figure(world, b); };
    const std::string best = *std::min_element(kSelectionMethods.begin(), kSelectionMethods.end(), Less);
    if (std::isinf(figure(world, best))) return "all lost";
    if (!Less(best, "segments")) return "";
    return fmt::format("{} {}, segments {}", best, Show(figure(world, best), 2), Show(figure(world, "segments"), 2));
  });
}

std::string JudgeDensity(const MethodFigure& cmse_px2) {
  return Verdict({"env2", "env3"}, [&](const std::string& world) -> std::string {
    if (cmse_px2(world, "density") > kFailedCmse_px2 && cmse_px2(world, "segments") <= kFailedCmse_px2) return "";
    return fmt::format("density {}, segments {}", Show(cmse_px2(world, "density"), 2),
                       Show(cmse_px2(world, "segments"), 2));
  });
}

std::string JudgeSlowest(const std::vector<std::string>& worlds, const MethodFigure& ms) {
  return Verdict(worlds, [&](const std::string& world) -> std::string {
    const auto Less = [&](const std::string& a, const std::string& b) { return ms(world, a) < ms(world, b); };
    const std::string slowest = *std::max_element(kSelectionMethods.begin(), kSelectionMethods.end(), Less);
    if (!Less("all", slowest)) return "";
    return fmt::format("{} {} ms, all {} ms", slowest, Show(ms(world, slowest), 2), Show(ms(world, "all"), 2));
  });
}

std::string JudgeBand(const std::vector<std::string>& worlds, const MethodFigure& rays, int low, int high) {
  return Verdict(worlds, [&](const std::string& world) -> std::string {
    const double mean = rays(world, "segments");
    return mean >= low && mean <= high ? "" : Show(mean, 2);
  });
}

/// The paper's printed errors, all of them: how many the paper profile does not reach.
void CountShortfall(Page& page) {
  int num_worse = 0;
  int num_figures = 0;
  const auto Count = [&](const Run& run, const PaperRow& printed) {
    for (const auto& [figure, value] :
         {std::pair{&Outcome::omse_px2, printed.omse_px2}, {&Outcome::cmse_px2, printed.cmse_px2}}) {
      const double ours = page.SpreadOf(run, figure).median;
      if (std::isnan(ours)) continue;
      ++num_figures;
      if (ours > value) ++num_worse;
    }
  };
  for (const std::string& world : kMapped) {
    for (const auto& [evaluations, row] : kPaperByEvaluations.at(world))
      Count({world, "paper", "segments", evaluations}, row);
    for (const auto& [method, row] : kPaperByMethod.at(world)) Count(Standard(page, world, "paper", method), row);
  }
  page.Add(
      "Of the {} errors of Tables 1 to 5 that were run, the paper profile's median is worse than the printed one in "
      "{}. With density and segments, N_HC = {}:\n",
      num_figures, num_worse, page.plan().standard_evaluations);
  page.Add(
      "| | OMSE published [px2] | paper profile, median | times | CMSE published [px2] | paper profile, median | ATE "
      "[m] | MFV published | paper profile |");
  page.Add("|---|---|---|---|---|---|---|---|---|");
  for (const std::string& world : kMapped) {
    const Run run = Standard(page, world, "paper");
    const PaperRow& printed = kPaperByMethod.at(world).at("segments");
    const double omse_px2 = page.SpreadOf(run, &Outcome::omse_px2).median;
    page.Add("| {} | {:.2f} | {} | {} | {:.2f} | {} | {} | {:.2f} | {} |", TitleOf(world), printed.omse_px2,
             Show(omse_px2, 2), Show(omse_px2 / printed.omse_px2, 1), printed.cmse_px2,
             Show(page.SpreadOf(run, &Outcome::cmse_px2).median, 2),
             Show(page.SpreadOf(run, &Outcome::ate_mean_m).median, 3), kPaperByEvaluations.at(world).at(10000).mfv,
             Show(page.SpreadOf(run, &Outcome::mfv).median, 2));
  }
  page.Add("");
}

Run MatchesOf(const Page& page, const std::string& world, const std::string& profile, Measured measured) {
  Run run = Standard(page, world, profile);
  run.measured = measured;
  if (measured == Measured::kRightMap) run.changed = "velocity model";
  return run;
}

void WriteMatches(Page& page) {
  page.Add("### Single matches, whose true pose is known\n");
  page.Add(
      "A match is *off* if it ends more than a cell from the true pose: then either the true pose fits better, and "
      "**the search missed it**, or it does not, and **the map misleads**. *Right map*: drawn with the true poses; "
      "each match starts at the true last pose (no velocity model). *Own map*: drawn with the run's own poses; the "
      "true pose is the last one moved as the robot moved. Fitness is that of the critical rays, mean over the "
      "scans in which the robot drives, 3 cm each. *A random pose*: the share of random poses of the window that "
      "fit better than the last pose. Seed 1.\n");
  page.Add(
      "| map | | profile | fitness: last pose | true pose | found pose | search missed | map misleads | found part "
      "of the way | a random pose |");
  page.Add("|---|---|---|---|---|---|---|---|---|---|");
  for (const Measured measured : {Measured::kRightMap, Measured::kOwnMap}) {
    for (const std::string& world : kMapped) {
      for (const std::string& profile : kProfiles) {
        const Run run = MatchesOf(page, world, profile, measured);
        const auto Value = [&](Figure figure) { return page.SpreadOf(run, figure).median; };
        const auto Percent = [&](Figure figure) { return Show(100.0 * Value(figure), 0); };
        page.Add("| {} | env. {} | {} | {} | {} | {} | {} % | {} % | {} % | {} % |",
                 measured == Measured::kRightMap ? "right" : "own", world.substr(3), profile,
                 Show(Value(&Outcome::last_fitness), 3), Show(Value(&Outcome::true_fitness), 3),
                 Show(Value(&Outcome::found_fitness), 3), Percent(&Outcome::missed), Percent(&Outcome::misled),
                 Percent(&Outcome::way), Show(100.0 * Value(&Outcome::draws), 3));
      }
    }
  }
  page.Add("");
}

/// What the figures of the single matches say; nothing of worlds that were not run.
void ExplainMatches(Page& page) {
  const auto Range = [&](Measured measured, const std::string& profile, Figure figure) {
    double low = HUGE_VAL;
    double high = -HUGE_VAL;
    for (const std::string& world : kMapped) {
      const double value = 100.0 * page.SpreadOf(MatchesOf(page, world, profile, measured), figure).median;
      low = std::min(low, value);
      high = std::max(high, value);
    }
    return std::round(low) == std::round(high) ? fmt::format("{:.0f} %", low)
                                               : fmt::format("{:.0f} to {:.0f} %", low, high);
  };
  using enum Measured;
  page.Add(
      "1. **The search is too coarse for its target.** On a right map the paper profile's search misses the true pose "
      "in {} of the matches although that pose fits better (default profile: {}), and covers {} of the way. The "
      "window of 0.8 m x 0.8 m x 0.5 rad is wide, the peak of the fitness is about a cell wide, and a climb "
      "whose mutations keep their bounds of 5 cells and 0.1 rad, and which ends at the first child that is no "
      "better, hardly climbs: each restart is little more than one random draw. The pose from which the search "
      "starts is therefore hard to beat, whatever it is.",
      Range(kRightMap, "paper", &Outcome::missed), Range(kRightMap, "default", &Outcome::missed),
      Range(kRightMap, "paper", &Outcome::way));
  const auto Contrast = [&](Measured measured, const std::string& profile) {
    double sum = 0.0;
    for (const std::string& world : kMapped) {
      const Run run = MatchesOf(page, world, profile, measured);
      sum += page.SpreadOf(run, &Outcome::true_fitness).median - page.SpreadOf(run, &Outcome::last_fitness).median;
    }
    return Show(sum / static_cast<double>(kMapped.size()), 3);
  };
  page.Add(
      "2. **The map then keeps the error.** Hits are single cells; on a wall further away or seen at a grazing angle "
      "they do not touch. Drawn at a wrong pose they make one more row of dots beside the wall, and the next scans fit "
      "them as well as the others. On a right map the true pose beats the last pose by {} of fitness, mean of the "
      "three; on the paper profile's own map by {} (default: {} and {}). There, {} of the matches are off because the "
      "true pose fits no better than the found one (default: {}).\n",
      Contrast(kRightMap, "paper"), Contrast(kOwnMap, "paper"), Contrast(kRightMap, "default"),
      Contrast(kOwnMap, "default"), Range(kOwnMap, "paper", &Outcome::misled),
      Range(kOwnMap, "default", &Outcome::misled));
}

void WriteAblation(Page& page) {
  page.Add("### One thing at a time\n");
  page.Add(
      "ATE [m], median (worst) of {} seeds. Left of each pair: the paper profile with one part of the default "
      "profile put in. Right: the default profile with it taken out. The velocity model is in both, and is taken "
      "out of both; since the simulated robot drives at constant speed, it flatters them.\n",
      page.plan().num_ablation_seeds());
  page.Add(
      "| | env. 1 paper with it | default without | env. 2 paper with it | default without | env. 3 paper with it | "
      "default without |");
  page.Add("|---|---|---|---|---|---|---|");
  const auto Row = [&](const std::string& title, const std::string& changed) {
    std::string cells;
    for (const std::string& world : kMapped) {
      Run run = Standard(page, world, "");
      run.changed = changed;
      cells += page.Cells(run, &Outcome::ate_mean_m, 3);
    }
    page.Add("| {} |{}", title, cells);
  };
  Row("the profiles as they are", "");
  for (const std::string& change : kChanges) Row(change == "velocity model" ? "no velocity model" : change, change);
  page.Add("");
  const auto Sum = [&](const std::string& profile, const std::string& changed) {
    double sum = 0.0;
    for (const std::string& world : kMapped) {
      Run run = Standard(page, world, profile);
      run.changed = changed;
      sum += page.SpreadOf(run, &Outcome::ate_mean_m).median;
    }
    return sum / static_cast<double>(kMapped.size());
  };
  const double paper_m = Sum("paper", "");
  const double default_m = Sum("default", "");
  std::string most_helpful;
  std::string most_missed;
  double least_m = paper_m;
  double most_m = default_m;
  for (const std::string& change : kChanges) {
    if (change != "velocity model" && Sum("paper", change) < least_m) {
      least_m = Sum("paper", change);
      most_helpful = change;
    }
    if (Sum("default", change) > most_m) {
      most_m = Sum("default", change);
      most_missed = change;
    }
  }
  if (most_helpful.empty() || most_missed.empty()) return;
  page.Add(
      "Mean of the three medians: {:.3f} m paper profile, {:.3f} m default profile. The one thing that helps the "
      "paper profile most: **{}** ({:.3f} m). The one that the default profile misses most: **{}** ({:.3f} m).\n",
      paper_m, default_m, most_helpful, least_m, most_missed, most_m);
}

/// The default profile beside the paper's best figures.
void WriteSummary(Page& page) {
  page.Add("## Summary\n");
  page.Add(
      "Default profile, density with segments, N_HC at most {}; the worst of {} seeds. *Published*: the least that "
      "any method of the paper's Tables 1 to 5 reaches with N_HC = 10000.\n",
      page.plan().standard_evaluations, page.plan().num_seeds);
  page.Add(
      "| environment | OMSE [px2] published | ours | CMSE [px2] published | ours | trajectory error [m], ours | time "
      "of "
      "a scan [ms], ours |");
  page.Add("|---|---|---|---|---|---|---|");
  const std::vector<std::string> kinds = {"large rooms", "narrow corridors", "one twisted corridor"};
  for (std::size_t i = 0; i < kMapped.size(); ++i) {
    const PaperRow best = BestPublished(kMapped[i]);
    const Run run = Standard(page, kMapped[i], "default");
    const auto Worst = [&](Figure figure, int decimals) { return Show(page.SpreadOf(run, figure).worst, decimals); };
    page.Add("| {}: {} | {:.2f} | {} | {:.2f} | {} | {} | {} |", i + 1, kinds[i], best.omse_px2,
             Worst(&Outcome::omse_px2, 2), best.cmse_px2, Worst(&Outcome::cmse_px2, 2), Worst(&Outcome::ate_mean_m, 3),
             Worst(&Outcome::cpu_ms, 2));
  }
  page.Add("");
}

/// Which of the paper's conclusions about its selection methods hold.
void WriteClaims(Page& page) {
  page.Add("## What the paper concludes about its selection methods\n");
  page.Add(
      "Errors of the worst seed, times and rays of the median one. A method *fails* "
      "if its CMSE is above {:.0f} px2, or lost.\n",
      kFailedCmse_px2);
  page.Add("| conclusion | by the paper's own figures | paper profile | default profile |\n|---|---|---|---|");
  struct Judged {
    MethodFigure omse_px2, cmse_px2, ms, rays;
    int low, high;
  };
  std::vector<Judged> all = {
      {[](const std::string& w, const std::string& m) { return kPaperByMethod.at(w).at(m).omse_px2; },
       [](const std::string& w, const std::string& m) { return kPaperByMethod.at(w).at(m).cmse_px2; },
       [](const std::string& w, const std::string& m) { return kPaperTimes.at(w).at(m).ms; },
       [](const std::string& w, const std::string& m) { return kPaperTimes.at(w).at(m).rays; }, 30, 50}};
  for (const std::string& profile : kProfiles) {
    const auto Ours = [&page, profile](Figure figure, bool worst) -> MethodFigure {
      return [&page, profile, figure, worst](const std::string& world, const std::string& method) {
        const Spread spread = page.SpreadOf(Standard(page, world, profile, method), figure);
        return worst ? spread.worst : spread.median;
      };
    };
    const Band band = BandOf(profile);
    all.push_back({Ours(&Outcome::omse_px2, true), Ours(&Outcome::cmse_px2, true), Ours(&Outcome::cpu_ms, false),
                   Ours(&Outcome::rays, false), band.low, band.high});
  }
  const auto Row = [&](const std::string& claim, const std::function<std::string(const Judged&)>& judge) {
    std::string cells;
    for (const Judged& judged : all) cells += fmt::format(" {} |", judge(judged));
    page.Add("| {} |{}", claim, cells);
  };
  Row("density with segments has the least OMSE in all three environments",
      [](const Judged& j) { return JudgeLeast(j.omse_px2); });
  Row("... and the least CMSE", [](const Judged& j) { return JudgeLeast(j.cmse_px2); });
  Row("density alone fails in corridors, environments 2 and 3, where density with segments does not",
      [](const Judged& j) { return JudgeDensity(j.cmse_px2); });
  Row("all rays is the slowest, in all four environments", [](const Judged& j) { return JudgeSlowest(kTimed, j.ms); });
  Row("density with segments selects within its band, mean of each of the four environments", [](const Judged& j) {
    return fmt::format("{} to {}: {}", j.low, j.high, JudgeBand(kTimed, j.rays, j.low, j.high));
  });
  page.Add("");
}

/// Where the paper profile does worse than the paper prints, by how much, and why.
void WriteShortfall(Page& page) {
  page.Add("## Where the paper profile does worse than the paper, and why\n");
  CountShortfall(page);
  WriteMatches(page);
  ExplainMatches(page);
  WriteAblation(page);
}

}  // namespace

std::string WriteFindings(const Plan& plan, const Outcomes& outcomes) {
  Page page(plan, outcomes);
  page.Add("# The paper's worlds\n");
  WriteSummary(page);
  WriteClaims(page);
  WriteShortfall(page);
  return page.text();
}

}  // namespace crsm
