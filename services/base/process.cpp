#include "services/base/process.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <new>
#include <stdexcept>

#include "common/logs/replacement.hpp"
#include "services/base/usage_error.hpp"

namespace crsm {
namespace {

void RequestStop(int) { stop_requested = true; }

}  // namespace

std::int64_t UtimeNow() {
  const auto since_1970 = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::microseconds>(since_1970).count();
}

void CatchSignals() {
  struct sigaction action {};
  action.sa_handler = RequestStop;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  struct sigaction hangup {};
  if (sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);
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
  CatchSignals();
  return ReportErrors(program, [&] { return body(), 0; });
}

}  // namespace crsm
