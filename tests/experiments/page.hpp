#pragma once

#include <fmt/format.h>

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

/// results.md while it is written, and what its tables are made of.
class Page {
 public:
  Page(const Plan& plan, const Outcomes& outcomes) : plan_(plan), outcomes_(outcomes) {}

  const Plan& plan() const { return plan_; }

  /// A line of the page.
  template <class... Arguments>
  void Add(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    text_ += fmt::format(format, std::forward<Arguments>(arguments)...) + "\n";
  }

  Spread SpreadOf(Run run, Figure figure) const;

  /// "median (worst)" for each profile, as cells of a table.
  std::string Cells(Run run, Figure figure, int decimals) const;

  const std::string& text() const { return text_; }

 private:
  const Plan& plan_;
  const Outcomes& outcomes_;
  std::string text_;
};

}  // namespace crsm
