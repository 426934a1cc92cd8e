#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace CLI {
class App;  // its header takes three seconds to compile
}

namespace crsm {

/// The command line of a program that has several commands, each with words and flags of its own.
class Commands {
 public:
  /// One of them. What it takes is stored before it runs.
  class Command {
   public:
    explicit Command(CLI::App& app) : app_(app) {}

    Command& AddWord(const std::string& name, std::string& word, const std::string& help);
    Command& AddOptionalWord(const std::string& name, std::string& word, const std::string& help);
    Command& AddWords(const std::string& name, std::vector<std::string>& words, const std::string& help);
    Command& AddOption(const std::string& flag, std::string& value, const std::string& help);
    /// --help shows the value that it has by now.
    Command& AddOption(const std::string& flag, double& value, const std::string& help);
    Command& AddFlag(const std::string& flag, bool& given, const std::string& help);

   private:
    CLI::App& app_;
  };

  Commands(const std::string& program, const std::string& description);
  ~Commands();

  /// run: throws std::exception if it fails.
  Command Add(const std::string& name, const std::string& description, const std::function<void()>& run);

  /// Runs the command that is named. Returns the exit code, as of ReportErrors.
  int Run(int argc, const char* const* argv);

 private:
  std::string program_;
  std::unique_ptr<CLI::App> app_;
};

}  // namespace crsm
