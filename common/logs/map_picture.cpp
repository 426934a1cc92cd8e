#include "common/logs/map_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <vector>

#include "common/logs/regular_file.hpp"
#include "common/logs/replacement.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

constexpr const char* kImage = "image: ";

/// Of "map.12.png".
std::optional<int> NumberOf(const std::string& name) {
  int number = 0;
  if (std::sscanf(name.c_str(), "map.%9d.png", &number) != 1 || number < 1) return std::nullopt;
  return name == fmt::format("map.{}.png", number) ? std::optional(number) : std::nullopt;
}

/// Empty where there is none.
std::string ReadIfThere(const fs::path& path) {
  try {
    return ReadWholeFile(path);
  } catch (const std::runtime_error&) {
    return "";
  }
}

/// The value of the line that names the picture, in the text of map.yaml.
struct Place {
  std::size_t begin = 0;
  std::size_t size = 0;
};

std::optional<Place> FindName(const std::string& yaml) {
  std::size_t at = yaml.starts_with(kImage) ? 0 : yaml.find(std::string("\n") + kImage);
  if (at == std::string::npos) return std::nullopt;
  at = yaml.find(kImage, at) + std::char_traits<char>::length(kImage);
  return Place{at, std::min(yaml.find('\n', at), yaml.size()) - at};
}

std::vector<std::string> ListNumbered(const fs::path& dir) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(dir, error)) {
    std::string name = entry.path().filename().string();
    if (IsNumberedPicture(name)) names.push_back(std::move(name));
  }
  return names;
}

}  // namespace

bool IsNumberedPicture(const std::string& name) { return NumberOf(name).has_value(); }

std::string FindPicture(const fs::path& dir) {
  const std::string yaml = ReadIfThere(dir / "map.yaml");
  const auto place = FindName(yaml);
  std::string name = place ? yaml.substr(place->begin, place->size) : kMapPicture;
  return IsNumberedPicture(name) ? name : kMapPicture;
}

std::string NameNextPicture(const fs::path& dir) {
  int largest = 0;
  for (const std::string& name : ListNumbered(dir)) largest = std::max(largest, *NumberOf(name));
  constexpr int kMost = 999'999'999;
  return fmt::format("map.{}.png", largest < kMost ? largest + 1 : 1);
}

void FreeMapPicture(const fs::path& dir) {
  constexpr auto kToOpenIt = std::chrono::milliseconds(100);
  std::string yaml = ReadIfThere(dir / "map.yaml");
  const auto place = FindName(yaml);
  if (!place || yaml.substr(place->begin, place->size) != kMapPicture) return;
  const std::string picture = ReadIfThere(dir / kMapPicture);
  if (picture.empty()) return;
  const std::string name = NameNextPicture(dir);
  // Of its own name first: map.yaml of another map may be half written.
  const std::string yaml_beside = fs::path(name).replace_extension(".yaml");
  Replacement files(dir);
  files.Write(name, picture);
  files.Write(yaml_beside, yaml.replace(place->begin, place->size, name));
  files.Rename();
  fs::rename(dir / yaml_beside, dir / "map.yaml");
  std::this_thread::sleep_for(kToOpenIt);
}

void RemoveOldPictures(const fs::path& dir, const std::string& kept) {
  const std::string named = FindPicture(dir);
  for (const std::string& name : ListNumbered(dir)) {
    std::error_code error;
    if (name != kept && name != named) fs::remove(dir / name, error);
    fs::remove((dir / name).replace_extension(".yaml"), error);
  }
}

}  // namespace crsm
