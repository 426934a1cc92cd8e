#include "services/settings/command_line.hpp"

#include <fmt/core.h>
#include <fmt/format.h>
#include <toml++/toml.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <type_traits>

#include "common/logs/regular_file.hpp"
#include "common/math/nearest_name.hpp"
#include "common/set_parameter.hpp"
#include "services/base/process.hpp"
#include "services/base/usage_error.hpp"
#include "services/base/version.hpp"
#include "services/settings/help.hpp"
#include "services/settings/presets.hpp"

namespace crsm {
namespace {

void SetValue(const std::string& key, const WrittenValue& value, Parameters& parameters, Settings& settings) {
  ValueSetter setter(key, value);
  VisitParameters(parameters, setter);
  VisitSettings(settings, setter);
  if (setter.found()) return;
  std::vector<std::string> keys = setter.keys();
  keys.insert(keys.end(), {"preset", "profile"});
  throw std::runtime_error(
      fmt::format("{}: no such key; --help of each program lists them{}", key, SuggestName(key, keys)));
}

WrittenValue ToWrittenValue(const toml::node& node) {
  using Kind = WrittenValue::Kind;
  if (const auto* string = node.as_string()) return {Kind::kString, string->get()};
  if (const auto* integer = node.as_integer()) return {Kind::kNumber, fmt::format("{}", integer->get())};
  if (const auto* number = node.as_floating_point()) return {Kind::kNumber, fmt::format("{}", number->get())};
  if (const auto* boolean = node.as_boolean()) return {Kind::kBoolean, boolean->get() ? "true" : "false"};
  return {Kind::kOther, "(a table or a list)"};
}

/// How a setting stands in --help.
struct SettingHelp {
  const char* heading = kProcessHeading;
  const char* type = "TEXT";
};

SettingHelp HelpOf(const std::string& setting) {
  static const std::map<std::string, SettingHelp> kHelps{{"out", {kOptionsHeading, "DIR"}},
                                                         {"rate", {kOptionsHeading, "N|max"}},
                                                         {"odometry", {kOptionsHeading}},
                                                         {"localize", {kEarlierRunsHeading, "DIR"}},
                                                         {"start", {kEarlierRunsHeading, "X,Y,YAW"}},
                                                         {"resume", {kEarlierRunsHeading}},
                                                         {"new_session", {kEarlierRunsHeading}},
                                                         {"until_damage", {kEarlierRunsHeading}},
                                                         {"laser_channel", {kLaserHeading, "NAME"}},
                                                         {"laser_frame", {kLaserHeading, "NAME"}},
                                                         {"odometry_topic", {kLaserHeading, "NAME"}},
                                                         {"botlab_clockwise", {kLaserHeading}},
                                                         {"mirrored", {kLaserHeading}},
                                                         {"lcm_url", {kProcessHeading, "URL"}},
                                                         {"http", {kProcessHeading, "ADDRESS:PORT"}},
                                                         {"team", {kOptionsHeading, "NAME"}},
                                                         {"journal", {kProcessHeading, "DIR"}},
                                                         {"position", {kProcessHeading, "FILE"}}};
  const auto found = kHelps.find(setting);
  return found == kHelps.end() ? SettingHelp() : found->second;
}

const char* HeadingOf(ParameterGroup group) {
  return group == ParameterGroup::kScan || group == ParameterGroup::kLaser ? kLaserHeading : kMapHeading;
}

template <std::size_t N>
std::vector<std::string> Names(const BuiltInConfig (&configs)[N]) {
  std::vector<std::string> names;
  for (const BuiltInConfig& config : configs) names.emplace_back(config.name);
  return names;
}

/// The name of a built-in configuration, and who says it: a flag or a line of a file.
struct BuiltInChoice {
  std::string name;
  std::string said_by;
};

template <std::size_t N>
std::string FindBuiltIn(const BuiltInConfig (&configs)[N], const BuiltInChoice& choice) {
  for (const BuiltInConfig& config : configs) {
    if (config.name == choice.name) return std::string(config.toml);
  }
  throw std::runtime_error(fmt::format("{}: '{}' is not one of {}{}", choice.said_by, choice.name,
                                       fmt::join(Names(configs), ", "), SuggestName(choice.name, Names(configs))));
}

/// A key of very many parts is more than the parser's stack.
void CheckLines(const std::string& text, const std::string& path) {
  constexpr std::size_t kLongest = 10'000;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (line.size() > kLongest)
      throw std::runtime_error(fmt::format("{}:{}: is longer than {} characters", path, number, kLongest));
  }
}

std::string ReadConfig(const std::string& path) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 20;
  const std::string text = ReadWholeFile(path, kMostBytes);
  if (text.empty()) throw std::runtime_error(fmt::format("{}: is empty", path));
  CheckLines(text, path);
  return text;
}

