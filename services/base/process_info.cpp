#include "services/base/process_info.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <vector>

namespace crsm {

namespace {

/// The inodes of the sockets at a port, by the kernel's table: a line for each, with the local address in its second
/// word, "0100007F:1DF3", and the inode in its tenth.
std::set<std::string> FindUdpInodes(std::uint16_t port) {
  std::set<std::string> inodes;
  std::ifstream table("/proc/self/net/udp");
  const std::string ending = fmt::format(":{:04X}", port);
  for (std::string line; std::getline(table, line);) {
    std::istringstream words(line);
    const std::vector<std::string> word{std::istream_iterator<std::string>(words), {}};
    if (word.size() >= 10 && word[1].ends_with(ending)) inodes.insert(fmt::format("socket:[{}]", word[9]));
  }
  return inodes;
}

}  // namespace

std::optional<bool> HasUdpPort(pid_t pid, std::uint16_t port) {
  const std::set<std::string> inodes = FindUdpInodes(port);
  std::error_code error;
  const std::filesystem::path folder = fmt::format("/proc/{}/fd", pid);
  for (std::filesystem::directory_iterator file(folder, error), end; !error && file != end; file.increment(error)) {
    std::error_code closed_meanwhile;
    if (inodes.count(std::filesystem::read_symlink(file->path(), closed_meanwhile)) > 0) return true;
  }
  return error ? std::nullopt : std::optional(false);
}

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
