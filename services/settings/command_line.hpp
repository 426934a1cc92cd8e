#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/parameters.hpp"
#include "services/settings/help.hpp"
#include "services/settings/programs.hpp"
#include "services/settings/settings.hpp"
#include "services/wire/laser_types.hpp"

namespace CLI {
class App;  // its header takes three seconds to compile
}

namespace crsm {

/// How a flag of one program stands in --help, and what it takes.
struct FlagHelp {
  const char* heading = kOptionsHeading;
  const char* type = "TEXT";
  std::vector<std::string> one_of = {};  ///< the names that it takes; any text if there are none
};

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
  ~CommandLine();

  // What the program takes besides, before Parse: words of which there must be one, words of which there may be some,
  // flags with a value (a list may be given more than once), flags without, and what --help says at its end.
  void AddWord(const std::string& name, std::string& word, const std::string& help);
  void AddWord(const std::string& name, std::vector<std::string>& words, const std::string& help);
  void AddOptionalWords(const std::string& name, std::vector<std::string>& words, const std::string& help);
  void AddOption(const std::string& flag, std::string& value, const std::string& help, const FlagHelp& flag_help = {});
  void AddOption(const std::string& flag, std::vector<std::string>& values, const std::string& help,
                 const FlagHelp& flag_help = {});
  void AddFlag(const std::string& flag, bool& given, const std::string& help, const char* heading = kOptionsHeading);
  void AddFooter(const std::string& text);

  /// The exit code where the program is to stop here: help was asked for, or something is wrong and was said.
  std::optional<int> Parse(int argc, const char* const* argv);

  /// Takes over parameters of a map that was made before, by their keys, each as a flag says it. Throws UsageError, one
  /// line, if a flag, a preset, a profile or a configuration file says something else: names which, and the map by
  /// `map_name`.
  void Adopt(const std::vector<std::pair<std::string, std::string>>& of_map, const std::string& map_name);

  /// Gives a parameter a value that a flag would say, unless a flag, a preset, a profile, a configuration file or a map
  /// has given it one.
  void SetUnlessSaid(const std::string& key, const std::string& text);

  /// The same unless a flag has given it one.
  void Correct(const std::string& key, const std::string& text);

  /// Who gave a parameter its value, as "--range-max-m 40"; by default "range_max_m = 30".
  std::string WhoSaid(const std::string& key) const;

  /// Whether a parameter or setting has the value of a flag, of this command line or as Correct and Adopt gave it.
  bool WasGiven(const std::string& key) const;

  /// Whether the user gave it by a flag.
  bool WasTyped(const std::string& key) const;

  /// Those of this command line's words that another program is to get too: --preset, --profile and --config, and its
  /// flags.
  std::vector<std::string> WordsFor(const ProgramFlags& program) const;

  /// For people: `sources` by their names alone, and the flags that the map or the poses depend on, in the
  /// order of --help.
  std::string DescribeRun(const std::vector<std::string>& sources) const;

  const std::string& program() const { return program_; }
  const Parameters& parameters() const { return parameters_; }
  const Settings& settings() const { return settings_; }
  /// From here on the laser is that of one channel, of several that --laser-channel names.
  void ChooseLaserChannel(const std::string& channel) { settings_.laser_channel = channel; }

  /// The values of all parameters and settings that the program uses, by key.
  NamedValues UsedValues() const;

 private:
  void AddFlags();
  template <class Key>
  bool Uses(const Key& key) const;
  void ApplyConfigs();
  void Apply(const std::string& toml, const std::string& name);
  bool Has(const std::string& key) const;
  bool IsStudied(const std::string& key, const std::string& said_by) const;

  std::string program_;
  std::vector<ParameterGroup> groups_;      ///< that the program uses
  std::vector<std::string> setting_names_;  ///< that the program uses
  std::unique_ptr<CLI::App> app_;
  std::string preset_;
  std::string preset_name_;  ///< the same, where the configuration file names it, too
  std::string profile_;
  std::string config_;
  std::vector<std::pair<std::string, std::string>> flags_;  ///< key and text, in the order given
  std::vector<std::pair<std::string, std::string>> typed_;  ///< of these, what the user gave
  std::map<std::string, std::string> said_by_;              ///< who gave a key its value, as "--range-max-m 40"
  Parameters parameters_;
  Settings settings_;
};

/// How a laser's messages are read.
LaserMessageOptions LaserMessagesOf(const CommandLine& command_line);

/// What a flag says. A text that is not one of `key`, or of a key that this program does not know, stays a text.
ParameterValue ReadValue(const std::string& key, const std::string& text);

/// The flag of a parameter or setting: "--range-max-m" of "range_max_m".
std::string FlagOf(std::string key);

}  // namespace crsm
