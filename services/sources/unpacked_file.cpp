#include "services/sources/unpacked_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "common/logs/stop_request.hpp"
#include "common/logs/temporary_file.hpp"
#include "services/base/file_window.hpp"
#include "services/sources/unpacker.hpp"

namespace crsm {
namespace {

constexpr std::size_t kPieceBytes = std::size_t{1} << 18;

/// A file as it was when it was unpacked.
struct Identity {
  std::uint64_t size = 0;
  std::filesystem::file_time_type written;
  friend bool operator==(const Identity&, const Identity&) = default;
};

struct Copy {
  Identity of;
  TemporaryFile file;
};

/// Of this process, by the paths of what was unpacked.
std::map<std::string, Copy>& Copies() {
  static std::map<std::string, Copy> copies;
  return copies;
}

[[noreturn]] void Fail(const std::string& path, const std::string& what) {
  throw std::runtime_error(fmt::format("{}: {}", path, what));
}

TemporaryFile Unpack(const std::string& path, FileWindow& file, Unpacker& unpacker,
                     const std::function<void(std::uint64_t num_bytes)>& progress) {
  TemporaryFile copy;
  std::vector<char> buffer(kPieceBytes);
  auto state = Unpacker::State::kGoesOn;
  for (std::uint64_t at = 0; at < file.size() && state != Unpacker::State::kDamaged;) {
    std::string_view packed = file.At(at, kPieceBytes);
    if (packed.empty()) break;  // the file was cut off meanwhile
    at += packed.size();
    for (bool goes_on = true; goes_on && state != Unpacker::State::kDamaged;) {
      if (StopRequested()) Fail(path, "stopped while it was unpacked");
      std::span<char> to(buffer);
      const std::size_t before = packed.size();
      state = unpacker.Go(packed, to);
      const std::size_t num = buffer.size() - to.size();
      copy.Append({reinterpret_cast<const std::uint8_t*>(buffer.data()), num});
      progress(copy.size());
      goes_on = num > 0 || packed.size() != before;
    }
  }
  copy.Flush();
  if (copy.size() == 0) Fail(path, "cannot be unpacked: it is damaged, or empty");
  return copy;
}

}  // namespace

std::string PathOfUnpacked(const std::string& path, const std::function<void(const std::string&)>& say) {
  constexpr std::uint64_t kLarge = std::uint64_t{50} << 20;
  constexpr std::size_t kStartBytes = 16;
  FileWindow file(path);
  const Identity identity{file.size(), std::filesystem::last_write_time(path)};
  if (const auto copy = Copies().find(path); copy != Copies().end()) {
    if (copy->second.of == identity) return copy->second.file.path();
    Copies().erase(copy);
  }
  const std::string compression = FindCompression(file.At(0, kStartBytes));
  if (compression.empty()) return path;
  TemporaryFile copy = Unpack(path, file, *MakeUnpacker(compression), [&, said = false](std::uint64_t size) mutable {
    if (size < kLarge || std::exchange(said, true)) return;
    say(fmt::format("{}: is unpacked ({}) to a temporary file first", path, compression));
  });
  return Copies().emplace(path, Copy{identity, std::move(copy)}).first->second.file.path();
}

void ForgetUnpacked(const std::string& path) { Copies().erase(path); }

std::string NameUnpacked(std::string text) {
  for (const auto& [path, copy] : Copies()) {
    const std::string of_copy = copy.file.path();
    for (std::size_t at = 0; (at = text.find(of_copy, at)) != std::string::npos; at += path.size()) {
      const std::size_t end = at + of_copy.size();
      if (end < text.size() && text[end] >= '0' && text[end] <= '9') break;  // of another descriptor
      text.replace(at, of_copy.size(), path);
    }
  }
  return text;
}

}  // namespace crsm
