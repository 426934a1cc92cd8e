#include <CLI/CLI.hpp>
#include <cstdlib>
#include <string>

#include "services/base/process.hpp"
#include "services/base/usage_error.hpp"
#include "services/base/version.hpp"
#include "services/settings/help.hpp"
#include "services/slam_eval/commands.hpp"

int main(int argc, char** argv) {
  CLI::App app("Measures how good a map or a trajectory is.", "slam_eval");
  app.formatter(crsm::MakeHelpFormatter());
  app.set_help_flag("-h,--help", "show this help and exit");
  app.set_version_flag("--version", std::string("slam_eval ") + crsm::kVersion, "show the version and exit");
  app.require_subcommand(1);
  crsm::AddMapCommand(app);
  crsm::AddTrajectoryCommand(app);
  crsm::AddRelationsCommand(app);
  crsm::AddSummaryCommand(app);
  crsm::AddWorldCommand(app);
  return crsm::ReportErrors("slam_eval", [&] {
    try {
      app.parse(argc, argv);
      return EXIT_SUCCESS;
    } catch (const CLI::ParseError& error) {
      if (error.get_exit_code() == 0) return app.exit(error);  // --help and --version
      throw crsm::UsageError(crsm::DescribeParseError(app, error));
    }
  });
}
