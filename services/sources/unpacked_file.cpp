#include "services/sources/unpacked_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
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
  bool is_whole = false;
};

/// Of this process, by the paths of what was unpacked.
std::map<std::string, Copy>& Copies() {
  static std::map<std::string, Copy> copies;
  return copies;
}

[[noreturn]] void Fail(const std::string& path, const std::string& what) {
  throw std::runtime_error(fmt::format("{}: {}", path, what));
}

/// A file that unpacks to very much, by accident or not, leaves others room on the disk.
void CheckRoom(const std::string& path, const TemporaryFile& copy) {
  constexpr double kLeastFree = 0.05;
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(copy.path(), error);
  if (error || static_cast<double>(space.available) >= kLeastFree * static_cast<double>(space.capacity)) return;
  Fail(path, fmt::format("has unpacked to {} MB so far, and would fill the disk of the temporary file: TMPDIR names "
                         "another folder",
                         copy.size() >> 20));
}

/// A large file is said, once.
Copy Unpack(const std::string& path, FileWindow& file, const std::string& compression,
            const std::function<void(const std::string&)>& say) {
  constexpr std::uint64_t kLarge = std::uint64_t{50} << 20;
  const std::unique_ptr<Unpacker> unpacker = MakeUnpacker(compression);
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
      state = unpacker->Go(packed, to);
      const std::size_t num = buffer.size() - to.size();
      const std::uint64_t size_before = copy.size();
      copy.Append({reinterpret_cast<const std::uint8_t*>(buffer.data()), num});
      if (copy.size() / kLarge > size_before / kLarge) CheckRoom(path, copy);
      if (size_before < kLarge && copy.size() >= kLarge)
        say(fmt::format("{}: is unpacked ({}) to a temporary file first", path, compression));
      goes_on = num > 0 || packed.size() != before;
    }
  }
  copy.Flush();
  if (copy.size() == 0) Fail(path, "cannot be unpacked: it is damaged, or empty");
  return {{}, std::move(copy), state == Unpacker::State::kWhole};
}

}  // namespace

std::string PathOfUnpacked(const std::string& path, const std::function<void(const std::string&)>& say) {
  constexpr std::size_t kStartBytes = 16;
  FileWindow file(path);
  const Identity identity{file.size(), std::filesystem::last_write_time(path)};
  if (const auto copy = Copies().find(path); copy != Copies().end()) {
    if (copy->second.of == identity) return copy->second.file.path();
    Copies().erase(copy);
  }
  const std::string compression = FindCompression(file.At(0, kStartBytes));
  if (compression.empty()) return path;
  Copy copy = Unpack(path, file, compression, say);
  copy.of = identity;
  return Copies().emplace(path, std::move(copy)).first->second.file.path();
}

bool IsUnpackedWhole(const std::string& path) {
  const auto copy = Copies().find(path);
  return copy == Copies().end() || copy->second.is_whole;
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
