#include "services/settings/help.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iterator>
#include <sstream>
#include <string_view>

#include "common/math/nearest_name.hpp"

namespace crsm {
namespace {

constexpr std::size_t kColumns = 100;
constexpr std::size_t kTextColumn = 30;

/// Text whose first line begins at the column of the others; with the end of its last line. Lines end where the text
/// has a line break, and before kColumns.
std::string Wrap(const std::string& text, std::size_t column) {
  const std::string new_line = '\n' + std::string(column, ' ');
  std::string wrapped;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (!wrapped.empty()) wrapped += new_line;
    std::size_t at = column;
    std::istringstream words(line);
    for (std::string word; words >> word; at += word.size()) {
      if (at > column && at + 1 + word.size() > kColumns) {
        wrapped += new_line;
        at = column;
      } else if (at > column) {
        wrapped += ' ';
        ++at;
      }
      wrapped += word;
    }
  }
  return wrapped + '\n';
}

/// A name, and what it means beside it or, after a long name, below it.
std::string Entry(const std::string& name, const std::string& text) {
  std::string entry = "  " + name;
  const bool is_beside = entry.size() + 2 <= kTextColumn;  // help2man needs two spaces
  if (!is_beside) entry += '\n';
  return entry + std::string(is_beside ? kTextColumn - entry.size() : kTextColumn, ' ') + Wrap(text, kTextColumn);
}

class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    const std::string footer = make_footer(app);
    return make_description(app) + '\n' + make_usage(app, name) + make_positionals(app) + MakeGroups(*app) +
           make_subcommands(app, mode) + (footer.empty() ? "" : '\n' + footer);
  }
  std::string make_description(const CLI::App* app) const override { return Wrap(app->get_description(), 0); }
  std::string make_footer(const CLI::App* app) const override {
    return app->get_footer().empty() ? "" : Wrap(app->get_footer(), 0);
  }
  std::string make_subcommand(const CLI::App* command) const override {
    return Entry(command->get_name(), command->get_description());
  }
  std::string make_option(const CLI::Option* option, bool is_positional) const override {
    std::string name = is_positional ? make_option_usage(option) : make_option_name(option, false);
    if (!is_positional && !option->get_type_name().empty()) name += ' ' + option->get_type_name();
    if (!is_positional && option->get_expected_max() == CLI::detail::expected_max_vector_size) name += " ...";
    return Entry(name, option->get_description());
  }
  /// "-h, --help", "--odometry, --no-odometry".
  std::string make_option_name(const CLI::Option* option, bool is_positional) const override {
    if (is_positional) return CLI::Formatter::make_option_name(option, true);
    std::vector<std::string> names;
    for (const std::string& name : option->get_snames()) names.push_back('-' + name);
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    return fmt::format("{}", fmt::join(names, ", "));
  }

 private:
  std::string MakeGroups(const CLI::App& app) const {
    std::string groups;
    for (const char* heading :
         {kOptionsHeading, kEarlierRunsHeading, kLaserHeading, kMapHeading, kProcessHeading, kHelpHeading}) {
      const auto options = app.get_options(
          [&](const CLI::Option* option) { return option->get_group() == heading && option->nonpositional(); });
      if (!options.empty()) groups += make_group(heading, false, options);
    }
    return groups;
  }
};

/// What could stand on this command line in place of something that is unknown.
std::vector<std::string> ListKnownWords(const CLI::App& app) {
  std::vector<std::string> words;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) words.push_back("--" + name);
  }
  for (const CLI::App* command : app.get_subcommands({})) words.push_back(command->get_name());
  for (const CLI::App* command : app.get_subcommands()) {  // those that are on the command line
    std::ranges::move(ListKnownWords(*command), std::back_inserter(words));
  }
  return words;
}

}  // namespace

std::shared_ptr<CLI::FormatterBase> MakeHelpFormatter() {
  auto formatter = std::make_shared<HelpFormatter>();
  formatter->label("Positionals", "Arguments");
  return formatter;
}

void TakeOneOf(CLI::Option& option, const std::vector<std::string>& names) {
  option.type_name(fmt::format("{}", fmt::join(names, "|")));
  option.check([names](const std::string& text) {
    if (std::count(names.begin(), names.end(), text) > 0) return std::string();
    return fmt::format("'{}' is not one of {}{}", text, fmt::join(names, ", "), SuggestName(text, names));
  });
}

std::string DescribeParseError(const CLI::App& app, const CLI::ParseError& error) {
  std::string description = error.what();
  constexpr std::string_view kMissing = ": 1 required ";  // "--out: 1 required DIR missing"
  const auto missing = description.find(kMissing);
  if (missing != std::string::npos && description.ends_with(" missing")) {
    description.replace(missing, kMissing.size(), ": ");
    description.insert(description.size() - 7, "is ");
  }
  const std::vector<std::string> known = ListKnownWords(app);
  for (const std::string& word : app.remaining(true)) {
    if (word.starts_with('-') || !app.get_subcommands({}).empty()) {
      description += SuggestName(word.substr(0, word.find('=')), known);
    }
  }
  return description + (description.ends_with('?') ? " --help lists the flags" : "; --help lists the flags");
}

}  // namespace crsm
