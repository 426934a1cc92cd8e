#pragma once

#include <memory>
#include <string>
#include <vector>

namespace CLI {
class App;
class FormatterBase;
class Option;
class ParseError;
}  // namespace CLI

namespace crsm {

// The headings of --help, in their order. A flag for which nobody says another one stands below the first.
inline constexpr const char* kOptionsHeading = "Options";
inline constexpr const char* kEarlierRunsHeading = "Earlier runs";
inline constexpr const char* kLaserHeading = "Laser and odometry";
inline constexpr const char* kMapHeading = "Matching and map";
inline constexpr const char* kProcessHeading = "Processes and bus";
inline constexpr const char* kHelpHeading = "Help and configuration";

/// How --help looks: lines of at most 100 characters, and one empty line between headings.
std::shared_ptr<CLI::FormatterBase> MakeHelpFormatter();

/// Lets an option take these names alone. --help shows them, and an error suggests the nearest one.
void TakeOneOf(CLI::Option& option, const std::vector<std::string>& names);

/// One line: what is wrong with a command line, and the flag or subcommand that was probably meant.
std::string DescribeParseError(const CLI::App& app, const CLI::ParseError& error);

}  // namespace crsm
