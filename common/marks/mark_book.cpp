#include "common/marks/mark_book.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/math/interpolate.hpp"

namespace crsm {
namespace {

constexpr double kLongest_s = 0.5;       // between a mark and the scan that says where the laser was
constexpr std::size_t kRemembered = 64;  // changes of a place that are known when they come again

double SecondsBetween(std::int64_t a, std::int64_t b) {
  return std::abs(static_cast<double>(a) - static_cast<double>(b)) * 1e-6;
}

bool IsMatched(const std::optional<ScanAt>& at) { return at && at->match.state != MatchState::kLost; }

/// Where a keyframe, or the map's frame, lies by all that is known.
Pose2 PoseOf(const std::optional<KeyframeId>& keyframe, const Mapper& mapper) {
  return keyframe ? At(mapper.best_poses(), *keyframe) : Pose2{};
}

bool IsOnMap(const std::optional<KeyframeId>& keyframe, const Mapper& mapper) {
  return !keyframe || mapper.IsKeyframeOnMap(*keyframe);
}

int ComponentOf(const std::optional<KeyframeId>& keyframe, const Mapper& mapper) {
  return keyframe ? mapper.best_components()[static_cast<std::size_t>(keyframe->trajectory)] : -1;
}

/// All points in one frame, that of a keyframe or of the map.
FixedMark Fix(const Mark& mark, const std::optional<KeyframeId>& keyframe, const Pose2& T_keyframe_points) {
  FixedMark fixed{mark, {}};
  for (const Point& point : mark.points) fixed.points.push_back({keyframe, Apply(T_keyframe_points, point)});
  return fixed;
}

}  // namespace

std::optional<FixedMark> FixByLaser(const Mark& mark, const std::optional<ScanAt>& before,
                                    const std::optional<ScanAt>& after, const Mapper& mapper) {
  const auto SecondsTo = [&](const std::optional<ScanAt>& at) {
    return IsMatched(at) ? SecondsBetween(at->match.utime, mark.utime) : HUGE_VAL;
  };
  const double since_s = SecondsTo(before);
  const double until_s = SecondsTo(after);
  if (std::min(since_s, until_s) > kLongest_s) return std::nullopt;
  const bool is_between =
      since_s + until_s <= 2.0 * kLongest_s && until_s > 0.0 && before->match.trajectory == after->match.trajectory;
  const ScanAt& nearest = since_s <= until_s ? *before : *after;
  const auto PoseOfScan = [&](const ScanAt& at) {
    return mapper.closes_loops() ? mapper.BestPose(at.scan, at.match.T_map_laser) : at.match.T_map_laser;
  };
  const Pose2 T_map_laser = is_between
                                ? Interpolate(PoseOfScan(*before), PoseOfScan(*after), since_s / (since_s + until_s))
                                : PoseOfScan(nearest);
  const auto keyframe = mapper.FindKeyframe(nearest.scan);
  return Fix(mark, keyframe, Inverse(PoseOf(keyframe, mapper)) * T_map_laser);
}

FixedMark FixOnMap(const Mark& mark, const Mapper& mapper) {
  FixedMark fixed{mark, {}};
  const std::vector<KeyframeId> ids = mapper.closes_loops() ? mapper.graph().ids() : std::vector<KeyframeId>();
  for (const Point& point : mark.points) {
    std::optional<KeyframeId> nearest;
    double nearest_m = HUGE_VAL;
    for (const KeyframeId id : ids) {
      if (!mapper.IsKeyframeOnMap(id)) continue;
      const double distance_m = Distance(At(mapper.best_poses(), id), {point.x_m, point.y_m, 0.0});
      if (distance_m >= nearest_m) continue;
      nearest_m = distance_m;
      nearest = id;
    }
    fixed.points.push_back({nearest, Apply(Inverse(PoseOf(nearest, mapper)), point)});
  }
  return fixed;
}

MarkBook::Judgement MarkBook::Judge(const Mark& mark) const {
  using enum Judgement;
  const Entry* entry = Find(mark.id);
  if (entry && std::ranges::find(entry->utimes, mark.utime) != entry->utimes.end()) return kKnown;
  if (mark.action == MarkAction::kRemoved) {
    if (!entry) return kUnknown;
    if (entry->removed) return kKnown;
    return num_kept_ < kMostKept ? kNew : kFull;
  }
  const bool is_outline = mark.points.size() > 1;
  if (mark.action == MarkAction::kSeen && entry) {
    if (entry->removed) return kRemoved;
    if (is_outline || !entry->outline.empty()) return kIsOutline;
  }
  if (num_kept_ >= kMostKept) return kFull;
  const bool has_room = entry || entries_.size() < kMostMarks || std::ranges::any_of(entries_, &Entry::removed);
  if (!has_room) return kFull;
  const std::size_t num_before = entry ? entry->outline.size() : 0;
  if (is_outline && CountOutlinePoints() - num_before + mark.points.size() > kMostOutlinePoints) return kFull;
  return kNew;
}

MarkBook::Judgement MarkBook::Judge(const FixedMark& fixed) const {
  const Judgement judgement = Judge(fixed.mark);
  const Entry* entry = Find(fixed.mark.id);
  if (judgement != Judgement::kNew || !entry || fixed.mark.action != MarkAction::kSeen) return judgement;
  const auto group = std::ranges::find(entry->groups, fixed.points.front().keyframe, &Group::keyframe);
  const bool is_full = group == entry->groups.end() ? entry->groups.size() >= kMostGroups : group->num >= kMostOfGroup;
  return is_full ? Judgement::kKnown : Judgement::kNew;
}

bool MarkBook::Add(const FixedMark& fixed, const Mapper& mapper) {
  const Mark& mark = fixed.mark;
  const auto IsThere = [&](const FixedPoint& point) { return !point.keyframe || mapper.graph().Has(*point.keyframe); };
  if (fixed.points.size() != mark.points.size() || !std::ranges::all_of(fixed.points, IsThere)) return false;
  if (Judge(fixed) != Judgement::kNew) return true;
  ++num_kept_;
  Entry& entry = FindOrMake(mark.id);
  const bool is_first = entry.utimes.empty();
  entry.utimes.push_back(mark.utime);
  if (entry.utimes.size() > kRemembered) entry.utimes.pop_front();
  entry.removed = mark.action == MarkAction::kRemoved;
  if (mark.action != MarkAction::kSeen) {
    entry.groups.clear();
    entry.outline.clear();
  }
  if (entry.removed) return true;
  if (is_first || mark.action == MarkAction::kMoved) {
    entry.kind = mark.kind;
    entry.name = mark.name;
    entry.utime = mark.utime;
  }
  entry.utime = std::max(entry.utime, mark.utime);
  if (fixed.points.size() > 1) {
    entry.outline = fixed.points;
    entry.radius_m = mark.radius_m;
    return true;
  }
  const auto& [keyframe, at] = fixed.points.front();
  auto group = std::ranges::find(entry.groups, keyframe, &Group::keyframe);
  if (group == entry.groups.end()) group = entry.groups.insert(group, Group{keyframe});
  const double weight = 1.0 / (mark.radius_m * mark.radius_m);
  ++group->num;
  group->weight += weight;
  const Point off{at.x_m - group->mean.x_m, at.y_m - group->mean.y_m};
  group->mean = {group->mean.x_m + off.x_m * weight / group->weight,
                 group->mean.y_m + off.y_m * weight / group->weight};
  group->spread += weight * (off.x_m * (at.x_m - group->mean.x_m) + off.y_m * (at.y_m - group->mean.y_m));
  return true;
}

std::vector<PlacedMark> MarkBook::Place(const Mapper& mapper) const {
  std::vector<PlacedMark> placed;
  for (const Entry& entry : entries_) {
    if (entry.removed) continue;
    PlacedMark mark = entry.outline.empty() ? PlacePoint(entry, mapper) : PlaceOutline(entry, mapper);
    mark.utime = entry.utime;
    mark.id = entry.id;
    mark.kind = entry.kind;
    mark.name = entry.name;
    // What poses have carried beyond all maps nobody could be told.
    if (std::ranges::all_of(mark.points, IsOnMaps)) placed.push_back(std::move(mark));
  }
  return placed;
}

std::vector<AnchoredMark> MarkBook::Anchor(const Mapper& mapper) const {
  std::vector<AnchoredMark> anchored;
  for (PlacedMark& mark : Place(mapper)) {
    const Entry& entry = *Find(mark.id);
    std::optional<KeyframeId> best;  // with the best sightings of a point
    if (entry.outline.empty()) {
      const std::vector<const Group*> fused = FindFused(entry, mapper);
      best = (*std::ranges::max_element(fused, {}, &Group::weight))->keyframe;
    }
    AnchoredMark& one = anchored.emplace_back();
    for (std::size_t i = 0; i < mark.points.size(); ++i) {
      const KeyframeId keyframe = (entry.outline.empty() ? best : entry.outline[i].keyframe).value_or(KeyframeId{});
      one.points.push_back({keyframe, Apply(Inverse(PoseOf(keyframe, mapper)), mark.points[i])});
    }
    mark.points.clear();
    mark.floating = false;
    mark.covariance = TurnCovariance(mark.covariance, -PoseOf(one.points.front().keyframe, mapper).yaw_rad);
    one.mark = std::move(mark);
  }
  return anchored;
}

PlacedMark MarkBook::PlaceOutline(const Entry& entry, const Mapper& mapper) {
  PlacedMark mark;
  mark.num_sightings = 1;
  mark.covariance = {entry.radius_m * entry.radius_m, 0.0, entry.radius_m * entry.radius_m};
  for (const auto& [keyframe, at] : entry.outline) {
    mark.points.push_back(Apply(PoseOf(keyframe, mapper), at));
    mark.floating |= !IsOnMap(keyframe, mapper);
  }
  return mark;
}

std::vector<const MarkBook::Group*> MarkBook::FindFused(const Entry& entry, const Mapper& mapper) {
  const auto IsShown = [&](const Group& group) { return IsOnMap(group.keyframe, mapper); };
  const bool floats = std::ranges::none_of(entry.groups, IsShown);
  const int component = ComponentOf(entry.groups.back().keyframe, mapper);
  std::vector<const Group*> fused;
  for (const Group& group : entry.groups) {
    if (floats ? ComponentOf(group.keyframe, mapper) == component : IsShown(group)) fused.push_back(&group);
  }
  return fused;
}

PlacedMark MarkBook::PlacePoint(const Entry& entry, const Mapper& mapper) {
  PlacedMark mark;
  std::vector<std::pair<const Group*, Point>> fused;
  double weight = 0.0;
  Point mean;
  for (const Group* group : FindFused(entry, mapper)) {
    mark.floating = !IsOnMap(group->keyframe, mapper);  // all are, or none is
    const Point at = Apply(PoseOf(group->keyframe, mapper), group->mean);
    fused.emplace_back(group, at);
    weight += group->weight;
    const double share = group->weight / weight;
    mean = {mean.x_m + (at.x_m - mean.x_m) * share, mean.y_m + (at.y_m - mean.y_m) * share};
    mark.num_sightings += group->num;
  }
  // How far the sightings lie apart, in their standard deviations: it adds to what each says of itself.
  std::array<double, 3> apart{};
  for (const auto& [group, at] : fused) {
    const Point off{at.x_m - mean.x_m, at.y_m - mean.y_m};
    apart[0] += group->weight * off.x_m * off.x_m + 0.5 * group->spread;
    apart[1] += group->weight * off.x_m * off.y_m;
    apart[2] += group->weight * off.y_m * off.y_m + 0.5 * group->spread;
  }
  const double others = std::max(1, mark.num_sightings - 1);
  mark.covariance = {(1.0 + apart[0] / others) / weight, apart[1] / others / weight,
                     (1.0 + apart[2] / others) / weight};
  mark.points = {mean};
  return mark;
}

const MarkBook::Entry* MarkBook::Find(const std::string& id) const {
  const auto found = std::ranges::find(entries_, id, &Entry::id);
  return found == entries_.end() ? nullptr : &*found;
}

MarkBook::Entry& MarkBook::FindOrMake(const std::string& id) {
  const auto found = std::ranges::find(entries_, id, &Entry::id);
  if (found != entries_.end()) return *found;
  if (entries_.size() >= kMostMarks) entries_.erase(std::ranges::find_if(entries_, &Entry::removed));
  entries_.push_back({id});
  return entries_.back();
}

std::size_t MarkBook::CountOutlinePoints() const {
  std::size_t num = 0;
  for (const Entry& entry : entries_) num += entry.outline.size();
  return num;
}

const char* DescribeJudgement(MarkBook::Judgement judgement) {
  switch (judgement) {
    case MarkBook::Judgement::kRemoved:
      return "the place was removed: only who moves it brings it back";
    case MarkBook::Judgement::kIsOutline:
      return "an outline is not seen again: move it";
    case MarkBook::Judgement::kUnknown:
      return "there is no place of that id to remove";
    case MarkBook::Judgement::kFull:
      return "there is no room for more: remove some";
    default:
      return "";
  }
}

}  // namespace crsm
