#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "services/base/process.hpp"

namespace crsm {

/// How far a long work has come: "45 %, 1234 scans, 617 scans/s, 3 s left". columns: of the terminal on which it is one
/// line, with a bar where there is room; 0: it is for none. share: [0, 1]. Early on nobody knows how long it takes.
std::string FormatProgress(const std::string& program, double share, std::int64_t num_scans, double elapsed_s,
                           int columns);

/// Shows that on stderr: one line that rewrites itself on a terminal, else a line every five seconds.
class Progress {
 public:
  explicit Progress(std::string program);

  /// share: of the work done, [0, 1]; asked only when it is time to show it.
  void Show(const std::function<double()>& share, std::int64_t num_scans);
  /// The last word.
  void Finish(std::int64_t num_scans);

 private:
  std::string program_;
  bool terminal_;
  double share_ = 0.0;
  Clock::time_point start_ = Clock::now();
  Clock::time_point next_;
};

}  // namespace crsm
