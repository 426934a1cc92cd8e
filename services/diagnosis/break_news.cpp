#include "services/diagnosis/break_news.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace crsm {
namespace {

std::string DescribeCause(const Break& at) {
  switch (at.reason) {
    case BreakReason::kLost:
      return fmt::format("lost for {:.1f} s", at.seconds);
    case BreakReason::kGap:
      return fmt::format("no scan came for {:.1f} s", at.seconds);
    case BreakReason::kClock:
      return fmt::format("the clock went back by {:.1f} s", at.seconds);
    case BreakReason::kSession:
      return "another session";
  }
  return "";
}

}  // namespace

std::string DescribeBreak(const Break& at) {
  return fmt::format("scan {}: {}: {}", at.scan, DescribeCause(at), kNewTrajectory);
}

void BreakNews::Skip(const Mapper& mapper) { components_ = mapper.best_components(); }

std::vector<std::string> BreakNews::Look(const Mapper& mapper, Clock::time_point now) {
  if (mapper.best_components() == components_) return {};
  std::vector<std::string> lines;
  for (std::string& line : FindNews(mapper)) {
    if (auto passed = limit_.Pass(std::move(line), now)) lines.push_back(std::move(*passed));
  }
  return lines;
}

std::vector<std::string> BreakNews::FindNews(const Mapper& mapper) {
  std::vector<std::string> news;
  const std::vector<int>& components = mapper.best_components();
  for (int i = static_cast<int>(components_.size()); i < std::ssize(components); ++i) {
    if (i > 0) news.push_back(DescribeBreak(mapper.trajectories().at(i).start));
    components_.push_back(i);  // as a component of its own
  }
  for (int i = 0; i < std::ssize(components); ++i) {
    int& told = components_[static_cast<std::size_t>(i)];
    const int now = components[static_cast<std::size_t>(i)];
    const std::int64_t scan = mapper.trajectories().at(i).start.scan;
    if (told == i && now != i) {
      news.push_back(fmt::format("{}{} on is joined with an older part of the map", kMappedFrom, scan));
    } else if (told != i && now == i) {
      news.push_back(fmt::format("{}{} on is a part of its own again: a join was rejected", kMappedFrom, scan));
    }
    told = now;
  }
  return news;
}

}  // namespace crsm
