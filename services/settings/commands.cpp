#include "services/settings/commands.hpp"

#include <CLI/CLI.hpp>
#include <cstdlib>

#include "services/base/process.hpp"
#include "services/base/usage_error.hpp"
#include "services/base/version.hpp"
#include "services/settings/help.hpp"

namespace crsm {

using Command = Commands::Command;

Command& Command::AddWord(const std::string& name, std::string& word, const std::string& help) {
  app_.add_option(name, word, help)->required();
  return *this;
}

Command& Command::AddOptionalWord(const std::string& name, std::string& word, const std::string& help) {
  app_.add_option(name, word, help);
  return *this;
}

Command& Command::AddWords(const std::string& name, std::vector<std::string>& words, const std::string& help) {
  app_.add_option(name, words, help)->required();
  return *this;
}

Command& Command::AddOption(const std::string& flag, std::string& value, const std::string& help) {
  app_.add_option(flag, value, help);
  return *this;
}

Command& Command::AddOption(const std::string& flag, double& value, const std::string& help) {
  app_.add_option(flag, value, help)->capture_default_str();
  return *this;
}

Command& Command::AddFlag(const std::string& flag, bool& given, const std::string& help) {
  app_.add_flag(flag, given, help);
  return *this;
}

Commands::Commands(const std::string& program, const std::string& description)
    : program_(program), app_(std::make_unique<CLI::App>(description, program)) {
  app_->formatter(MakeHelpFormatter());
  app_->set_help_flag("-h,--help", "show this help and exit");
  app_->set_version_flag("--version", program + " " + kVersion, "show the version and exit");
  app_->require_subcommand(1);
}

Commands::~Commands() = default;

Command Commands::Add(const std::string& name, const std::string& description, const std::function<void()>& run) {
  CLI::App* command = app_->add_subcommand(name, description);
  command->callback(run);
  return Command(*command);
}

int Commands::Run(int argc, const char* const* argv) {
  return ReportErrors(program_, [&] {
    try {
      app_->parse(argc, argv);
      return EXIT_SUCCESS;
    } catch (const CLI::ParseError& error) {
      if (error.get_exit_code() == 0) return app_->exit(error);  // --help and --version
      throw UsageError(DescribeParseError(*app_, error));
    }
  });
}

}  // namespace crsm