toml::table ParseToml(const std::string& text, const std::string& name) {
  try {
    return toml::parse(text, name);
  } catch (const toml::parse_error& error) {
    throw std::runtime_error(fmt::format("{}:{}: {}", name, error.source().begin.line, error.description()));
  }
}

/// The built-in configuration that a flag names, or else a key of the configuration file.
BuiltInChoice Choose(const std::string& key, const std::string& flag, const std::string& config,
                     const toml::table& file) {
  const toml::node* node = file.get(key);
  if (!flag.empty() || !node) return {flag, "--" + key};
  const std::string said_by = fmt::format("{}:{}: {}", config, node->source().begin.line, key);
  if (!node->is_string()) throw std::runtime_error(said_by + ": must be a name in quotes");
  return {node->as_string()->get(), said_by};
}

void Describe(CLI::Option& option, const FlagHelp& help) {
  option.group(help.heading)->type_name(help.type);
  if (!help.one_of.empty()) TakeOneOf(option, help.one_of);
}

NamedValues ListSettings(const Settings& settings) {
  Settings copy = settings;
  NamedValues list;
  VisitSettings(copy, [&]<class T>(const char* key, const char*, T& value, auto...) {
    if constexpr (std::is_same_v<T, int>) {
      list.emplace_back(key, std::int64_t{value});
    } else {
      list.emplace_back(key, value);
    }
  });
  return list;
}

}  // namespace

