#include "services/base/process.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <new>
#include <stdexcept>

#include "common/logs/replacement.hpp"
#include "services/base/usage_error.hpp"

namespace crsm {
namespace {

constexpr std::array kToEnd{SIGINT, SIGTERM, SIGHUP};

std::atomic<std::int64_t> first_request_ns = 0;
std::atomic<bool> hurry_requested = false;
static_assert(std::atomic<std::int64_t>::is_always_lock_free);  // or no signal handler might set it

/// What comes within a moment is the same request: timeout(1) sends its signal to a process and to its group.
void RequestStop(int) {
  constexpr std::int64_t kMoment_ns = 200'000'000;
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  const std::int64_t now_ns = std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
  if (!stop_requested.exchange(true)) {
    first_request_ns = now_ns;
  } else if (now_ns - first_request_ns > kMoment_ns) {
    hurry_requested = true;
  }
}

/// What EndAtOnce says. A signal handler may not make it.
struct LastWords {
  std::array<char, 1001> text;
  std::size_t size;
};
LastWords last_words;

void EndAtOnce(int) {
  [[maybe_unused]] const auto ignored = write(STDERR_FILENO, last_words.text.data(), last_words.size);
  _exit(EXIT_SUCCESS);
}

/// Where whoever started this process had SIGHUP ignored, as nohup does, it stays so.
void Handle(void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  for (const int number : kToEnd) {
    struct sigaction before {};
    const bool is_ignored = sigaction(number, nullptr, &before) == 0 && before.sa_handler == SIG_IGN;
    if (number != SIGHUP || !is_ignored) sigaction(number, &action, nullptr);
  }
}

}  // namespace

std::int64_t UtimeNow() {
  const auto since_1970 = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::microseconds>(since_1970).count();
}

void CatchSignals() { Handle(RequestStop); }

bool HurryRequested() { return hurry_requested.load(std::memory_order_relaxed); }

EndsAtOnce::EndsAtOnce(const std::string& line) {
  last_words.size = std::min(line.size(), last_words.text.size() - 1);
  std::copy_n(line.begin(), last_words.size, last_words.text.begin());
  last_words.text[last_words.size++] = '\n';
  for (std::size_t i = 0; i < kToEnd.size(); ++i) sigaction(kToEnd[i], nullptr, &before_[i]);
  Handle(EndAtOnce);
  if (StopRequested()) EndAtOnce(0);
}

EndsAtOnce::~EndsAtOnce() {
  for (std::size_t i = 0; i < kToEnd.size(); ++i) {
    struct sigaction now {};
    sigaction(kToEnd[i], nullptr, &now);
    if (now.sa_handler == EndAtOnce) sigaction(kToEnd[i], &before_[i], nullptr);
  }
}

void PrepareProcess() {
  for (int descriptor = STDIN_FILENO; descriptor <= STDERR_FILENO;) {
    if (fcntl(descriptor, F_GETFD) >= 0) {
      ++descriptor;
    } else if (open("/dev/null", O_RDWR) < 0) {  // gets the lowest number that is free
      break;
    }
  }
  signal(SIGXFSZ, SIG_IGN);
}

void PrepareFolder(const std::string& out) {
  if (out.empty()) throw UsageError("--out is missing: give the folder for the results");
  std::error_code error;
  std::filesystem::create_directories(out, error);
  if (error || access(out.c_str(), W_OK) != 0) {
    throw std::runtime_error(
        fmt::format("--out {}: cannot be written: {}", out, error ? error.message() : std::strerror(errno)));
  }
  RemoveLeftovers(out);
}

int ReportErrors(const std::string& program, const std::function<int()>& body) {
  try {
    return body();
  } catch (const Stopped& stopped) {
    Say(fmt::format("{}: {}", program, stopped.what()));
    return EXIT_SUCCESS;
  } catch (const UsageError& error) {
    Say(fmt::format("{}: {}", program, error.what()));
    return 2;
  } catch (const std::bad_alloc&) {
    Say(program + ": there is no memory left");
    return 1;
  } catch (const std::exception& error) {
    Say(fmt::format("{}: {}", program, error.what()));
    return 1;
  }
}

int RunMain(const std::string& program, const std::function<void()>& body) {
  const EndsAtOnce ends_at_once(program + ": stopped before it was ready: nothing was written");
  return ReportErrors(program, [&] { return body(), 0; });
}

}  // namespace crsm
