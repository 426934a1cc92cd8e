#include "services/run_stack/child.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "services/run_stack/signals.hpp"

namespace crsm {
namespace {

constexpr int kNotStarted = 127;  // as a shell says it

void StayOn(int core) {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  CPU_SET(static_cast<std::size_t>(core), &cores);
  sched_setaffinity(0, sizeof(cores), &cores);
}

/// As far as the kernel grants it. The same as in the units of systemd.
void Take(Priority priority) {
  constexpr int kAboveUsual = 5;  // of the real-time ones, which are 1 to 99
  constexpr int kNiceFirst = -10;
  constexpr int kNiceLast = 10;
  if (priority == Priority::kLast) setpriority(PRIO_PROCESS, 0, kNiceLast);
  if (priority != Priority::kFirst) return;
  sched_param parameters{};
  parameters.sched_priority = kAboveUsual;
  // What a thread of it does beside, drawing say, has time.
  if (sched_setscheduler(0, SCHED_RR | SCHED_RESET_ON_FORK, &parameters) != 0) setpriority(PRIO_PROCESS, 0, kNiceFirst);
}

/// That of this process with `more` variables, which win.
std::vector<std::string> MakeEnvironment(const std::map<std::string, std::string>& more) {
  std::vector<std::string> variables;
  for (const auto& [name, value] : more) variables.push_back(name + '=' + value);
  for (char** variable = environ; *variable; ++variable) {
    const std::string text = *variable;
    if (more.count(text.substr(0, text.find('='))) == 0) variables.push_back(text);
  }
  return variables;
}

/// As execve takes them: they end with a null pointer.
std::vector<char*> PointTo(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

/// Runs in the new process. Where the log cannot be written, what it says goes where ours goes.
[[noreturn]] void Become(char* const* arguments, char* const* environment, const char* log, const Command& command,
                         pid_t supervisor) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != supervisor) _exit(kNotStarted);  // it died before the kernel knew of our wish
  setsid();
  Signals::Restore();
  if (command.core) StayOn(*command.core);
  Take(command.priority);
  dup2(open("/dev/null", O_RDONLY | O_CLOEXEC), STDIN_FILENO);
  if (*log != '\0') {
    // For the user alone: a viewer's log has the token of its page.
    const int file = open(log, O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0600);
    if (file >= 0 && fchmod(file, 0600) == 0) {
      dup2(file, STDOUT_FILENO);
      dup2(file, STDERR_FILENO);
    }
  }
  execve(arguments[0], arguments, environment);
  _exit(kNotStarted);
}

}  // namespace

Child::Child(const Command& command) {
  std::vector<std::string> words{command.program.string()};
  words.insert(words.end(), command.arguments.begin(), command.arguments.end());
  std::vector<std::string> variables = MakeEnvironment(command.environment);
  const std::vector<char*> argv = PointTo(words);
  const std::vector<char*> envp = PointTo(variables);
  const std::string log = command.log.string();
  const pid_t supervisor = getpid();
  pid_ = fork();
  if (pid_ == 0) Become(argv.data(), envp.data(), log.c_str(), command, supervisor);
  if (pid_ < 0) throw std::runtime_error(fmt::format("cannot start a process: {}", std::strerror(errno)));
}

bool Child::IsRunning() {
  if (running_ && waitpid(pid_, &status_, WNOHANG) == pid_) running_ = false;
  return running_;
}

void Child::Signal(int number) const {
  if (running_) kill(pid_, number);
}

bool Child::EndedWell() const {
  return WIFEXITED(status_) ? WEXITSTATUS(status_) == EXIT_SUCCESS : WTERMSIG(status_) == SIGINT;
}

std::string Child::DescribeEnd() const {
  return WIFEXITED(status_) ? fmt::format("exit code {}", WEXITSTATUS(status_))
                            : fmt::format("signal {}", WTERMSIG(status_));
}

}  // namespace crsm
