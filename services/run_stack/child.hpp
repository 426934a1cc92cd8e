#pragma once

#include <sys/types.h>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace crsm {

/// Who gets the processor where there is too little of it.
enum class Priority {
  kFirst,  ///< a control loop waits for it: before everybody else, where the user may ask for that
  kUsual,
  kLast  ///< nobody waits for it: what is left
};

/// What a process is started with.
struct Command {
  std::filesystem::path program;
  std::vector<std::string> arguments;
  std::filesystem::path log;     ///< what it says goes to the end of this file; empty: where ours goes
  std::optional<int> core = {};  ///< of the processor, on which alone it runs where the kernel grants that
  Priority priority = Priority::kUsual;
  std::map<std::string, std::string> environment = {};  ///< variables, beside those of this process
};

/// A process that was started here. It has a session of its own, so that Ctrl-C in a terminal does not reach it, and is
/// asked to end (SIGTERM) by the kernel where its supervisor dies.
class Child {
 public:
  /// Throws std::runtime_error if no process can be started.
  explicit Child(const Command& command);

  bool IsRunning();
  void Signal(int number) const;

  /// Once it does not run any more. With success also if a SIGINT came before it could heed it.
  bool EndedWell() const;
  /// "exit code 3", "signal 9".
  std::string DescribeEnd() const;

 private:
  pid_t pid_ = -1;
  bool running_ = true;
  int status_ = 0;  ///< as waitpid gives it
};

}  // namespace crsm
