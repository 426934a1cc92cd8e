#include "bench/workloads.hpp"

#include <algorithm>
#include <cstdlib>
#include <memory>

#include "common/scan/hits.hpp"
#include "unit/synthetic_scans.hpp"

namespace crsm::bench {
namespace {

constexpr int kBeams = 1080;
constexpr double kRoomPitch_m = 8.0;
constexpr double kCell_m = 0.05;
const Pose2 kPose{0.13, -0.08, 0.05};

MatchConstants BenchConstants(int num_evaluations) {
  MatchConstants constants;
  constants.search.num_evaluations = num_evaluations;
  return constants;
}

ByteMap PaintRoom() { return PaintMap(-2, 1, RoomByte); }

}  // namespace

Site::Site(int num_evaluations)
    : matcher_({}, kCell_m, BenchConstants(num_evaluations)),
      updater_(TestParameters().update),
      map_(kCell_m),
      scan_(ScanRoom(kPose, 1, kBeams)),
      rays_(AllRays(scan_)) {
  ScanMatch match;
  match.utime = 1;
  const MapDelta delta = updater_.Update(AllRays(ScanRoom({}, 1, kBeams)), match);
  Apply(delta);
  map_.Apply(delta.tiles);
}

std::vector<int> Site::Select() const { return SelectRays(rays_.rays, SelectionParameters{}.rays_max); }

ScanMatch Site::Match(int num_rays) const {
  return matcher_.Match({scan_.utime, rays_.rays, PickIndices(num_rays)}, After({ScanMatch{}}), {});
}

MapDelta Site::Update() {
  ScanMatch match;
  match.utime = scan_.utime;
  match.T_map_laser = kPose;
  match.state = MatchState::kOk;
  return updater_.Update(rays_, match);
}

std::size_t Site::Explore() {
  ScanMatch match;
  match.utime = scan_.utime;
  match.T_map_laser = {next_room_.x * kRoomPitch_m, next_room_.y * kRoomPitch_m, 0.0};
  match.state = MatchState::kOk;
  Apply(updater_.Update(rays_, match));
  // Round the origin: up on the right, left above, down on the left, right below and one further.
  auto& [x, y] = next_room_;
  const int ring = std::max(std::abs(x), std::abs(y));
  if (x == ring && std::abs(y) < ring) {
    ++y;
  } else if (y == ring && x > -ring) {
    --x;
  } else if (x == -ring && y > -ring) {
    --y;
  } else {
    ++x;
  }
  return updater_.num_tiles();
}

double Site::Evaluate(const RaysInCells& rays) const { return map_.Fitness(rays, kPose); }

RaysInCells Site::PickRays(int num_rays) const {
  const Eigen::Matrix2Xd hits_m = ComputeHits(rays_.rays);
  return ToCells(hits_m(Eigen::all, PickIndices(num_rays)), map_.geometry());
}

std::vector<int> Site::PickIndices(int num_rays) const {
  std::vector<int> indices;
  for (int i = 0; i < num_rays; ++i) indices.push_back(i * static_cast<int>(rays_.rays.size()) / num_rays);
  return indices;
}

std::vector<Workload> MakeWorkloads() {
  const auto site = std::make_shared<Site>(10000);
  const auto tile = std::make_shared<TileBytes>(PaintRoom().tiles().Find({0, 0})->cells);
  const auto blank = std::make_shared<TileBytes>();
  blank->fill(kUnexploredByte);
  const auto change = std::make_shared<TileChange>(TileChange{{0, 0}, PackRuns(*blank, *tile)});
  const auto map = std::make_shared<ByteMap>(0.05);
  const auto delta = std::make_shared<MapDelta>(Site(1).Update());
  return {
      {"selection", [=] { site->Select(); }},
      {"fitness_40_rays", [=, rays = site->PickRays(40)] { site->Evaluate(rays); }},
      {"match_10000_evaluations_40_rays", [=] { site->Match(40); }},
      {"update", [=] { site->Update(); }},
      {"delta_encode", [=] { PackRuns(*blank, *tile); }},
      {"delta_apply", [=] { map->Apply(*change); }},
      {"matcher_apply", [=] { site->Apply(*delta); }},
  };
}

}  // namespace crsm::bench
