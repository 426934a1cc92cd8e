#include "services/laser_publisher/position.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <stdexcept>
#include <string_view>

namespace crsm {
namespace {

constexpr std::size_t kNumDigits = 20;  // always as many, so that the text of one number covers that of another

}  // namespace

Position::Position(const std::string& path) {
  if (path.empty()) return;
  descriptor_ = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NONBLOCK, 0666);
  if (descriptor_ < 0) throw std::runtime_error(fmt::format("--position {}: {}", path, std::strerror(errno)));
  std::array<char, kNumDigits + 2> text{};
  const ssize_t size = pread(descriptor_, text.data(), text.size(), 0);
  if (size == 0) return;  // a new one
  const auto [end, error] = std::from_chars(text.data(), text.data() + kNumDigits, num_scans_);
  if (size != kNumDigits + 1 || error != std::errc() || *end != '\n' || num_scans_ < 0) {
    close(descriptor_);
    throw std::runtime_error(
        fmt::format("--position {}: holds no number of scans; remove the file to start with the first scan", path));
  }
}

Position::~Position() {
  if (descriptor_ >= 0) close(descriptor_);
}

void Position::Advance() {
  ++num_scans_;
  if (descriptor_ < 0) return;
  std::array<char, kNumDigits + 1> text{};
  fmt::format_to_n(text.data(), text.size(), "{:020}\n", num_scans_);
  [[maybe_unused]] const ssize_t written = pwrite(descriptor_, text.data(), text.size(), 0);
}

}  // namespace crsm
