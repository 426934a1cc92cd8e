#include "common/math/nearest_name.hpp"

#include <algorithm>
#include <cctype>
#include <numeric>
#include <utility>

namespace crsm {
namespace {

bool AreSame(char a, char b) {
  return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
}

}  // namespace

std::size_t EditDistance(std::string_view a, std::string_view b) {
  // Each row: distances of the first letters of `a` to the first 0, 1, 2 ... letters of `b`.
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  std::vector<std::size_t> last = row;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    const std::vector<std::size_t> before_last = std::exchange(last, row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = last[j - 1] + (AreSame(a[i - 1], b[j - 1]) ? 0 : 1);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, replaced});
      const bool swapped = i > 1 && j > 1 && AreSame(a[i - 1], b[j - 2]) && AreSame(a[i - 2], b[j - 1]);
      if (swapped) row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
  }
  return row.back();
}

std::string FindNearestName(std::string_view text, const std::vector<std::string>& names) {
  constexpr std::size_t kLongest = 100;  // letters: who types more has not mistyped a name
  if (text.empty() || text.size() > kLongest) return "";
  std::string nearest;
  std::size_t least = text.size() / 3 + 1;
  for (const std::string& name : names) {
    if (name.size() >= text.size() + least) continue;
    const std::size_t distance = EditDistance(text, name);
    if (distance >= least) continue;
    least = distance;
    nearest = name;
  }
  return nearest;
}

std::string SuggestName(std::string_view text, const std::vector<std::string>& names, std::string_view before) {
  const std::string nearest = FindNearestName(text, names);
  return nearest.empty() ? "" : "; did you mean " + std::string(before) + nearest + "?";
}

}  // namespace crsm
