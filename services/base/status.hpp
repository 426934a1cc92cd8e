#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace crsm {

/// What a process counts: messages handled and each kind of trouble, by name.
class Counters {
 public:
  void Add(const std::string& name, std::int64_t count = 1) { counts_[name] += count; }
  void Set(const std::string& name, std::int64_t count) { counts_[name] = count; }
  const std::map<std::string, std::int64_t>& counts() const { return counts_; }

 private:
  std::map<std::string, std::int64_t> counts_;
};

/// Time spent on one message: percentiles over the last 1,024, and the longest of all.
class Latency {
 public:
  void Record(double latency_ms);

  std::int64_t num_recorded() const { return num_recorded_; }
  /// The latency that `share` of the last ones stay below [ms]; 0 before the first.
  double Percentile(double share) const;
  double max_ms() const { return max_ms_; }

 private:
  std::array<double, 1024> recent_ms_{};
  std::int64_t num_recorded_ = 0;
  double max_ms_ = 0.0;
};

}  // namespace crsm
