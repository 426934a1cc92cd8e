#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace crsm {

struct BagTopic {
  std::string name;
  std::string type;      ///< "sensor_msgs/LaserScan"
  std::string encoding;  ///< of its messages: "ros1", "cdr", "json", ...

  friend auto operator<=>(const BagTopic&, const BagTopic&) = default;
};

struct BagMessage {
  std::string topic;
  std::string_view data;  ///< valid until the next call; empty if it is longer than kMostMessageBytes
};

/// A message of a laser or of wheels has a tenth of it.
inline constexpr std::size_t kMostMessageBytes = std::size_t{1} << 20;

/// What was wrong with a bag so far.
struct BagDamage {
  std::int64_t num_bad_chunks = 0;  ///< parts of it that could not be read, passed over
  bool truncated = false;           ///< it ends before its end: the recording was killed, or the file is cut or damaged
};

/// Whether the messages of a topic are to be read: asked for each topic when it is first met, perhaps more than once.
using WantTopic = std::function<bool(const BagTopic&)>;

/// The messages of a recording, in the order in which they stand in it. Of messages that nobody wants, and of chunks
/// that are over, nothing stays in memory.
class BagReader {
 public:
  virtual ~BagReader() = default;

  /// All topics, where the bag lists them; nothing where it must be read as a whole to know.
  virtual std::optional<std::vector<BagTopic>> ListedTopics() = 0;

  /// The next message that is wanted; nothing at the end. Throws std::runtime_error if the disk does not give it.
  virtual std::optional<BagMessage> Next() = 0;

  virtual double Progress() const = 0;  ///< [0, 1]
  virtual BagDamage damage() const = 0;
};

/// Whether a file begins as a bag of any kind does.
bool IsBag(std::string_view start);

/// Opens a bag, of which kind its content tells: a ROS 1 bag, an MCAP file, or rosbag2's SQLite database, also
/// compressed as a whole. Throws
/// std::runtime_error, one line, if it is none or cannot be opened.
std::unique_ptr<BagReader> OpenBagFile(const std::string& path, const WantTopic& want);

/// The same, or a folder of rosbag2: its files one after the other.
std::unique_ptr<BagReader> OpenBag(const std::string& path, const WantTopic& want);

/// All topics of a bag: as it lists them, or else from all that is in it. At most 10,000, and none whose name or type
/// is longer than any real one.
std::set<BagTopic> FindTopics(const std::string& path);

/// Topics for people: "/scan (sensor_msgs/LaserScan in ros1), ..."; "none" of none.
std::string ListTopics(const std::set<BagTopic>& topics);

}  // namespace crsm
