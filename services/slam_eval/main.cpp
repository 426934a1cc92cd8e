#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>

#include "services/runtime/usage_error.hpp"
#include "services/runtime/version.hpp"
#include "services/slam_eval/commands.hpp"

int main(int argc, char** argv) {
  CLI::App app("Measures how good a map or a trajectory is.", "slam_eval");
  app.set_version_flag("--version", std::string("slam_eval ") + crsm::kVersion);
  app.require_subcommand(1);
  crsm::AddMapCommand(app);
  crsm::AddTrajectoryCommand(app);
  crsm::AddRelationsCommand(app);
  crsm::AddWorldCommand(app);
  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help and --version
    fmt::print(stderr, "slam_eval: {}; try --help\n", error.what());
    return 2;
  } catch (const crsm::UsageError& error) {
    fmt::print(stderr, "slam_eval: {}\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "slam_eval: {}\n", error.what());
  }
  return 1;
}
