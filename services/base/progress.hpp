#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "services/base/process.hpp"

namespace crsm {

/// Shows how far a long work has come, on stderr: one line that rewrites itself on a terminal, else a line every five
/// seconds.
class Progress {
 public:
  explicit Progress(std::string program);

  /// share: of the work done, [0, 1]; asked only when it is time to show it.
  void Show(const std::function<double()>& share, std::int64_t num_scans);
  /// The last word.
  void Finish(std::int64_t num_scans);

 private:
  void Print(const std::string& text, bool last);

  std::string program_;
  bool terminal_;
  double share_ = 0.0;
  Clock::time_point start_ = Clock::now();
  Clock::time_point next_;
};

}  // namespace crsm
