#include "services/base/printable.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace crsm {

std::string MakePrintable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return text;
}

std::string ListPrintable(const std::vector<std::string>& names) {
  constexpr std::size_t kMostListed = 20;
  constexpr std::size_t kLongest = 200;
  if (names.empty()) return "none";
  std::vector<std::string> listed;
  for (std::size_t i = 0; i < std::min(names.size(), kMostListed); ++i) {
    listed.push_back(MakePrintable(names[i].substr(0, kLongest)));
  }
  if (names.size() > kMostListed) listed.push_back(fmt::format("and {} more", names.size() - kMostListed));
  return fmt::format("{}", fmt::join(listed, ", "));
}

}  // namespace crsm
