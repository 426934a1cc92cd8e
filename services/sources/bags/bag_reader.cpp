#include "services/sources/bags/bag_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "services/base/printable.hpp"
#include "services/base/process.hpp"
#include "services/sources/bags/bag_folder.hpp"
#include "services/sources/bags/mcap_bag.hpp"
#include "services/sources/bags/ros1_bag.hpp"
#include "services/sources/bags/sqlite_bag.hpp"
#include "services/sources/unpacked_file.hpp"

namespace crsm {

bool IsBag(std::string_view start) { return Ros1Bag::Is(start) || McapBag::Is(start) || SqliteBag::Is(start); }

namespace {

std::unique_ptr<BagReader> OpenPlainBag(const std::string& path, const WantTopic& want) {
  constexpr std::size_t kStartBytes = 16;
  const std::string start(FileWindow(path).At(0, kStartBytes));
  if (Ros1Bag::Is(start)) return std::make_unique<Ros1Bag>(path, want);
  if (McapBag::Is(start)) return std::make_unique<McapBag>(path, want);
  if (SqliteBag::Is(start)) return std::make_unique<SqliteBag>(path, want);
  throw std::runtime_error(fmt::format("{} is neither a ROS 1 bag, nor MCAP, nor a database of rosbag2", path));
}

}  // namespace

std::unique_ptr<BagReader> OpenBagFile(const std::string& path, const WantTopic& want) {
  try {
    return OpenPlainBag(PathOfUnpacked(path, Say), want);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(NameUnpacked(error.what()));
  }
}

std::unique_ptr<BagReader> OpenBag(const std::string& path, const WantTopic& want) {
  if (std::filesystem::is_directory(path)) return std::make_unique<BagFolder>(path, want);
  return OpenBagFile(path, want);
}

std::set<BagTopic> FindTopics(const std::string& path) {
  constexpr std::size_t kMostTopics = 10000;
  constexpr std::size_t kLongest = 1000;
  std::set<BagTopic> topics;
  const auto add = [&topics](const BagTopic& topic) {
    const std::size_t longest = std::max({topic.name.size(), topic.type.size(), topic.encoding.size()});
    if (longest <= kLongest && topics.size() < kMostTopics) topics.insert(topic);
    return false;
  };
  const auto bag = OpenBag(path, add);
  if (const auto listed = bag->ListedTopics()) {
    std::for_each(listed->begin(), listed->end(), add);
  } else {
    while (bag->Next()) continue;
  }
  return topics;
}

std::string ListTopics(const std::set<BagTopic>& topics) {
  std::vector<std::string> entries;
  for (const BagTopic& topic : topics)
    entries.push_back(fmt::format("{} ({} in {})", topic.name, topic.type, topic.encoding));
  return ListPrintable(entries);
}

}  // namespace crsm
