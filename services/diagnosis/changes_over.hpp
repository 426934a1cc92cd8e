#pragma once

#include <string>

#include "services/settings/command_line.hpp"

namespace crsm {

/// The flag --changes-over AREA_M2 of programs that localise: their exit code is kChangedExitCode where something as
/// large has come or gone.
class ChangesOver {
 public:
  void AddFlag(CommandLine& command_line);

  /// Throws UsageError if it is no area, or if there is no finished map.
  void Check(const Settings& settings) const;

  bool was_given() const { return !text_.empty(); }
  /// largest_m2: the largest thing that has changed, 0 if nothing has. False without the flag.
  bool IsExceededBy(double largest_m2) const;

 private:
  std::string text_;
};

}  // namespace crsm
