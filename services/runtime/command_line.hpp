#pragma once

#include <CLI/CLI.hpp>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "common/parameters.hpp"
#include "services/runtime/programs.hpp"
#include "services/runtime/settings.hpp"

namespace crsm {

/// The command line that all programs share: --help, --version, --preset, --profile, --config FILE, and a flag for each
/// parameter and setting that the program uses.
///
/// Later wins: defaults, preset, profile, configuration file, flags. A configuration file serves all programs: keys of
/// others are checked and kept; a key that none knows, a value out of range, or flags that contradict each other stop
/// the program in one line. It may name `preset` and `profile` where the flags do not.
class CommandLine {
 public:
  /// groups: of the parameters, settings: names of the settings that become flags.
  CommandLine(const std::string& program, const std::string& description, std::vector<ParameterGroup> groups,
              std::vector<std::string> settings);
  CommandLine(const std::string& program, const std::string& description, const ProgramFlags& flags);

  /// For positional arguments and options of the program's own.
  CLI::App& app() { return app_; }

  /// The exit code where the program is to stop here: help was asked for, or something is wrong and was said.
  std::optional<int> Parse(int argc, const char* const* argv);

  /// Whether a parameter or setting was a flag on this command line.
  bool WasGiven(const std::string& key) const;

  /// Those of this command line's words that another program is to get too: --preset, --profile and --config, and its
  /// flags.
  std::vector<std::string> WordsFor(const ProgramFlags& program) const;

  const std::string& program() const { return program_; }
  const Parameters& parameters() const { return parameters_; }
  const Settings& settings() const { return settings_; }

 private:
  void AddFlags(const std::vector<ParameterGroup>& groups, const std::vector<std::string>& settings);
  void ApplyConfigs();
  void Apply(const std::string& toml, const std::string& name);
  bool Has(const std::string& key) const;

  std::string program_;
  CLI::App app_;
  std::string preset_;
  std::string profile_;
  std::string config_;
  std::vector<std::pair<std::string, std::string>> flags_;  ///< key and text, in the order given
  Parameters parameters_;
  Settings settings_;
};

}  // namespace crsm
