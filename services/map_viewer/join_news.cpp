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

/// Whether nothing of what was piece 1 is on it any more. before, now: by trajectory, numbers of pieces.
bool IsAnotherPieceShown(const std::vector<int>& before, const std::vector<int>& now) {
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (before[i] == 1 && now[i] == 1) return false;
  }
  return std::ranges::count(before, 1) > 0;
}

}  // namespace

bool IsFirstElsewhere(const MapPieces& pieces) { return ListPieces(pieces).front() != 1; }

std::string Describe(const JoinEvent& event, const std::function<std::string(std::int64_t trajectory)>& name) {
  using Kind = JoinEvent::Kind;
  const std::string it = name(event.trajectory);
  switch (event.kind) {
    case Kind::kAnotherPiece:
      return fmt::format("another piece is the larger one now and is shown ({}); the one before floats", it);
    case Kind::kJoined:
      return fmt::format("joined: {} with the map", it);
    case Kind::kJoinedFloating:
      return fmt::format("joined: {} with {}, both float", it, name(event.other));
    case Kind::kRejected:
      return fmt::format("a join was rejected: {} is a part of its own again", it);
    case Kind::kFloats:
      return fmt::format("floating: not joined to the map yet ({})", it);
  }
  return "";
}

std::vector<std::string> Describe(const std::vector<JoinEvent>& events) {
  std::vector<std::string> lines;
  for (const JoinEvent& event : events) lines.push_back(Describe(event));
  return lines;
}

std::vector<JoinEvent> JoinNews::Look(const MapPieces& pieces) {
  using Kind = JoinEvent::Kind;
  const std::vector<int> before = std::exchange(numbers_, ListPieces(pieces));
  const std::vector<int>& numbers = numbers_;
  const std::int64_t first = pieces.num_breaks - std::ssize(pieces.breaks);
  const bool goes_on = !before.empty() && before.size() <= numbers.size() && first == first_;
  first_ = first;
  if (!goes_on) return {};
  const std::vector<int> told = FindOldest(before);
  const std::vector<int> components = FindOldest(numbers);
  std::vector<JoinEvent> news;
  if (IsAnotherPieceShown(before, numbers)) {
    news.push_back({Kind::kAnotherPiece, first + (std::ranges::find(numbers, 1) - numbers.begin())});
  }
  for (int i = 0; i < std::ssize(components); ++i) {
    const auto index = static_cast<std::size_t>(i);
    const bool is_new = index >= told.size();
    const bool was_joined = !is_new && told[index] != i;
    const bool is_joined = components[index] != i;
    const bool is_on_map = numbers[index] == 1;
    if (is_joined && !was_joined) {
      news.push_back({is_on_map ? Kind::kJoined : Kind::kJoinedFloating, first + i, first + components[index]});
    } else if (was_joined && !is_joined) {
      news.push_back({Kind::kRejected, first + i});
    } else if (is_new && !is_on_map) {
      news.push_back({Kind::kFloats, first + i});
    }
  }
  return news;
}

}  // namespace crsm
