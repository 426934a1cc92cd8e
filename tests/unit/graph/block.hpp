#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "common/graph/keyframe_graph.hpp"
#include "common/math/random.hpp"
#include "common/worlds/world.hpp"
#include "synthetic_scans.hpp"

namespace crsm {

/// Corridors of 3 m around a block, 30 m x 20 m outside. What stands along their walls is nowhere the same.
inline std::vector<Wall> MakeBlock(std::uint64_t seed) {
  Random random(seed);
  std::vector<Wall> walls;
  const auto AddBox = [&](double left_m, double bottom_m, double right_m, double top_m) {
    const Point corners[] = {{left_m, bottom_m}, {right_m, bottom_m}, {right_m, top_m}, {left_m, top_m}};
    for (int i = 0; i < 4; ++i) walls.push_back({corners[i], corners[(i + 1) % 4]});
  };
  AddBox(0.0, 0.0, 30.0, 20.0);
  AddBox(3.0, 3.0, 27.0, 17.0);
  const auto AlongWall = [&](double from_m, double to_m, auto&& add) {
    for (double at_m = from_m + random.Uniform(0.5, 2.0); at_m < to_m - 1.0; at_m += random.Uniform(1.2, 3.5)) {
      add(at_m, at_m + random.Uniform(0.2, 0.9), random.Uniform(0.15, 0.6));
    }
  };
  AlongWall(3.0, 27.0, [&](double a, double b, double deep) { AddBox(a, 0.0, b, deep); });
  AlongWall(3.0, 27.0, [&](double a, double b, double deep) { AddBox(a, 3.0 - deep, b, 3.0); });
  AlongWall(3.0, 27.0, [&](double a, double b, double deep) { AddBox(a, 20.0 - deep, b, 20.0); });
  AlongWall(3.0, 27.0, [&](double a, double b, double deep) { AddBox(a, 17.0, b, 17.0 + deep); });
  AlongWall(3.0, 17.0, [&](double a, double b, double deep) { AddBox(0.0, a, deep, b); });
  AlongWall(3.0, 17.0, [&](double a, double b, double deep) { AddBox(3.0 - deep, a, 3.0, b); });
  AlongWall(3.0, 17.0, [&](double a, double b, double deep) { AddBox(30.0 - deep, a, 30.0, b); });
  AlongWall(3.0, 17.0, [&](double a, double b, double deep) { AddBox(27.0, a, 27.0 + deep, b); });
  return walls;
}

inline constexpr double kRoundBlock_m = 88.0;

/// In the middle of the corridors, so far from the lower left corner, counter-clockwise.
inline Pose2 PlaceRoundBlock(double way_m) {
  const double sides_m[] = {27.0, 17.0, 27.0, 17.0};
  Pose2 corner{1.5, 1.5, 0.0};
  double left_m = std::fmod(way_m, kRoundBlock_m);
  for (const double side_m : sides_m) {
    if (left_m < side_m) break;
    left_m -= side_m;
    corner = corner * Pose2{side_m, 0.0, kPi / 2};
  }
  return corner * Pose2{left_m, 0.0, 0.0};
}

/// From one way round the block to another, a place every half metre.
inline std::vector<Pose2> DriveRoundBlock(double from_m, double to_m) {
  std::vector<Pose2> places;
  const double step_m = to_m > from_m ? 0.5 : -0.5;
  const int num_steps = static_cast<int>((to_m - from_m) / step_m);
  for (int i = 0; i <= num_steps; ++i) places.push_back(PlaceRoundBlock(from_m + i * step_m));
  return places;
}

/// What is seen all round from there, to 12 m, with noise of 1 cm.
inline ValidRays SeeRays(const std::vector<Wall>& walls, const Pose2& T_world_laser, Random& random) {
  constexpr int kBeams = 180;
  ValidRays rays;
  for (int i = 0; i < kBeams; ++i) {
    const double angle_rad = -kPi + 2 * kPi * i / kBeams;
    const double range_m =
        CastRay(walls, {T_world_laser.x_m, T_world_laser.y_m}, ComputeSinCos(T_world_laser.yaw_rad + angle_rad));
    if (!(range_m < 12.0)) continue;
    rays.angle_rad.push_back(static_cast<float>(angle_rad));
    rays.range_m.push_back(static_cast<float>(range_m + 0.01 * random.Gaussian()));
  }
  return rays;
}

/// The keyframes of a drive whose motions are matched with an error per metre, and with noise.
inline std::vector<Keyframe> MakeKeyframes(const std::vector<Wall>& walls, const std::vector<Pose2>& places,
                                           const Pose2& drift_per_m, std::uint64_t seed) {
  Random random(seed, 11);
  std::vector<Keyframe> keyframes;
  for (std::size_t i = 0; i < places.size(); ++i) {
    Keyframe keyframe;
    keyframe.utime = static_cast<std::int64_t>(i);
    keyframe.rays = SeeRays(walls, places[i], random);
    if (i > 0) {
      const Pose2 motion = Inverse(places[i - 1]) * places[i];
      const double way_m = std::hypot(motion.x_m, motion.y_m);
      const Pose2 error{way_m * drift_per_m.x_m + 0.003 * random.Gaussian(),
                        way_m * drift_per_m.y_m + 0.003 * random.Gaussian(),
                        way_m * drift_per_m.yaw_rad + 0.0003 * random.Gaussian()};
      keyframe.T_previous_this = motion * error;
    }
    keyframes.push_back(std::move(keyframe));
  }
  return keyframes;
}

}  // namespace crsm
