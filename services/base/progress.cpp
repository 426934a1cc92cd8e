#include "services/base/progress.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>

namespace crsm {
namespace {

using Seconds = std::chrono::duration<double>;

}  // namespace

Progress::Progress(std::string program) : program_(std::move(program)), terminal_(isatty(STDERR_FILENO) == 1) {
  next_ = start_ + (terminal_ ? std::chrono::milliseconds(0) : std::chrono::seconds(5));
}

void Progress::Show(const std::function<double()>& share, std::int64_t num_scans) {
  const auto now = Clock::now();
  if (now < next_) return;
  share_ = std::max(share_, share());  // a source that reads ahead in blocks may step back a little
  next_ = now + (terminal_ ? std::chrono::milliseconds(100) : std::chrono::seconds(5));
  const double rate_hz = static_cast<double>(num_scans) / Seconds(now - start_).count();
  Print(fmt::format("{}: {:3.0f} %, {} scans, {:.0f} scans/s", program_, 100.0 * share_, num_scans, rate_hz), false);
}

void Progress::Finish(std::int64_t num_scans) {
  const double elapsed_s = Seconds(Clock::now() - start_).count();
  Print(fmt::format("{}: {} scans in {:.1f} s, {:.0f} scans/s", program_, num_scans, elapsed_s,
                    static_cast<double>(num_scans) / elapsed_s),
        true);
}

void Progress::Print(const std::string& text, bool last) {
  if (terminal_) {
    fmt::print(stderr, "\r\033[K{}{}", text, last ? "\n" : "");
  } else {
    Say(text);
  }
}

}  // namespace crsm
