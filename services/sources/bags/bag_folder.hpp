#pragma once

#include <memory>
#include <string>
#include <vector>

#include "services/sources/bags/bag_reader.hpp"

namespace crsm {

/// A folder that rosbag2 has recorded to: its files, one after the other, as metadata.yaml names them; where the
/// recording was killed there is no such file, and they go by the numbers in their names.
class BagFolder : public BagReader {
 public:
  /// Throws std::runtime_error if the folder has no recording, more than one, or one that is compressed by files.
  BagFolder(const std::string& path, WantTopic want);

  std::optional<std::vector<BagTopic>> ListedTopics() override;
  std::optional<BagMessage> Next() override;
  double Progress() const override;
  BagDamage damage() const override;

 private:
  std::vector<std::string> paths_;
  WantTopic want_;
  std::size_t next_ = 0;             ///< of paths_
  std::unique_ptr<BagReader> file_;  ///< the one before
  BagDamage damage_;                 ///< of those before it
};

/// Whether a folder looks like one of rosbag2.
bool IsBagFolder(const std::string& path);

}  // namespace crsm
