#include "services/base/process_info.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <fstream>
#include <iterator>

namespace crsm {

std::string DescribeProcess(pid_t pid) {
  constexpr std::size_t kLongest = 300;
  if (pid <= 0) return "a process that cannot be seen from here";  // in a container of its own
  std::ifstream file(fmt::format("/proc/{}/cmdline", pid), std::ios::binary);
  std::string words{std::istreambuf_iterator<char>(file), {}};
  while (!words.empty() && words.back() == '\0') words.pop_back();
  words.resize(std::min(words.size(), kLongest));
  for (char& c : words) {
    if (c == '\0') c = ' ';  // between two words
    if (c >= 0 && (c < ' ' || c == 127)) c = '?';
  }
  return words.empty() ? fmt::format("process {}", pid) : fmt::format("process {} ({})", pid, words);
}

}  // namespace crsm
