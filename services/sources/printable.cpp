#include "services/sources/printable.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace crsm {

std::string ListPrintable(const std::vector<std::string>& names) {
  constexpr std::size_t kMostListed = 20;
  constexpr std::size_t kLongest = 200;
  if (names.empty()) return "none";
  std::vector<std::string> listed;
  for (std::size_t i = 0; i < std::min(names.size(), kMostListed); ++i) {
    std::string name = names[i].substr(0, kLongest);
    std::replace_if(
        name.begin(), name.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
    listed.push_back(std::move(name));
  }
  if (names.size() > kMostListed) listed.push_back(fmt::format("and {} more", names.size() - kMostListed));
  return fmt::format("{}", fmt::join(listed, ", "));
}

}  // namespace crsm
