#include "services/map_viewer/join_news.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

namespace crsm {
namespace {

/// By trajectory, from the one on that the first break has ended.
std::vector<int> ListPieces(const MapPieces& pieces) {
  if (pieces.breaks.empty()) return {1};
  std::vector<int> numbers{pieces.breaks.front().piece_before};
  for (const Break& at : pieces.breaks) numbers.push_back(at.piece);
  return numbers;
}

std::vector<int> FindOldest(const std::vector<int>& numbers) {
  std::vector<int> oldest;
  for (const int number : numbers) {
    oldest.push_back(static_cast<int>(std::ranges::find(numbers, number) - numbers.begin()));
  }
  return oldest;
}

}  // namespace

std::string DescribeFloating(std::int64_t trajectory) {
  return fmt::format("floating: not joined to the map yet (trajectory {})", trajectory);
}

std::vector<std::string> JoinNews::Look(const MapPieces& pieces) {
  const std::vector<int> numbers = ListPieces(pieces);
  const std::vector<int> told = std::exchange(components_, FindOldest(numbers));
  const std::int64_t first = pieces.num_breaks - std::ssize(pieces.breaks);
  const bool goes_on = !told.empty() && told.size() <= components_.size() && first == first_;
  first_ = first;
  if (!goes_on) return {};
  std::vector<std::string> news;
  for (int i = 0; i < std::ssize(components_); ++i) {
    const auto index = static_cast<std::size_t>(i);
    const bool is_new = index >= told.size();
    const bool was_joined = !is_new && told[index] != i;
    const bool is_joined = components_[index] != i;
    const bool is_on_map = numbers[index] == 1;
    if (is_joined && !was_joined) {
      news.push_back(is_on_map ? fmt::format("joined: trajectory {} with the map", first + i)
                               : fmt::format("joined: trajectory {} with trajectory {}, both float", first + i,
                                             first + components_[index]));
    } else if (was_joined && !is_joined) {
      news.push_back(fmt::format("a join was rejected: trajectory {} is a part of its own again", first + i));
    } else if (is_new && !is_on_map) {
      news.push_back(DescribeFloating(first + i));
    }
  }
  return news;
}

}  // namespace crsm
