#include "services/sources/bags/bag_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <stdexcept>

#include "services/runtime/printable.hpp"
#include "services/sources/bags/decompress.hpp"
#include "services/sources/bags/scan_messages.hpp"

namespace crsm {
namespace {

using Topics = std::set<BagTopic>;

std::string List(const Topics& topics) {
  std::vector<std::string> entries;
  for (const BagTopic& topic : topics)
    entries.push_back(fmt::format("{} ({} in {})", topic.name, topic.type, topic.encoding));
  return ListPrintable(entries);
}

Topics Select(const Topics& topics, bool (*is)(const BagTopic&)) {
  Topics selected;
  std::copy_if(topics.begin(), topics.end(), std::inserter(selected, selected.end()), is);
  return selected;
}

BagTopic ChooseLaser(const std::string& path, const Topics& topics, const std::string& name) {
  Topics lasers = Select(topics, IsLaserTopic);
  if (!name.empty()) std::erase_if(lasers, [&](const BagTopic& topic) { return topic.name != name; });
  if (lasers.empty()) {
    throw std::runtime_error(fmt::format("{} has no laser topic ({}){}; its topics: {}", path, LaserTopicTypes(),
                                         name.empty() ? "" : " named " + name, List(topics)));
  }
  if (lasers.size() > 1) {
    throw std::runtime_error(
        fmt::format("{} has several laser topics: --laser-channel must name one of {}", path, List(lasers)));
  }
  return *lasers.begin();
}

/// "/robot1/odom" for "/robot1/scan".
std::string OdometryBeside(const std::string& laser) { return laser.substr(0, laser.rfind('/') + 1) + "odom"; }

std::optional<BagTopic> ChooseOdometry(const Topics& odometries, const std::string& laser) {
  if (odometries.size() == 1) return *odometries.begin();
  const auto beside = std::find_if(odometries.begin(), odometries.end(),
                                   [&](const BagTopic& topic) { return topic.name == OdometryBeside(laser); });
  return beside == odometries.end() ? std::nullopt : std::optional(*beside);
}

}  // namespace

BagSource::BagSource(const std::string& path, const std::string& topic) {
  const Topics topics = FindTopics(path);
  laser_ = ChooseLaser(path, topics, topic);
  const Topics odometries = Select(topics, IsOdometryTopic);
  odometry_ = ChooseOdometry(odometries, laser_.name);
  if (!odometry_ && !odometries.empty()) {
    odometry_choice_ = fmt::format("no odometry is used: there is no topic {}, and several topics could be meant: {}",
                                   OdometryBeside(laser_.name), List(odometries));
  }
  bag_ = OpenBag(path, [this](const BagTopic& met) { return met == laser_ || met == odometry_; });
}

std::optional<LaserScan> BagSource::Next() {
  while (!scans_.NextIsReady()) {
    const auto message = bag_->Next();
    if (!message) break;
    Take(*message);
  }
  return scans_.Next();
}

void BagSource::Take(const BagMessage& message) {
  std::string_view data = message.data;
  std::unique_ptr<MemoryRange> unpacked;  // rosbag2 may compress each message
  if (const std::size_t size = SizeOfZstdMessage(data)) {
    unpacked = Decompress({"zstd", data, size});
    data = unpacked ? unpacked->All() : std::string_view();
  }
  if (message.topic == laser_.name) return TakeScan(data);
  if (const auto odometry = DecodeOdometry(*odometry_, data)) {
    scans_.Add(*odometry);
  } else {
    ++counts_["bad_odometry"];
  }
}

void BagSource::TakeScan(std::string_view data) {
  DecodedScan decoded = DecodeScan(laser_, data);
  if (!decoded.scan) {
    ++counts_["bad_message"];
    if (first_refusal_.empty()) first_refusal_ = decoded.refusal;
    return;
  }
  if (!scans_.Add(std::move(*decoded.scan))) ++counts_["utime_repeated"];
}

std::map<std::string, std::int64_t> BagSource::Counts() const {
  std::map<std::string, std::int64_t> counts = counts_;
  const BagDamage damage = bag_->damage();
  counts["bad_chunk"] = damage.num_bad_chunks;
  counts["truncated"] = damage.truncated ? 1 : 0;
  return counts;
}

std::vector<std::string> BagSource::Complaints() const {
  std::vector<std::string> complaints = scans_.Complaints(laser_.name, Counts(), first_refusal_, "header.stamp");
  if (const auto num = bag_->damage().num_bad_chunks; num > 0) {
    complaints.push_back(fmt::format("{} chunks are damaged; their messages are left out", num));
  }
  if (!odometry_choice_.empty()) complaints.push_back(odometry_choice_);
  return complaints;
}

}  // namespace crsm
