#include "services/sources/bags/bag_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "common/math/nearest_name.hpp"
#include "services/base/printable.hpp"
#include "services/sources/bags/bag_odometry.hpp"
#include "services/sources/bags/decompress.hpp"
#include "services/sources/bags/scan_messages.hpp"

namespace crsm {
namespace {

using Topics = std::set<BagTopic>;

/// Why topics may be missing; empty where the bag is whole.
std::string DescribeDamage(const std::string& path) {
  const auto bag = OpenBag(path, [](const BagTopic&) { return false; });
  while (bag->Next()) continue;
  if (const auto num = bag->damage().num_bad_chunks; num > 0) {
    return fmt::format("; {} parts of it are damaged, and what stood in them is not known", num);
  }
  return bag->damage().truncated ? "; it is cut short or damaged at its end" : "";
}

/// Those that have a message; all where none has. Recorders declare topics on which nothing is sent.
Topics WithMessages(const std::string& path, Topics topics) {
  const auto bag = OpenBag(path, [&](const BagTopic& topic) { return topics.count(topic) > 0; });
  std::set<std::string> names;
  while (names.size() < topics.size()) {
    const auto message = bag->Next();
    if (!message) break;
    names.insert(message->topic);
  }
  if (!names.empty()) std::erase_if(topics, [&](const BagTopic& topic) { return names.count(topic.name) == 0; });
  return topics;
}

BagTopic ChooseLaser(const std::string& path, const Topics& topics, const std::string& name) {
  Topics lasers;
  std::vector<std::string> others;
  for (const BagTopic& topic : topics) {
    if (!IsLaserTopic(topic)) continue;
    if (name.empty() || topic.name == name) {
      lasers.insert(topic);
    } else {
      others.push_back(topic.name);
    }
  }
  if (lasers.empty()) {
    throw std::runtime_error(fmt::format("{} has no laser topic ({}){}; its topics: {}{}{}", path, LaserTopicTypes(),
                                         name.empty() ? "" : " named " + name, ListTopics(topics), DescribeDamage(path),
                                         MakePrintable(SuggestName(name, others))));
  }
  if (lasers.size() > 1) lasers = WithMessages(path, std::move(lasers));
  if (lasers.size() > 1) {
    throw std::runtime_error(fmt::format(
        "{} has several laser topics: --laser-channel must name one of {}; slam_offline maps several robots by "
        "'--laser-channel A,B'",
        path, ListTopics(lasers)));
  }
  return *lasers.begin();
}

}  // namespace

BagSource::BagSource(const std::string& path, const LaserChoice& laser, const std::string& odometry,
                     const ScanParameters& parameters)
    : BagSource(path, FindTopics(path), laser, odometry, parameters) {}

BagSource::BagSource(const std::string& path, const Topics& topics, const LaserChoice& laser,
                     const std::string& odometry, const ScanParameters& parameters)
    : laser_(ChooseLaser(path, topics, laser.channel)),
      laser_parameters_(parameters),
      frames_(laser.frame),
      odometry_(std::make_unique<BagOdometry>(path, topics, BagLaser{laser_, frames_.wanted()}, odometry)),
      bag_(OpenBag(path, [this](const BagTopic& met) { return met == laser_ || odometry_->Wants(met); })) {
  StudyFirstScans(path, laser.frame);
}

BagSource::~BagSource() = default;

/// Reads ahead. Throws where the first scans are of several lasers, or none of the bag is of the one that is wanted.
void BagSource::StudyFirstScans(const std::string& path, const std::string& wanted) {
  LaserFrames frames(wanted);
  const auto bag = OpenBag(path, [this](const BagTopic& topic) { return topic == laser_; });
  while (!frames.AreKnown()) {
    const auto message = bag->Next();
    if (!message) break;
    const PlainMessage plain(message->data);
    const DecodedScan decoded = DecodeScan(laser_, plain.data(), laser_parameters_);
    if (decoded.scan && frames.Take(decoded.frame)) clock_.Study(*decoded.scan);
  }
  const std::string complaint = frames.Complaint();
  if (!complaint.empty()) throw std::runtime_error(fmt::format("{}: {}: {}", path, laser_.name, complaint));
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
  const PlainMessage plain(message.data);
  if (message.topic == laser_.name) return TakeScan(plain.data());
  if (const auto num_bad = odometry_->Take(message.topic, plain.data(), scans_)) counts_["bad_odometry"] += num_bad;
}

void BagSource::TakeScan(std::string_view data) {
  DecodedScan decoded = DecodeScan(laser_, data, laser_parameters_);
  const bool names_frame = decoded.scan || !decoded.frame.empty();
  if (names_frame && !frames_.Take(decoded.frame)) {
    ++counts_["other_frame"];
    return;
  }
  if (!decoded.scan) {
    ++counts_["bad_message"];
    if (first_refusal_.empty()) first_refusal_ = decoded.refusal;
    return;
  }
  if (thinned_.empty()) thinned_ = decoded.thinned;
  if (contradiction_.empty()) contradiction_ = decoded.contradiction;
  const auto utime = clock_.TimeOf(*decoded.scan);
  decoded.scan->utime = utime.value_or(decoded.scan->utime);
  if (!utime || !scans_.Add(std::move(*decoded.scan))) ++counts_["utime_repeated"];
}

std::map<std::string, std::int64_t> BagSource::Counts() const {
  std::map<std::string, std::int64_t> counts = counts_;
  const BagDamage damage = bag_->damage();
  counts["bad_chunk"] = damage.num_bad_chunks;
  counts["truncated"] = damage.truncated ? 1 : 0;
  return counts;
}

bool BagSource::IsUpsideDown() const { return odometry_->laser_is_upside_down(); }

std::string BagSource::OdometryName() const { return odometry_->Describe(); }

std::vector<std::string> BagSource::OdometryNotes() const { return odometry_->Notes(scans_); }

std::vector<std::string> BagSource::Complaints() const {
  std::vector<std::string> complaints = scans_.Complaints(laser_.name, Counts(), first_refusal_, "header.stamp");
  for (const std::string& complaint :
       {frames_.Complaint(), thinned_, contradiction_, clock_.Complaint("header.stamp")}) {
    if (!complaint.empty()) complaints.push_back(fmt::format("{}: {}", laser_.name, complaint));
  }
  if (const auto num = bag_->damage().num_bad_chunks; num > 0) {
    complaints.push_back(fmt::format("{} chunks are damaged; their messages are left out", num));
  }
  return complaints;
}

}  // namespace crsm
