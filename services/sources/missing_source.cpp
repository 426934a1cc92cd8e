#include "services/sources/missing_source.hpp"

#include <fmt/core.h>

#include <filesystem>
#include <stdexcept>

#include "common/math/nearest_name.hpp"
#include "common/worlds/world.hpp"
#include "services/base/usage_error.hpp"
#include "services/sources/devices/serial_ports.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLive = "live";
constexpr const char* kWorldPrefix = "sim";

/// What is in a folder, the first ones of very many.
std::vector<std::string> ListFolder(const fs::path& folder) {
  constexpr std::size_t kMost = 10'000;
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    names.push_back(entry->path().filename().string());
    if (names.size() == kMost) break;
  }
  return names;
}

/// The file with the most similar name in the same folder, or of the same name in a folder with a similar name.
std::string FindNearestFile(const fs::path& path) {
  std::error_code error;
  const fs::path folder = path.parent_path();
  const auto HereIfEmpty = [](const fs::path& place) { return place.empty() ? fs::path(".") : place; };
  if (fs::is_directory(HereIfEmpty(folder), error)) {
    const std::string name = FindNearestName(path.filename().string(), ListFolder(HereIfEmpty(folder)));
    return name.empty() ? "" : (folder / name).string();
  }
  const fs::path above = folder.parent_path();
  const std::string name = FindNearestName(folder.filename().string(), ListFolder(HereIfEmpty(above)));
  const fs::path nearest = above / name / path.filename();
  return !name.empty() && fs::exists(nearest, error) ? nearest.string() : "";
}

std::string FindNearestSource(const std::string& name) {
  std::vector<std::string> beginnings{fmt::format("{}:", kWorldPrefix)};
  std::vector<std::string> words{kLive};
  for (const DeviceKind& kind : DeviceKinds()) {
    beginnings.push_back(kind.name + ':');
    words.push_back(kind.name);
  }
  if (const std::size_t colon = name.find(':'); colon != std::string::npos) {
    const std::string beginning = FindNearestName(name.substr(0, colon + 1), beginnings);
    if (!beginning.empty()) return beginning + name.substr(colon + 1);
  }
  const std::string file = FindNearestFile(name);
  if (!file.empty()) return file;
  const std::string world = FindNearestName(name, ListBuiltInWorlds());
  if (!world.empty()) return fmt::format("{}:{}", kWorldPrefix, world);
  return FindNearestName(name, words);
}

}  // namespace

void ThrowMissingSource(const std::string& name) {
  if (name == kLive) {
    throw UsageError("live: only run_stack maps the scans of another program: run_stack live --out DIR");
  }
  for (const DeviceKind& kind : DeviceKinds()) {
    if (name == kind.name) throw UsageError(DescribeMissingPort(kind, FindSerialPorts()));
  }
  const std::string nearest = FindNearestSource(name);
  throw std::runtime_error(
      fmt::format("there is no file {}{}", name, nearest.empty() ? "" : fmt::format("; did you mean {}?", nearest)));
}

}  // namespace crsm
