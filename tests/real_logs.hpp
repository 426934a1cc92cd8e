#pragma once

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace crsm {

/// Where the real logs are, which are no part of the project: $CRSM_DATA, or shared/data beside the project.
inline std::filesystem::path RealLogFolder() {
  const char* folder = std::getenv("CRSM_DATA");
  return std::filesystem::path(folder ? folder : CRSM_SOURCE_DIR "/../shared/data").lexically_normal();
}

/// How often a test was skipped; the test programs end with kExitSkipped then, unless one failed.
inline int num_skipped = 0;
inline constexpr int kExitSkipped = 77;  ///< as automake has it; ctest shows "Skipped"

/// A real log, or a file that belongs to one. Where there is none it says so, and the test is to return.
inline std::optional<std::string> FindRealLog(const std::string& name) {
  const std::filesystem::path path = RealLogFolder() / name;
  if (std::filesystem::exists(path)) return path.string();
  std::printf("skipped: no %s in %s; CRSM_DATA names another folder\n", name.c_str(), RealLogFolder().c_str());
  std::fflush(stdout);
  ++num_skipped;
  return std::nullopt;
}

}  // namespace crsm
