#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "services/run_stack/child.hpp"
#include "services/run_stack/stack_plan.hpp"

namespace crsm {

/// A process of the stack, and what became of it.
struct Member {
  PlannedService plan;
  std::optional<Child> child = std::nullopt;  ///< none once its end was dealt with
  std::uintmax_t log_begin = 0;               ///< where its log was when it was last started [bytes]
  int num_deaths = 0;                         ///< since a scan was mapped
  std::optional<std::uintmax_t> journal_bytes_at_death = std::nullopt;

  /// more: arguments behind those of the plan.
  void Start(const std::vector<std::string>& more = {});

  bool IsRunning() { return child && child->IsRunning(); }
  bool HasEnded() { return child && !child->IsRunning(); }
  /// Whether it has said so since it was started.
  bool IsReady() const;
};

/// [bytes]; 0 if there is no such file.
std::uintmax_t SizeOf(const std::filesystem::path& file);

/// Of what a process has said; empty where somebody has put something else there: a FIFO would let us wait.
std::ifstream OpenLog(const std::filesystem::path& path);

/// Says the end of a log, if there is any.
void SayLastLines(const std::filesystem::path& log);

}  // namespace crsm
