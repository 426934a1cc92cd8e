#include "services/base/process_info.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <vector>

#include "common/math/parse_number.hpp"

namespace crsm {

namespace {

/// One word of each socket at a port, by the kernel's table: a line for each, with the local address in its second
/// word, "0100007F:1DF3".
std::set<std::string> FindInUdpTable(std::uint16_t port, std::size_t wanted) {
  std::set<std::string> found;
  std::ifstream table("/proc/self/net/udp");
  const std::string ending = fmt::format(":{:04X}", port);
  for (std::string line; std::getline(table, line);) {
    std::istringstream words(line);
    const std::vector<std::string> word{std::istream_iterator<std::string>(words), {}};
    if (word.size() > wanted && word[1].ends_with(ending)) found.insert(word[wanted]);
  }
  return found;
}

}  // namespace

std::optional<bool> HasUdpPort(pid_t pid, std::uint16_t port) {
  constexpr std::size_t kInode = 9;
  std::set<std::string> links;
  for (const std::string& inode : FindInUdpTable(port, kInode)) links.insert(fmt::format("socket:[{}]", inode));
  std::error_code error;
  const std::filesystem::path folder = fmt::format("/proc/{}/fd", pid);
  for (std::filesystem::directory_iterator file(folder, error), end; !error && file != end; file.increment(error)) {
    std::error_code closed_meanwhile;
    if (links.count(std::filesystem::read_symlink(file->path(), closed_meanwhile)) > 0) return true;
  }
  return error ? std::nullopt : std::optional(false);
}

std::optional<uid_t> FindUdpUser(std::uint16_t port) {
  constexpr std::size_t kUser = 7;
  const std::set<std::string> users = FindInUdpTable(port, kUser);
  return users.size() == 1 ? ParseNumber<uid_t>(*users.begin()) : std::nullopt;
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
