#pragma once

#include <functional>
#include <initializer_list>
#include <utility>
#include <vector>

#include "common/scan/scan_match.hpp"

namespace crsm {

/// The matches of a run in order of arrival: a list, or something on the disk that can be gone through again and again.
class MatchSequence {
 public:
  using Visit = std::function<void(const ScanMatch&)>;

  MatchSequence(std::vector<ScanMatch> matches = {})
      : for_each_([matches = std::move(matches)](const Visit& visit) {
          for (const ScanMatch& match : matches) visit(match);
        }) {}
  MatchSequence(std::initializer_list<ScanMatch> matches) : MatchSequence(std::vector<ScanMatch>(matches)) {}

  /// for_each: calls a function with each match.
  explicit MatchSequence(std::function<void(const Visit&)> for_each) : for_each_(std::move(for_each)) {}

  void ForEach(const Visit& visit) const { for_each_(visit); }

 private:
  std::function<void(const Visit&)> for_each_;
};

}  // namespace crsm
