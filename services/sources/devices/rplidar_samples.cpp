#include "services/sources/devices/rplidar_samples.hpp"

#include <algorithm>
#include <cmath>

#include "common/math/trigonometry.hpp"
#include "services/wire/polar_grid.hpp"

namespace crsm {
namespace {

/// By how much clockwise angle `to` lies behind `from`, [-180, 180) deg.
double AngleBetween(double from_deg, double to_deg) {
  const double turn = std::fmod(to_deg - from_deg + 540.0, 360.0);
  return (turn < 0.0 ? turn + 360.0 : turn) - 180.0;
}

/// Samples are some tenths of a degree to some degrees apart; their angles may jitter a little.
bool IsStep(double step_deg) { return step_deg > -5.0 && step_deg < 30.0; }

}  // namespace

/// The start bit and its inverse, and the check bit.
bool RplidarSamples::IsSample(std::size_t begin) const {
  const auto first = static_cast<unsigned char>(bytes_[begin]);
  const auto second = static_cast<unsigned char>(bytes_[begin + 1]);
  return ((first ^ (first >> 1)) & 1) == 1 && (second & 1) == 1 && SampleAt(begin).angle_deg < 360.0 + 1.0;
}

RplidarSamples::Sample RplidarSamples::SampleAt(std::size_t begin) const {
  const auto Byte = [&](std::size_t i) { return static_cast<unsigned>(static_cast<unsigned char>(bytes_[begin + i])); };
  const unsigned angle_q6 = (Byte(1) >> 1) | Byte(2) << 7;
  const unsigned range_q2 = Byte(3) | Byte(4) << 8;
  return {(Byte(0) & 1) == 1, angle_q6 / 64.0, static_cast<float>(range_q2 / 4000.0)};
}

bool RplidarSamples::Follows(const Sample& sample) const {
  return IsStep(AngleBetween(last_angle_deg_, sample.angle_deg));
}

/// Throws away bytes up to where five samples follow from each other. False if more must come to tell.
bool RplidarSamples::FindSync() {
  constexpr std::size_t kNumSamples = 5;
  std::size_t begin = 0;
  for (; begin + kNumSamples * kBytes <= bytes_.size(); ++begin) {
    bool found = true;
    for (std::size_t i = 0; i < kNumSamples && found; ++i) {
      const std::size_t at = begin + i * kBytes;
      found = IsSample(at) && (i == 0 || IsStep(AngleBetween(SampleAt(at - kBytes).angle_deg, SampleAt(at).angle_deg)));
    }
    if (found) break;
  }
  bytes_.erase(0, begin);
  in_sync_ = bytes_.size() >= kNumSamples * kBytes;
  if (in_sync_) last_angle_deg_ = SampleAt(0).angle_deg;
  return in_sync_;
}

/// Of the samples of the turn that is under way.
double RplidarSamples::ComputeTurned_deg() const {
  double turned_deg = 0.0;
  for (std::size_t i = 1; i < turn_.size(); ++i) turned_deg += AngleBetween(turn_[i - 1].angle_deg, turn_[i].angle_deg);
  return turned_deg;
}

/// Where the damage begins with the start of the next turn, this one is whole all the same.
void RplidarSamples::LoseSync(std::vector<DeviceScan>& scans) {
  in_sync_ = false;
  if (whole_) ++report_.counts["bad_turn"];
  const double turned_deg = ComputeTurned_deg();
  const double steps = static_cast<double>(turn_.size()) - 1.0;
  if (turned_deg + 1.5 * turned_deg / std::max(1.0, steps) > 360.0) EndTurn(scans);
  whole_ = false;
  clock_restarted_ = true;  // nobody knows how many samples are lost
}

void RplidarSamples::Take(std::string_view bytes, std::vector<DeviceScan>& scans) {
  bytes_ += bytes;
  std::size_t used = 0;
  while (true) {
    if (!in_sync_) {
      bytes_.erase(0, used);
      used = 0;
      if (!FindSync()) return;
    }
    if (used + kBytes > bytes_.size()) break;
    const Sample sample = SampleAt(used);
    if (IsSample(used) && Follows(sample)) {
      Add(sample, scans);
      used += kBytes;
    } else {
      LoseSync(scans);
    }
  }
  bytes_.erase(0, used);
}

void RplidarSamples::Add(const Sample& sample, std::vector<DeviceScan>& scans) {
  constexpr std::size_t kMostSamples = 65536;  // a motor that stands still has no turns
  if (sample.starts_turn) {
    EndTurn(scans);
    whole_ = true;
  }
  ++num_samples_;
  last_angle_deg_ = sample.angle_deg;
  if (turn_.size() < kMostSamples) turn_.push_back(sample);
}

void RplidarSamples::EndTurn(std::vector<DeviceScan>& scans) {
  const double turned_deg = ComputeTurned_deg();
  std::vector<Sample> turn;
  turn.swap(turn_);
  if (!whole_) return;
  if (turned_deg < 300.0 || turned_deg > 370.0) {
    ++report_.counts["bad_turn"];
    return;
  }
  PolarGrid grid(turn.front().angle_deg * kPi / 180.0);
  for (const Sample& sample : turn) grid.Add(sample.angle_deg * kPi / 180.0, sample.range_m);
  DeviceScan scan{grid.TakeScan(), num_samples_ * sample_us_, clock_restarted_,
                  1e-6 * sample_us_ * static_cast<double>(turn.size())};
  clock_restarted_ = false;
  scans.push_back(std::move(scan));
}

}  // namespace crsm
