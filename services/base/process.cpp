#include "services/base/process.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "services/base/usage_error.hpp"

namespace crsm {
namespace {

void RequestStop(int) { stop_requested = true; }

/// What a process that was killed while it wrote results (WriteResults) has left: .NAME.PID.tmp
void RemoveLeftovers(const std::string& out) {
  constexpr std::array<std::string_view, 5> kResults{"map", "overview", "trajectory", "truth", "summary"};
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(out, error)) {
    const std::string name = entry.path().filename().string();
    char result[16];
    int writer = 0;
    int length = 0;
    if (std::sscanf(name.c_str(), ".%15[a-z].%*[a-z].%9d.tmp%n", result, &writer, &length) != 2) continue;
    if (std::cmp_not_equal(length, name.size()) || writer < 1) continue;
    if (std::find(kResults.begin(), kResults.end(), result) == kResults.end()) continue;
    if (kill(writer, 0) != 0 && errno == ESRCH) std::filesystem::remove(entry.path(), error);
  }
}

}  // namespace

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
