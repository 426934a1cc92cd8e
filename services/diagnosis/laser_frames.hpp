#pragma once

#include <cstdint>
#include <set>
#include <string>

namespace crsm {

/// The frames (frame_id) of the scans on one channel, by which several lasers on it are told apart.
class LaserFrames {
 public:
  static constexpr std::int64_t kEnough = 50;  ///< scans, of which each of several lasers sends some

  /// wanted: of the laser to use; empty where there is only one.
  explicit LaserFrames(const std::string& wanted = "");

  const std::string& wanted() const { return wanted_; }

  /// frame: of the next scan; empty where it names none. Whether the scan is to be used.
  bool Take(const std::string& frame);

  std::int64_t num_scans() const { return num_scans_; }

  /// Whether more scans would hardly tell more.
  bool AreKnown() const { return num_scans_ >= kEnough && (wanted_.empty() || frames_.count(wanted_) > 0); }

  /// What is wrong so far, and what mends it: several lasers where none is wanted, or no scan of the one that is. Empty
  /// if nothing is.
  std::string Complaint() const;

 private:
  std::string wanted_;
  std::set<std::string> frames_;
  std::int64_t num_scans_ = 0;
};

}  // namespace crsm
