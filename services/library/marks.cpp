#include <algorithm>
#include <stdexcept>

#include "services/library/impl.hpp"

namespace crsm_slam {
namespace {

crsm::Mark FromPublic(const Mark& mark, crsm::MarkAction action) {
  crsm::Mark same;
  same.utime = mark.utime.value_or(0);
  same.id = mark.id;
  same.kind = mark.kind;
  same.name = mark.name;
  same.action = action;
  same.in_map_frame = !mark.utime;
  same.radius_m = mark.radius_m;
  for (const auto& [x_m, y_m] : mark.points_m) same.points.push_back({x_m, y_m});
  return same;
}

[[noreturn]] void Refuse(const crsm::Mark& mark, const std::string& why) {
  throw std::invalid_argument("mark '" + mark.id + "': " + why);
}

}  // namespace

/// The last scan up to a time, and the first one behind it.
std::pair<std::optional<crsm::ScanAt>, std::optional<crsm::ScanAt>> Slam::Impl::FindScans(std::int64_t utime) const {
  std::pair<std::optional<crsm::ScanAt>, std::optional<crsm::ScanAt>> around;
  auto& [before, after] = around;
  for (std::int64_t scan = 0; scan < std::ssize(matched); ++scan) {
    const crsm::ScanMatch& match = matched[static_cast<std::size_t>(scan)];
    if (match.utime <= utime && (!before || match.utime > before->match.utime)) before = crsm::ScanAt{scan, match};
    if (match.utime > utime && (!after || match.utime < after->match.utime)) after = crsm::ScanAt{scan, match};
  }
  if (before && before->match.utime == utime) after.reset();
  return around;
}

void Slam::Impl::Take(crsm::Mark mark) {
  Await();
  using enum crsm::MarkBook::Judgement;
  const std::string fault = crsm::DescribeFault(mark);
  if (!fault.empty()) Refuse(mark, fault);
  if (matched.empty() && !finished) Refuse(mark, "there is no map yet: process a scan before");
  if (mark.in_map_frame) {  // what is said without a time is something new each time
    while (mark.action != crsm::MarkAction::kRemoved && book.Judge(mark) == kKnown) ++mark.utime;
  }
  std::optional<crsm::FixedMark> fixed;
  if (mark.action == crsm::MarkAction::kRemoved) {
    fixed = crsm::FixedMark{mark, {}};
  } else if (mark.in_map_frame) {
    fixed = crsm::FixOnMap(mark, slam.mapper());
  } else {
    const auto [before, after] = FindScans(mark.utime);
    fixed = crsm::FixByLaser(mark, before, after, slam.mapper());
    if (!fixed) Refuse(mark, "no scan was matched within 0.5 s of its utime, " + std::to_string(mark.utime));
  }
  const auto judgement = book.Judge(*fixed);
  if (judgement == kKnown) return;
  if (judgement != kNew) Refuse(mark, crsm::DescribeJudgement(judgement));
  book.Add(*fixed, slam.mapper());
  marks.push_back(*std::move(fixed));
}

void Slam::AddMark(const Mark& mark) { impl_->Take(FromPublic(mark, crsm::MarkAction::kSeen)); }

void Slam::MoveMark(const Mark& mark) { impl_->Take(FromPublic(mark, crsm::MarkAction::kMoved)); }

void Slam::RemoveMark(const std::string& id) {
  crsm::Mark mark;
  mark.id = id;
  mark.action = crsm::MarkAction::kRemoved;
  mark.utime = static_cast<std::int64_t>(impl_->marks.size());
  const auto placed = impl_->book.Place(impl_->slam.mapper());
  if (std::ranges::find(placed, id, &crsm::PlacedMark::id) == placed.end()) {
    Refuse(mark, "there is no place of that id to remove");
  }
  while (impl_->book.Judge(mark) == crsm::MarkBook::Judgement::kKnown) ++mark.utime;
  impl_->Take(mark);
}

std::vector<PlacedMark> Slam::Marks() const {
  std::vector<PlacedMark> marks;
  for (const crsm::PlacedMark& mark : impl_->book.Place(impl_->Await().mapper())) {
    PlacedMark& same = marks.emplace_back();
    same.id = mark.id;
    same.kind = mark.kind;
    same.name = mark.name;
    for (const auto& [x_m, y_m] : mark.points) same.points_m.push_back({x_m, y_m});
    same.covariance = mark.covariance;
    same.sightings = mark.num_sightings;
    same.on_map = !mark.floating;
  }
  return marks;
}

}  // namespace crsm_slam
