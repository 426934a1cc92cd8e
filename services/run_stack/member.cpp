#include "services/run_stack/member.hpp"

#include <fmt/core.h>

#include <deque>

#include "services/base/process.hpp"

namespace crsm {

void Member::Start(const std::vector<std::string>& more) {
  Command command = plan.command;
  command.arguments.insert(command.arguments.end(), more.begin(), more.end());
  log_begin = SizeOf(command.log);
  child.emplace(command);
}

bool Member::IsReady() const {
  std::ifstream file = OpenLog(plan.command.log);
  file.seekg(static_cast<std::streamoff>(log_begin));
  const std::string ready = plan.name + ": ready";
  for (std::string line; std::getline(file, line);) {
    if (line == ready) return true;
  }
  return false;
}

std::uintmax_t SizeOf(const std::filesystem::path& file) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  return error ? 0 : size;
}

std::ifstream OpenLog(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error) ? std::ifstream(path) : std::ifstream();
}

void SayLastLines(const std::filesystem::path& log) {
  constexpr std::size_t kNumLines = 10;
  std::deque<std::string> lines;
  std::ifstream file = OpenLog(log);
  for (std::string line; std::getline(file, line);) {
    lines.push_back(line);
    if (lines.size() > kNumLines) lines.pop_front();
  }
  if (lines.empty()) return;
  Say(fmt::format("last lines of {}:", log.string()));
  for (const std::string& line : lines) Say(line);
}

}  // namespace crsm