namespace {

/// "intel.clf.gz" of a file, "sim:my.world" of a world that is one, and what has no file as it is.
std::string NameOfSource(const std::string& source) {
  constexpr std::string_view kWorld = "sim:";
  const std::size_t scheme = source.starts_with(kWorld) ? kWorld.size() : 0;
  const std::filesystem::path path = source.substr(scheme);
  std::error_code error;
  return std::filesystem::exists(path, error) ? source.substr(0, scheme) + path.filename().string() : source;
}

/// "map" of "out/map/".
std::string NameOfFolder(const std::string& folder) {
  const std::filesystem::path path = std::filesystem::path(folder).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

bool HasKey(const std::vector<std::pair<std::string, std::string>>& flags, const std::string& key) {
  return std::ranges::any_of(flags, [&](const auto& flag) { return flag.first == key; });
}

/// Whether what the user set by a flag changes the map or the poses, and not only how the program runs.
bool MattersForMap(const std::string& key) {
  static const std::set<std::string> kSettings{"laser_channel",    "laser_frame", "odometry", "odometry_topic",
                                               "botlab_clockwise", "mirrored",    "localize", "start"};
  if (kSettings.contains(key)) return true;
  return std::ranges::any_of(ListParameters(Parameters()), [&](const auto& value) { return value.first == key; });
}

std::string Quote(const std::string& word) {
  return word.find_first_of(" \t'\"") == std::string::npos ? word : "\"" + word + "\"";
}

}  // namespace

std::string CommandLine::DescribeRun(const std::vector<std::string>& sources) const {
  std::vector<std::string> words;
  for (const std::string& source : sources) words.push_back(NameOfSource(source));
  const auto AddNamed = [&](const char* flag, const std::string& value) {
    if (!value.empty()) words.insert(words.end(), {flag, value});
  };
  AddNamed("--preset", preset_);
  AddNamed("--profile", profile_);
  AddNamed("--config", std::filesystem::path(config_).filename().string());
  for (const auto& [key, text] : typed_) {
    if (!MattersForMap(key)) continue;
    const std::string flag = FlagOf(key);
    if (text == "true") {
      words.push_back(flag);
    } else if (text == "false") {
      words.push_back("--no" + flag.substr(1));
    } else {
      words.insert(words.end(), {flag, key == "localize" ? NameOfFolder(text) : text});
    }
  }
  std::ranges::transform(words, words.begin(), Quote);
  return fmt::format("{}", fmt::join(words, " "));
}

LaserMessageOptions LaserMessagesOf(const CommandLine& command_line) {
  return {command_line.parameters().scan, command_line.settings().botlab_clockwise, command_line.settings().mirrored};
}

std::string FlagOf(std::string key) {
  std::replace(key.begin(), key.end(), '_', '-');
  return "--" + key;
}

CommandLine::CommandLine(const std::string& program, const std::string& description, std::vector<ParameterGroup> groups,
                         std::vector<std::string> settings)
    : CommandLine(program, description, ProgramFlags{std::move(groups), std::move(settings)}) {}

CommandLine::CommandLine(const std::string& program, const std::string& description, const ProgramFlags& flags)
    : program_(program),
      groups_(flags.groups),
      setting_names_(flags.settings),
      app_(std::make_unique<CLI::App>(description, program)),
      settings_(flags.defaults) {
  PrepareProcess();
  app_->formatter(MakeHelpFormatter());
  app_->set_help_flag("-h,--help", "show this help and exit")->group(kHelpHeading);
  app_->set_version_flag("--version", fmt::format("{} {}", program, kVersion), "show the version and exit")
      ->group(kHelpHeading);
  app_->add_option("--preset", preset_, fmt::format("laser: {}", fmt::join(Names(kPresets), ", ")))->type_name("NAME");
  app_->add_option("--config", config_, "TOML file; its keys are the flags, with _ for -; one file serves all programs")
      ->type_name("FILE")
      ->group(kHelpHeading);
  app_->add_option("--profile", profile_, fmt::format("algorithm: {}", fmt::join(Names(kProfiles), ", ")))
      ->type_name("NAME")
      ->group(kMapHeading);
  AddFlags();
}

CommandLine::~CommandLine() = default;

void CommandLine::AddWord(const std::string& name, std::string& word, const std::string& help) {
  app_->add_option(name, word, help)->required();
}

void CommandLine::AddWord(const std::string& name, std::vector<std::string>& words, const std::string& help) {
  app_->add_option(name, words, help)->required();
}

void CommandLine::AddOptionalWords(const std::string& name, std::vector<std::string>& words, const std::string& help) {
  app_->add_option(name, words, help);
}

void CommandLine::AddOption(const std::string& flag, std::string& value, const std::string& help,
                            const FlagHelp& flag_help) {
  Describe(*app_->add_option(flag, value, help), flag_help);
}

void CommandLine::AddOption(const std::string& flag, std::vector<std::string>& values, const std::string& help,
                            const FlagHelp& flag_help) {
  Describe(*app_->add_option(flag, values, help), flag_help);
}

void CommandLine::AddFlag(const std::string& flag, bool& given, const std::string& help, const char* heading) {
  app_->add_flag(flag, given, help)->group(heading);
}

void CommandLine::AddFooter(const std::string& text) { app_->footer(text); }

template <class Key>
bool CommandLine::Uses(const Key& key) const {
  if constexpr (std::is_same_v<Key, ParameterGroup>) {
    return std::find(groups_.begin(), groups_.end(), key) != groups_.end();
  } else {
    return std::find(setting_names_.begin(), setting_names_.end(), key) != setting_names_.end();
  }
}

void CommandLine::AddFlags() {
  SettingHelp help_of;
  const auto AddOption = [&](const std::string& key, const std::string& help, const std::string& type) {
    app_->add_option_function<std::string>(
            FlagOf(key), [this, key](const std::string& text) { flags_.emplace_back(key, text); }, help)
        ->type_name(type)
        ->group(help_of.heading);
  };
  const auto AddFlag = [&](const std::string& key, const std::string& help) {
    const std::string flag = FlagOf(key);
    app_->add_flag_function(
            flag + ",!--no-" + flag.substr(2),
            [this, key](std::int64_t count) { flags_.emplace_back(key, count > 0 ? "true" : "false"); }, help)
        ->group(help_of.heading);
  };
  const auto Add = [&]<class T, class... Rest>(const std::string& key, const std::string& help, const T& value,
                                               const Rest&... rest) {
    if constexpr (std::is_same_v<T, bool>) {
      AddFlag(key, fmt::format("{} [{}]", help, value));
    } else if constexpr (std::is_same_v<T, std::string>) {
      AddOption(key, value.empty() ? help : fmt::format("{} [{}]", help, value), help_of.type);
    } else if constexpr (std::is_enum_v<T>) {
      const auto& names = std::get<0>(std::tie(rest...));
      AddOption(key, fmt::format("{} [{}]", help, names.at(static_cast<std::size_t>(value))),
                fmt::format("{}", fmt::join(names, "|")));
    } else {
      AddOption(key, fmt::format("{} [{}]", help, value), std::is_integral_v<T> ? "INT" : "NUMBER");
    }
  };
  VisitSettings(settings_, [&](const char* key, const char* help, auto& value, auto... range) {
    help_of = HelpOf(key);
    if (Uses(std::string(key))) Add(key, help, value, range...);
  });
  VisitParameters(parameters_, [&](const ParameterInfo& info, auto& value, const auto&... range) {
    help_of = {HeadingOf(info.group)};
    if (Uses(info.group)) Add(info.key, info.help, value, range...);
  });
}

NamedValues CommandLine::UsedValues() const {
  NamedValues used;
  for (auto& value : ListParameters(parameters_, groups_)) used.push_back(std::move(value));
  for (auto& value : ListSettings(settings_)) {
    if (Uses(value.first)) used.push_back(std::move(value));
  }
  return used;
}

ParameterValue ReadValue(const std::string& key, const std::string& text) {
  Parameters parameters;
  Settings settings;
  try {
    SetValue(key, {WrittenValue::Kind::kFlag, text}, parameters, settings);
  } catch (const std::runtime_error&) {
    return text;
  }
  for (const NamedValues& values : {ListParameters(parameters), ListSettings(settings)}) {
    for (const auto& [name, value] : values) {
      if (name == key) return value;
    }
  }
  return text;
}

std::optional<int> CommandLine::Parse(int argc, const char* const* argv) {
  try {
    app_->parse(argc, argv);
    ApplyConfigs();
    typed_ = flags_;
    for (const auto& [key, text] : flags_) {
      try {
        SetValue(key, {WrittenValue::Kind::kFlag, text}, parameters_, settings_);
        said_by_[key] = fmt::format("{} {}", FlagOf(key), text);
      } catch (const std::runtime_error& error) {
        throw std::runtime_error(FlagOf(key) + std::string(error.what()).substr(key.size()));
      }
    }
    if (WasGiven("odometry_topic") && !settings_.odometry) {
      throw UsageError(fmt::format("--odometry-topic: names odometry that {} turns off: remove one of them",
                                   WasGiven("odometry") ? "--no-odometry" : WhoSaid("odometry")));
    }
    if (WasGiven("sweep_s")) SetUnlessSaid("beam_times", "false");  // who types it knows better than the messages
    ParseRate(settings_.rate);
    CheckPrefix(settings_.channel_prefix);
    parameters_.match.start = ParseStart(settings_.start);
    CheckConsistency(parameters_);
    return std::nullopt;
  } catch (const CLI::Success& wanted) {  // --help, --version
    return app_->exit(wanted);
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "{}: {}\n", program_, DescribeParseError(*app_, error));
  } catch (const std::runtime_error& error) {
    fmt::print(stderr, "{}: {}\n", program_, error.what());
  }
  return 2;
}

