#include "services/base/process.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <functional>
#include <string>
#include <utility>

#include "catch.hpp"

using namespace crsm;

TEST_CASE("an identity is the same until the machine starts anew, and each is another one") {
  CHECK(IdentityOfThisBoot(5) == IdentityOfThisBoot(5));
  CHECK(IdentityOfThisBoot(5) != 5);
  CHECK(IdentityOfThisBoot(5) != IdentityOfThisBoot(6));
  const std::int64_t mixed = IdentityOfThisBoot(5) ^ 5;
  CHECK(IdentityOfThisBoot(mixed) != 0);  // which stands for no map
}

namespace {

/// Runs `body` in a process of its own, sends it a signal once it has said that it is there, and returns its exit code,
/// or 128 and the number of the signal that ended it, and what it said on stderr.
std::pair<int, std::string> EndBySignal(int signal, const std::function<void()>& body) {
  int pipe_ends[2];
  REQUIRE(pipe(pipe_ends) == 0);
  const pid_t child = fork();
  if (child == 0) {
    close(pipe_ends[0]);
    dup2(pipe_ends[1], STDERR_FILENO);
    body();
    _exit(99);
  }
  close(pipe_ends[1]);
  std::string said;
  char byte = 0;
  while (said.find('!') == std::string::npos && read(pipe_ends[0], &byte, 1) == 1) said += byte;
  kill(child, signal);
  while (read(pipe_ends[0], &byte, 1) == 1) said += byte;
  close(pipe_ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), said};
}

void SayThatItIsThere() { [[maybe_unused]] const auto ignored = write(STDERR_FILENO, "!", 1); }

}  // namespace

TEST_CASE("what would leave nothing behind ends at once when a signal asks for it, whatever it does") {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const auto [exit_code, said] = EndBySignal(signal, [] {
      const EndsAtOnce ends_at_once("stopped: nothing was written");
      SayThatItIsThere();
      for (std::atomic<int> work = 0;;) ++work;
    });
    CHECK(exit_code == 0);
    CHECK(said == "!stopped: nothing was written\n");
  }
}

TEST_CASE("a process ends at once until it catches signals, and then by itself") {
  const auto [exit_code, said] = EndBySignal(SIGTERM, [] {
    _exit(RunMain("program", [] {
      SayThatItIsThere();
      pause();
    }));
  });
  CHECK(exit_code == 0);
  CHECK(said == "!program: stopped before it was ready: nothing was written\n");
  const auto [own_exit_code, own_words] = EndBySignal(SIGTERM, [] {
    _exit(RunMain("program", [] {
      CatchSignals();
      SayThatItIsThere();
      while (!StopRequested()) usleep(1000);
      throw Stopped("is done");
    }));
  });
  CHECK(own_exit_code == 0);
  CHECK(own_words == "!program: is done\n");
}

TEST_CASE("after what ends at once signals do again what they did before, and one that came before ends it") {
  const auto [exit_code, said] = EndBySignal(SIGTERM, [] {
    CatchSignals();
    { const EndsAtOnce ends_at_once("not said"); }
    SayThatItIsThere();
    while (!StopRequested()) usleep(1000);
    const EndsAtOnce ends_at_once(std::string(2000, 'x'));
  });
  CHECK(exit_code == 0);
  CHECK(said == "!" + std::string(1000, 'x') + '\n');
}

TEST_CASE("a second request is to hurry, but for one that comes within a moment") {
  const auto [exit_code, said] = EndBySignal(SIGTERM, [] {
    CatchSignals();
    SayThatItIsThere();
    while (!StopRequested()) usleep(1000);
    raise(SIGINT);
    if (HurryRequested()) _exit(1);
    usleep(300'000);
    raise(SIGINT);
    _exit(HurryRequested() ? 0 : 2);
  });
  CHECK(exit_code == 0);
}
