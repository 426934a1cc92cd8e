#include "tests/experiments/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <stdexcept>

#include "tests/experiments/findings.hpp"
#include "tests/experiments/page.hpp"
#include "tests/experiments/paper_figures.hpp"

namespace crsm {
namespace {

/// The page, table after table.
class Report : public Page {
 public:
  using Page::Page;

  void Write() {
    WriteHead();
    WriteSummary(*this);
    WriteClaims(*this);
    WriteShortfall(*this);
    for (const std::string number : {"1", "2", "3"}) {
      if (plan_.Has("table" + number)) WriteEvaluations(number);
    }
    WriteEvaluationsUsed();
    if (plan_.Has("table4"))
      WriteMethods("Table 4: OMSE of the selection methods", &Outcome::omse_px2, &PaperRow::omse_px2);
    if (plan_.Has("table5"))
      WriteMethods("Table 5: CMSE of the selection methods", &Outcome::cmse_px2, &PaperRow::cmse_px2);
    if (plan_.Has("table6")) WriteTimes();
    if (plan_.Has("fig21")) DrawCurves("fig21", "MFV", false, &Outcome::mfv, &PaperRow::mfv);
    if (plan_.Has("fig22")) DrawCurves("fig22", "OMSE [px2]", true, &Outcome::omse_px2, &PaperRow::omse_px2);
    if (plan_.Has("fig23")) DrawCurves("fig23", "CMSE [px2]", true, &Outcome::cmse_px2, &PaperRow::cmse_px2);
    if (plan_.Has("fig24")) DrawDistribution();
    if (plan_.Has("fig25")) WriteUpdates();
    if (plan_.Has("radish")) WriteRadish();
    WriteMaps();
    Save();
  }

 private:
  static std::string Printed(double value, int decimals) { return value < 0.0 ? "" : Show(value, decimals); }

  void WriteHead() {
    Add("# The paper's experiments\n");
    Add("Made by `scripts/experiments`. Each figure of ours is the median of {} seeds, and in brackets the worst of "
        "them. *published*: what the paper prints. *paper*: our profile that is the text of the paper to the letter. "
        "*default*: our default profile. All with the laser, the speeds and the cells of 0.02 m of the paper; "
        "the worlds have the paper's areas and kinds, but are our own, since the paper does not print its plans. "
        "OMSE and CMSE are in px2, of cells; an obstacle is a cell with a byte below 127. \"lost\": a named corner is "
        "not within 1 m of its place in the map, so there is no CMSE. ATE: absolute trajectory error, mean over the "
        "path.\n",
        plan_.num_seeds);
    if (plan_.evaluations.back() < 30000)
      Add("**Quick run: one seed and fewer evaluations; only to see that all works.**\n");
  }

  void WriteEvaluations(const std::string& number) {
    const std::string world = "env" + number;
    Add("## Table {}: N_HC in {}, density with segments\n", number, TitleOf(world));
    Add("| N_HC | MFV published | paper | default | OMSE published | paper | default | CMSE published | paper | "
        "default | ATE [m] paper | default |");
    Add("|---|---|---|---|---|---|---|---|---|---|---|---|");
    for (const int evaluations : plan_.evaluations) {
      const Run run{world, "", "segments", evaluations};
      const PaperRow& paper = kPaperByEvaluations.at(world).at(evaluations);
      Add("| {} | {} |{} {} |{} {} |{}{}", evaluations, Printed(paper.mfv, 4), Cells(run, &Outcome::mfv, 4, true),
          Printed(paper.omse_px2, 2), Cells(run, &Outcome::omse_px2, 2), Printed(paper.cmse_px2, 2),
          Cells(run, &Outcome::cmse_px2, 2), Cells(run, &Outcome::ate_mean_m, 3));
    }
    Add("");
  }

  /// N_HC is a limit.
  void WriteEvaluationsUsed() {
    std::string head = "| N_HC |";
    std::string rule = "|---|";
    std::vector<std::string> worlds;
    for (const std::string& world : kMapped) {
      if (!plan_.Has("table" + world.substr(3))) continue;
      worlds.push_back(world);
      head += fmt::format(" env. {} paper | default |", world.substr(3));
      rule += "---|---|";
    }
    if (worlds.empty()) return;
    Add("## Evaluations of the fitness that were used\n");
    Add("In the paper N_HC is a number of iterations, and the paper profile spends them all. To the default profile it "
        "is a limit: the search stops where the first climbs lead to a fitness as good as that of the last scans, and "
        "a final climb comes on top. Mean evaluations a scan:\n");
    Add("{}\n{}", head, rule);
    for (const int evaluations : plan_.evaluations) {
      std::string cells;
      for (const std::string& world : worlds) {
        cells += Cells({world, "", "segments", evaluations}, &Outcome::evaluations, 0);
      }
      Add("| {} |{}", evaluations, cells);
    }
    Add("");
  }

