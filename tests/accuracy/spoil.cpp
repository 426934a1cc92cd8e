#include "accuracy/spoil.hpp"

#include <functional>
#include <map>
#include <stdexcept>
#include <utility>

#include "common/math/random.hpp"

namespace crsm {
namespace {

using Scans = std::vector<LaserScan>;

template <class Item>
void Shuffle(std::vector<Item>& items, Random& random) {
  for (std::size_t i = items.size(); i > 1; --i) {
    std::swap(items[i - 1], items[random.Next() % i]);
  }
}

void ScaleAngles(Scans& scans, float factor) {
  for (LaserScan& scan : scans) {
    scan.angle_min_rad *= factor;
    scan.angle_step_rad *= factor;
  }
}

void KeepEvery(Scans& scans, std::size_t step) {
  Scans kept;
  for (std::size_t i = 0; i < scans.size(); i += step) kept.push_back(scans[i]);
  scans = std::move(kept);
}

void ShuffleBeams(Scans& scans) {
  Random random(1);
  for (LaserScan& scan : scans) Shuffle(scan.ranges_m, random);
}

void AddNoise(Scans& scans, double deviation_m) {
  Random random(1);
  for (LaserScan& scan : scans) {
    for (float& range_m : scan.ranges_m) {
      if (range_m > 0.0f) range_m += static_cast<float>(deviation_m * random.Gaussian());
    }
  }
}

void ToMillimetres(Scans& scans) {
  for (LaserScan& scan : scans) {
    for (float& range_m : scan.ranges_m) range_m *= 1000.0f;
  }
}

const std::map<std::string, std::function<void(Scans&)>>& Ways() {
  static const std::map<std::string, std::function<void(Scans&)>> ways{
      {"angles in degrees", [](Scans& scans) { ScaleAngles(scans, 57.29578f); }},
      {"half the angles", [](Scans& scans) { ScaleAngles(scans, 0.5f); }},
      {"beams shuffled", ShuffleBeams},
      {"ranges in mm", ToMillimetres},
      {"ranges +- 0.3 m", [](Scans& scans) { AddNoise(scans, 0.3); }},
      {"every 20th scan", [](Scans& scans) { KeepEvery(scans, 20); }},
      {"scans shuffled",
       [](Scans& scans) {
         Random random(1);
         Shuffle(scans, random);
       }},
  };
  return ways;
}

}  // namespace

std::vector<std::string> WaysToSpoil() {
  std::vector<std::string> names;
  for (const auto& [name, spoil] : Ways()) names.push_back(name);
  return names;
}

Recording Spoil(Recording recording, const std::string& way) {
  const auto found = Ways().find(way);
  if (found == Ways().end()) throw std::invalid_argument("no way to spoil scans: " + way);
  found->second(recording.scans);
  return recording;
}

}  // namespace crsm
