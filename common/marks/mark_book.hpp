#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "common/graph/mapper.hpp"
#include "common/marks/mark.hpp"

namespace crsm {

/// A scan, by its number from 0, and how it was matched.
struct ScanAt {
  std::int64_t scan = 0;
  ScanMatch match;
};

/// Fixes a mark that is relative to the laser: between the scans before and after its time, or by the scan of that
/// time alone. Nothing where none of them was matched within half a second of it.
std::optional<FixedMark> FixByLaser(const Mark& mark, const std::optional<ScanAt>& before,
                                    const std::optional<ScanAt>& after, const Mapper& mapper);

/// Fixes a mark in the map's frame: each point to the keyframe nearest to it on the map that is shown.
FixedMark FixOnMap(const Mark& mark, const Mapper& mapper);

/// The places with names of a map. It is bounded, whoever sends marks.
///
/// Sightings of a point are fused: each counts by 1 / radius^2, where its keyframe has it by all that is known. Those
/// of one keyframe are kept as one, with their spread.
class MarkBook {
 public:
  static constexpr std::size_t kMostMarks = 200;           ///< those that were removed give way to new ones
  static constexpr std::size_t kMostOutlinePoints = 2000;  ///< of all outlines
  static constexpr std::size_t kMostGroups = 100;  ///< keyframes at which one place was seen: others tell nothing new
  static constexpr int kMostOfGroup = 50;          ///< sightings of it at one of them, likewise
  static constexpr std::int64_t kMostKept = 100'000;  ///< changes, of all sessions

  enum class Judgement {
    kNew,
    kKnown,      ///< it came before, or tells nothing new
    kRemoved,    ///< a sighting of a place that was removed
    kIsOutline,  ///< a sighting of an outline, or an outline of what is a point: only who moves it changes that
    kUnknown,    ///< to be removed, and not there
    kFull,
  };
  /// What Add would do with a mark without fault, before it is fixed, and then.
  Judgement Judge(const Mark& mark) const;
  Judgement Judge(const FixedMark& fixed) const;

  /// Takes a mark in, where it is kNew. False, and nothing is done, if it is fixed to a keyframe that the mapper does
  /// not have, or does not have as many fixed points as points.
  bool Add(const FixedMark& fixed, const Mapper& mapper);

  /// All places but those that were removed, in the order in which they came first, and those beyond
  /// Mark::kFarthest_m.
  std::vector<PlacedMark> Place(const Mapper& mapper) const;

  /// The same by the keyframes that they are fixed to, for a map with loops.
  std::vector<AnchoredMark> Anchor(const Mapper& mapper) const;

  bool empty() const { return entries_.empty(); }

 private:
  /// What was seen of a point at one keyframe: sums of the sightings in its frame, by their weights.
  struct Group {
    std::optional<KeyframeId> keyframe;
    int num = 0;
    double weight = 0.0;  ///< sum of 1 / radius^2
    Point mean = {};
    double spread = 0.0;  ///< sum of weight * squared distance from the mean
  };
  struct Entry {
    std::string id;
    std::string kind = {};
    std::string name = {};
    bool removed = false;
    std::int64_t utime = 0;                ///< of the newest
    std::vector<Group> groups = {};        ///< of a point
    std::vector<FixedPoint> outline = {};  ///< else
    double radius_m = 0.0;                 ///< of the outline
    std::deque<std::int64_t> utimes = {};  ///< of the newest changes
  };

  /// What can be fused, because it lies in one frame: that of the map that is shown, else that of the newest sighting.
  static std::vector<const Group*> FindFused(const Entry& entry, const Mapper& mapper);
  static PlacedMark PlacePoint(const Entry& entry, const Mapper& mapper);
  static PlacedMark PlaceOutline(const Entry& entry, const Mapper& mapper);
  const Entry* Find(const std::string& id) const;
  Entry& FindOrMake(const std::string& id);
  std::size_t CountOutlinePoints() const;

  std::vector<Entry> entries_;
  std::int64_t num_kept_ = 0;
};

/// In words, why a mark was not taken.
const char* DescribeJudgement(MarkBook::Judgement judgement);

}  // namespace crsm