  void WriteMethods(const std::string& title, Figure figure, double PaperRow::*paper) {
    Add("## {} [px2]\n", title);
    Add("| method | env. 1 published | paper | default | env. 2 published | paper | default | env. 3 published | paper "
        "| default |");
    Add("|---|---|---|---|---|---|---|---|---|---|");
    for (const std::string& method : kSelectionMethods) {
      std::string cells;
      for (const std::string& world : kMapped) {
        const Run run{world, "", method, plan_.standard_evaluations};
        cells += fmt::format(" {} |{}", Printed(kPaperByMethod.at(world).at(method).*paper, 2), Cells(run, figure, 2));
      }
      Add("| {} |{}", method, cells);
    }
    Add("");
    Add("Best method of each environment, ours by the worst seed:\n");
    Add("| | env. 1 | env. 2 | env. 3 |\n|---|---|---|---|");
    std::string published;
    for (const std::string& world : kMapped) {
      published +=
          BestOf([&](const std::string& method) { return kPaperByMethod.at(world).at(method).*paper; }) + " | ";
    }
    Add("| published | {}", published);
    for (const std::string& profile : kProfiles) {
      std::string best;
      for (const std::string& world : kMapped) {
        best += BestOf([&](const std::string& method) {
                  return SpreadOf({world, profile, method, plan_.standard_evaluations}, figure).worst;
                }) +
                " | ";
      }
      Add("| {} | {}", profile, best);
    }
    Add("");
  }

  /// The method with the least value; none if no value is finite.
  static std::string BestOf(const std::function<double(const std::string& method)>& value) {
    std::string best = "none: all lost or not run";
    double least = HUGE_VAL;
    for (const std::string& method : kSelectionMethods) {
      if (!(value(method) < least)) continue;
      least = value(method);
      best = method;
    }
    return best;
  }

  void WriteTimes() {
    Add("## Table 6: time and selected rays\n");
    Add("Time of one core for a scan, selection, matching and map update together; mean over the scans. The published "
        "ones are of a Core i7 of 2.8 GHz.\n");
    Add("| environment | method | ms published | paper | default | rays published | paper | default |");
    Add("|---|---|---|---|---|---|---|---|");
    for (const auto& [world, methods] : kPaperTimes) {
      for (const std::string& method : kSelectionMethods) {
        const Run run{world, "", method, plan_.standard_evaluations};
        const PaperTime& paper = methods.at(method);
        Add("| {} | {} | {} |{} {} |{}", world.substr(3), method, Printed(paper.ms, 1), Cells(run, &Outcome::cpu_ms, 1),
            Printed(paper.rays, 1), Cells(run, &Outcome::rays, 1));
      }
    }
    Add("");
  }

  void WriteUpdates() {
    Add("## Fig. 25: adjustments of the map update, environment 2\n");
    Add("| adjustments | OMSE published | paper | default | CMSE published | paper | default |");
    Add("|---|---|---|---|---|---|---|");
    const std::map<std::string, std::string> names = {
        {"both", "sparseness and obstacles"}, {"none", "none"}, {"sparseness", "sparseness only"}};
    for (const std::string& update : kUpdates) {
      const Run run{"env2", "", "segments", plan_.standard_evaluations, update};
      const PaperRow& paper = kPaperByUpdate.at(update);
      Add("| {} | {} |{} {} |{}", names.at(update), Printed(paper.omse_px2, 2), Cells(run, &Outcome::omse_px2, 2),
          Printed(paper.cmse_px2, 2), Cells(run, &Outcome::cmse_px2, 2));
    }
    Add("\nThe maps, {} profile, in the order of the table:\n", "paper");
    ShowMaps("paper");
    Add("and default profile:\n");
    ShowMaps("default");
  }

  void ShowMaps(const std::string& profile) {
    for (const std::string& update : kUpdates) {
      ShowMap({"env2", profile, "segments", plan_.standard_evaluations, update});
    }
    Add("");
  }

  void WriteMaps() {
    Add("## Maps\n\nDensity with segments, N_HC = {}, seed 1.\n", plan_.standard_evaluations);
    for (const std::string& profile : kProfiles) {
      Add("Profile {}:\n", profile);
      for (const std::string world : {"env1", "env2", "env3", "env4"})
        ShowMap({world, profile, "segments", plan_.standard_evaluations});
      Add("");
    }
    DrawErrors();
  }

  void WriteRadish() {
    Add("## Logs of the Radish repository, section 8\n");
    Add("The paper maps two logs and prints the maps alone (Figs. 31 and 32). Ours are of the same recordings: "
        "`intel`, "
        "the Intel Research Lab in Seattle, and `fr079`, building 079 of the University of Freiburg, in CARMEN format "
        "(`FLASER` or `ROBOTLASER1` lines, gzip or not) from the Robotics Data Set Repository, Radish. Their odometry "
        "is "
        "not used. Settings of the laser: `--preset sick`. The error is against the relations that Kuemmerle et al. "
        "(2009) publish with their benchmark (`LOG.relations`, lines of `t1 t2 x y z roll pitch yaw`).\n");
    Add("| log | translation [m], mean, paper | default | deviation, paper | default | rotation [deg], mean, paper | "
        "default | deviation, paper | default |");
    Add("|---|---|---|---|---|---|---|---|---|");
    for (const std::string& log : kRadishLogs) {
      const Run run{log, "", "segments", plan_.standard_evaluations};
      Add("| {} |{}{}{}{}", log, Cells(run, &Outcome::relations_m, 3), Cells(run, &Outcome::relations_std_m, 3),
          Cells(run, &Outcome::relations_deg, 2), Cells(run, &Outcome::relations_std_deg, 2));
    }
    Add("");
    for (const std::string& log : kRadishLogs) {
      Add("{}, paper profile, then default, seed 1:\n", log);
      for (const std::string& profile : kProfiles) ShowMap({log, profile, "segments", plan_.standard_evaluations});
      Add("");
    }
    Add("");
  }