/// The preset, the profile and the configuration file, which may name the two.
void CommandLine::ApplyConfigs() {
  const std::string text = config_.empty() ? "" : ReadConfig(config_);
  const toml::table file = ParseToml(text, config_);
  const BuiltInChoice preset = Choose("preset", preset_, config_, file);
  const BuiltInChoice profile = Choose("profile", profile_, config_, file);
  preset_name_ = preset.name;
  if (!preset.name.empty()) Apply(FindBuiltIn(kPresets, preset), preset.name);
  if (!profile.name.empty()) Apply(FindBuiltIn(kProfiles, profile), profile.name);
  Apply(text, config_);
}

void CommandLine::Apply(const std::string& text, const std::string& name) {
  for (const auto& [key, node] : ParseToml(text, name)) {
    if (key == "preset" || key == "profile") continue;
    try {
      SetValue(std::string(std::string_view(key)), ToWrittenValue(node), parameters_, settings_);
      said_by_[std::string(std::string_view(key))] = fmt::format("{}:{}: {} = {}", name, node.source().begin.line,
                                                                 std::string_view(key), ToWrittenValue(node).text);
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(fmt::format("{}:{}: {}", name, node.source().begin.line, error.what()));
    }
  }
}

/// What a preset says of the sweep the scans of a log may contradict, and the map was made with what they say.
bool CommandLine::IsStudied(const std::string& key, const std::string& said_by) const {
  return (key == "sweep_s" || key == "beam_times") && said_by.starts_with(preset_name_ + ":");
}

