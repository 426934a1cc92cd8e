#include "services/base/printable.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace crsm {

std::string MakePrintable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return text;
}

std::string WithoutControls(std::string text) {
  constexpr char kC1Lead = '\xc2';  // of the two bytes of a control character beyond ASCII
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : 'x');
    const bool is_c1 = text[i] == kC1Lead && next >= 0x80 && next < 0xa0;
    if (is_c1) text[i + 1] = '?';
    if (is_c1 || byte < ' ' || byte == 0x7f || (byte >= 0x80 && byte < 0xa0 && (i == 0 || text[i - 1] >= 0)))
      text[i] = '?';
  }
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
