#include "services/base/progress.hpp"

#include <fmt/core.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "common/math/format_number.hpp"

namespace crsm {
namespace {

using Seconds = std::chrono::duration<double>;

int CountColumns() {
  constexpr int kUsual = 80;
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : kUsual;
}

std::string FormatTimeLeft(double time_s) {
  const auto whole_s = static_cast<std::int64_t>(std::ceil(time_s));
  if (whole_s < 100) return fmt::format("{} s", whole_s);
  const std::int64_t minutes = (whole_s + 30) / 60;
  return minutes < 100 ? fmt::format("{} min", minutes) : fmt::format("{} h {} min", minutes / 60, minutes % 60);
}

}  // namespace

std::string FormatProgress(const std::string& program, double share, std::int64_t num_scans, double elapsed_s,
                           int columns) {
  constexpr double kLeastShare = 0.01;
  constexpr double kLeast_s = 1.0;
  constexpr int kShortestBar = 10;
  constexpr int kLongestBar = 30;
  std::string text = fmt::format("{:3.0f} %, {}, {:.0f} scans/s", 100.0 * share, FormatCount(num_scans, "scan"),
                                 static_cast<double>(num_scans) / std::max(elapsed_s, 1e-3));
  if (share >= kLeastShare && elapsed_s >= kLeast_s) {
    text += fmt::format(", {} left", FormatTimeLeft(elapsed_s * (1.0 - share) / share));
  }
  const std::string head = program + ": ";
  const int room = columns - static_cast<int>(head.size() + text.size()) - 4;  // its ends, a space, and the cursor
  if (room >= kShortestBar) {
    const int length = std::min(room, kLongestBar);
    const int done = static_cast<int>(std::lround(share * length));
    text = fmt::format("[{}{}] {}", std::string(static_cast<std::size_t>(done), '#'),
                       std::string(static_cast<std::size_t>(length - done), '.'), text);
  }
  text = head + text;
  if (columns > 0) text.resize(std::min(text.size(), static_cast<std::size_t>(columns) - 1));  // else it breaks
  return text;
}

Progress::Progress(std::string program) : program_(std::move(program)), terminal_(isatty(STDERR_FILENO) == 1) {
  next_ = start_ + (terminal_ ? std::chrono::milliseconds(0) : std::chrono::seconds(5));
}

void Progress::Show(const std::function<double()>& share, std::int64_t num_scans) {
  const auto now = Clock::now();
  if (now < next_) return;
  share_ = std::clamp(share(), share_, 1.0);  // a source that reads ahead in blocks may step back a little
  next_ = now + (terminal_ ? std::chrono::milliseconds(100) : std::chrono::seconds(5));
  const std::string text =
      FormatProgress(program_, share_, num_scans, Seconds(now - start_).count(), terminal_ ? CountColumns() : 0);
  terminal_ ? fmt::print(stderr, "\r\033[K{}", text) : Say(text);
}

void Progress::Finish(std::int64_t num_scans) {
  const double elapsed_s = Seconds(Clock::now() - start_).count();
  Say(fmt::format("{}: {} in {:.1f} s, {:.0f} scans/s", program_, FormatCount(num_scans, "scan"), elapsed_s,
                  static_cast<double>(num_scans) / elapsed_s));
}

}  // namespace crsm
