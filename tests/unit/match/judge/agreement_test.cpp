#include "common/match/judge/agreement.hpp"

#include <cmath>

#include "catch.hpp"
#include "common/scan/hits.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

Eigen::Matrix2Xd Hits(const LaserScan& scan) { return ComputeHits(FindValidRays(scan, TestParameters().scan)); }

ByteMap NicheMap() { return PaintMap(-1, 1, NicheByte); }
ByteMap RoomMap() { return PaintMap(-1, 1, RoomByte); }

}  // namespace

TEST_CASE("agreement is the share of rays that reach the wall that they measured, and no other") {
  const ByteMap map = NicheMap();
  const Pose2 pose{-1.0, 0.5, 0.4};
  const LaserScan scan = ScanNiche(pose);
  const auto Agreement = [&](const ByteMap& on, const LaserScan& of) { return ComputeAgreement(on, Hits(of), pose); };
  CHECK(Agreement(map, scan) > 0.98);
  CHECK(ComputeAgreement(map, Eigen::Matrix2Xd(2, 0), pose) == 0.0);
  LaserScan short_of = scan;  // every other ray ends in the free
  for (std::size_t i = 0; i < scan.ranges_m.size(); i += 2) short_of.ranges_m[i] *= 0.5f;
  CHECK(Agreement(map, short_of) == Approx(0.5).margin(0.02));
  LaserScan beyond = scan;  // every ray goes on behind the wall
  for (float& range_m : beyond.ranges_m) range_m += 0.5f;
  CHECK(Agreement(map, beyond) < 0.02);
  // A scan of the whole room goes through the block where there is one: where rays end, it is unexplored.
  CHECK(Agreement(RoomMap(), ScanRoom(pose)) > 0.98);
  CHECK(Agreement(map, ScanRoom(pose)) < 0.95);
}

TEST_CASE(
    "what was within 0.3 m of the laser when the map was made does not hide the walls behind it; a wall so near is "
    "agreed with") {
  const Pose2 pose{-1.0, 0.5, 0.0};
  const Eigen::Matrix2Xd hits_m = Hits(ScanNiche(pose));
  const auto AgreementBehind = [&](double range_m) {  // of something all round the laser
    const auto Paint = [&](Cell cell) {
      const double away_m = std::hypot((cell.x + 0.5) * 0.05 - pose.x_m, (cell.y + 0.5) * 0.05 - pose.y_m);
      return std::abs(away_m - range_m) < 0.05 ? kOccupiedByte : NicheByte(cell);
    };
    return ComputeAgreement(PaintMap(-1, 1, Paint), hits_m, pose);
  };
  CHECK(AgreementBehind(0.2) > 0.98);   // the hand of who carried it
  CHECK(AgreementBehind(0.42) < 0.02);  // a wall
  const Pose2 near{kRoomLeftM + 0.12, 0.5, 0.0};
  // Half of the rays end at the near wall. Some of those along it end between two steps of the way.
  CHECK(ComputeAgreement(RoomMap(), Hits(ScanRoom(near)), near) > 0.95);
}

}  // namespace crsm