void CommandLine::Adopt(const std::vector<std::pair<std::string, std::string>>& of_map, const std::string& map_name) {
  for (const auto& [key, text] : of_map) {
    Parameters adopted = parameters_;
    try {
      SetValue(key, {WrittenValue::Kind::kFlag, text}, adopted, settings_);
    } catch (const std::runtime_error& error) {  // of another version of the programs
      throw UsageError(fmt::format("the map of {} was made with {} = {}: {}", map_name, key, text, error.what()));
    }
    const auto said_by = said_by_.find(key);
    if (said_by != said_by_.end() && !IsStudied(key, said_by->second) &&
        ListParameters(adopted) != ListParameters(parameters_)) {
      throw UsageError(fmt::format("{}: the map of {} was made with {}; remove this setting, or set {} {}",
                                   said_by->second, map_name, text, FlagOf(key), text));
    }
    parameters_ = adopted;
    std::erase_if(flags_, [&key = key](const auto& flag) { return flag.first == key; });
    flags_.emplace_back(key, text);  // for the programs that are told the same
  }
}

void CommandLine::SetUnlessSaid(const std::string& key, const std::string& text) {
  if (said_by_.count(key) == 0) Correct(key, text);
}

void CommandLine::Correct(const std::string& key, const std::string& text) {
  if (WasGiven(key)) return;
  SetValue(key, {WrittenValue::Kind::kFlag, text}, parameters_, settings_);
  flags_.emplace_back(key, text);
}

std::string CommandLine::WhoSaid(const std::string& key) const {
  const auto said_by = said_by_.find(key);
  if (said_by != said_by_.end()) return said_by->second;
  for (const auto& [name, value] : UsedValues()) {
    if (name == key) return fmt::format("{} = {}", key, FormatValue(value));
  }
  return key;
}

bool CommandLine::Has(const std::string& key) const { return app_->get_option_no_throw(FlagOf(key)) != nullptr; }

bool CommandLine::WasGiven(const std::string& key) const { return HasKey(flags_, key); }

bool CommandLine::WasTyped(const std::string& key) const { return HasKey(typed_, key); }

std::vector<std::string> CommandLine::WordsFor(const ProgramFlags& program) const {
  std::vector<std::string> words;
  for (const auto& [flag, value] :
       std::map<std::string, std::string>{{"--config", config_}, {"--preset", preset_}, {"--profile", profile_}}) {
    if (!value.empty()) words.insert(words.end(), {flag, value});
  }
  std::vector<std::string> keys = program.settings;
  Parameters any;
  VisitParameters(any, [&](const ParameterInfo& info, const auto&...) {
    if (std::count(program.groups.begin(), program.groups.end(), info.group) > 0) keys.emplace_back(info.key);
  });
  for (const auto& [key, text] : flags_) {
    if (std::count(keys.begin(), keys.end(), key) == 0) continue;
    const bool is_switch = app_->get_option(FlagOf(key))->get_expected_max() == 0;
    words.push_back(is_switch && text == "false" ? "--no-" + FlagOf(key).substr(2) : FlagOf(key));
    if (!is_switch) words.push_back(text);
  }
  return words;
}

}  // namespace crsm
