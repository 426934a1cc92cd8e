#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <functional>
#include <string>

#include "tests/experiments/outcome.hpp"
#include "tests/experiments/plan.hpp"

namespace crsm {

using Figure = double Outcome::*;

/// A figure over the seeds of a run; NaN if there is none.
struct Spread {
  double median = NAN;
  double worst = NAN;
};

/// "environment 1" of "env1".
std::string TitleOf(const std::string& world);

/// "not run", "lost" or the number.
std::string Show(double value, int decimals);

/// results.md while it is written, and what its tables and figures are made of.
class Page {
 public:
  Page(const Plan& plan, const Outcomes& outcomes, const std::filesystem::path& out)
      : plan_(plan), outcomes_(outcomes), out_(out) {}

  const Plan& plan() const { return plan_; }
  const Outcomes& outcomes() const { return outcomes_; }

  /// A line of the page.
  template <class... Arguments>
  void Add(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    text_ += fmt::format(format, std::forward<Arguments>(arguments)...) + "\n";
  }

  Spread SpreadOf(Run run, Figure figure, bool low_is_bad = false) const;

  /// "median (worst)" for each profile, as cells of a table.
  std::string Cells(Run run, Figure figure, int decimals, bool low_is_bad = false) const;

  void ShowMap(const Run& run);

  /// Three plots side by side, one an environment. `curves` gives what gnuplot plots in each.
  void Draw(const std::string& name, const std::string& caption, const std::string& settings,
            const std::function<std::string(const std::string& world)>& curves);

  /// Writes results.md.
  void Save() const;

 protected:
  const Plan& plan_;
  const Outcomes& outcomes_;
  std::filesystem::path out_;
  std::string text_;
};

}  // namespace crsm