  /// Figs. 21 to 23: a figure over N_HC.
  void DrawCurves(const std::string& name, const std::string& label, bool logarithmic, Figure figure,
                  double PaperRow::*paper) {
    Add("## Fig. {}: {} over N_HC, median\n", name.substr(3), label);
    const std::string settings =
        fmt::format("set logscale x\n{}set xlabel 'N_{{HC}}'\nset ylabel '{}'\nset key {}\nset grid\n",
                    logarithmic ? "set logscale y\n" : "", label, logarithmic ? "top right" : "bottom right");
    Draw(name, label, settings, [&](const std::string& world) {
      std::string data = "$published << END\n";
      for (const int n : plan_.evaluations)
        data += fmt::format("{} {}\n", n, kPaperByEvaluations.at(world).at(n).*paper);
      data += "END\n";
      for (const std::string& profile : kProfiles) {
        data += fmt::format("${}_profile << END\n100 NaN\n", profile);
        for (const int n : plan_.evaluations) {
          const double median = SpreadOf({world, profile, "segments", n}, figure).median;
          if (std::isfinite(median)) data += fmt::format("{} {}\n", n, median);
        }
        data += "END\n";
      }
      return data +
             "plot $published with linespoints lc 'gray40' dt 2 title 'published', "
             "$paper_profile with linespoints lc 'red' title 'paper profile', "
             "$default_profile with linespoints lc 'blue' title 'default profile'";
    });
  }

  /// Fig. 24: when the best pose was found.
  void DrawDistribution() {
    Add("## Fig. 24: the evaluation at which the best pose was found, share of the scans\n");
    const int standard = plan_.standard_evaluations;
    Draw(
        "fig24", "distribution",
        fmt::format(
            "set xrange [0:{}]\nset xlabel 'evaluation'\nset ylabel 'share of the scans'\nset yrange [0:*]\nset grid\n",
            standard),
        [&](const std::string& world) {
          std::string data;
          for (const std::string& profile : kProfiles) {
            data += fmt::format("${}_profile << END\n", profile);
            std::array<double, kNumBins> sums{};
            double all = 1e-9;
            for (int seed = 1; seed <= plan_.num_seeds; ++seed) {
              const auto found = outcomes_.find(NameOf({world, profile, "segments", standard, "both", seed}));
              if (found == outcomes_.end()) continue;
              for (std::size_t i = 0; i < kNumBins; ++i) {
                sums[i] += found->second.bins[i];
                all += found->second.bins[i];
              }
            }
            for (std::size_t i = 0; i < kNumBins; ++i) {
              data += fmt::format("{} {}\n", (static_cast<double>(i) + 0.5) * standard / kNumBins, sums[i] / all);
            }
            data += "END\n";
          }
          return data +
                 "plot $paper_profile with histeps lc 'red' title 'paper profile', "
                 "$default_profile with histeps lc 'blue' title 'default profile'";
        });
  }

  /// How far off the pose is along the path: shows where a map is lost, if it is.
  void DrawErrors() {
    const auto FileOf = [&](const std::string& world, const std::string& profile, const std::string& file) {
      return (out_ / "maps" / NameOf({world, profile, "segments", plan_.standard_evaluations}) / file).string();
    };
    for (const std::string& world : kMapped) {
      for (const std::string& profile : kProfiles) {
        if (!std::filesystem::exists(FileOf(world, profile, "truth.tum"))) return;
      }
    }
    Add("Distance from the true pose along the path, seed 1:\n");
    Draw("errors", "error along the path",
         "set logscale y\nset yrange [0.001:*]\nset xlabel 'time [s]'\nset ylabel 'error [m]'\nset grid\n",
         [&](const std::string& world) {
           std::string plot = "plot ";
           for (const std::string& profile : kProfiles) {
             plot += fmt::format(
                 "\"< paste -d ' ' '{}' '{}'\" using 1:(sqrt(($2-$10)**2+($3-$11)**2)) with lines lc '{}' title '{} "
                 "profile'{}",
                 FileOf(world, profile, "trajectory.tum"), FileOf(world, profile, "truth.tum"),
                 profile == "paper" ? "red" : "blue", profile, profile == "paper" ? ", " : "");
           }
           return plot;
         });
  }
};

}  // namespace

void WriteReport(const Plan& plan, const Outcomes& outcomes, const std::filesystem::path& out) {
  Report(plan, outcomes, out).Write();
}

}  // namespace crsm
