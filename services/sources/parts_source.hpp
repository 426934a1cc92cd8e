#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/logs/laser_source.hpp"

namespace crsm {

/// Whether a path has * or ?, which stand for parts of a name.
bool IsPattern(const std::string& path);

/// The files that a pattern with * and ? stands for, in the order of their names, where 9 comes before 10. Throws
/// std::runtime_error that names the pattern if there are none.
std::vector<std::string> FindParts(const std::string& pattern);

/// A log that its recorder has split: one part after the other, as if they were one, of one laser. Where the first
/// parts are younger than those behind them, as lcm-logger --rotate numbers them, they are read from the last to the
/// first.
class PartsSource : public LaserSource {
 public:
  /// channel: of the parts before, as LaserSource has it; empty for the first.
  using Open = std::function<std::unique_ptr<LaserSource>(const std::string& path, const std::string& channel)>;

  /// Throws as `open` does where no part can be read.
  PartsSource(std::vector<std::string> paths, Open open);

  std::optional<LaserScan> Next() override;
  std::optional<Pose2> Odometry() const override { return part_->Odometry(); }
  std::string OdometryName() const override { return part_->OdometryName(); }
  bool IsUpsideDown() const override { return is_upside_down_; }
  double Progress() const override;
  std::map<std::string, std::int64_t> Counts() const override;
  std::vector<std::string> Complaints() const override;
  std::vector<std::string> OdometryNotes() const override { return part_->OdometryNotes(); }

 private:
  void SortByTime();
  void OpenNext();

  std::vector<std::string> paths_;
  Open open_;
  std::string channel_;
  std::unique_ptr<LaserSource> part_;
  std::size_t num_opened_ = 0;
  bool is_upside_down_ = false;  ///< by a part so far: the static TF of a bag may stand in its first part alone
  std::map<std::string, std::int64_t> counts_;  ///< of parts that have been read
  std::vector<std::string> complaints_;         ///< likewise
};

}  // namespace crsm
