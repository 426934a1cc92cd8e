#include "common/worlds/built_in_worlds.hpp"

namespace crsm {
namespace {

constexpr const char* kDemo = R"(# A flat of six rooms around a loop of corridors, 14 x 10 m.
laser 270 270 9.5 10 0.01
speed 0.3 0.5

box 0 0 14 10
box 5.2 4.2 3.6 1.6         # the block inside the loop
wall 4 0 4 3.2              # west side of the loop, doors to bedroom and bathroom
wall 4 4.2 4 5.8
wall 4 6.8 4 10
wall 10 0 10 3.3            # east side, doors to living room and study
wall 10 4.3 10 5.7
wall 10 6.7 10 10
wall 4 3 6.6 3              # south side, door to the kitchen
wall 7.6 3 10 3
wall 4 7 5.6 7              # north side, door to the dining room
wall 6.6 7 10 7
wall 0 4.8 4 4.8            # bedroom | bathroom
wall 10 5.2 14 5.2          # living room | study

box 7.6 5.8 0.6 0.15        # corridor: shelf
box 0.2 0.2 1.4 1           # bedroom: bed, wardrobe, desk
box 3.3 0.3 0.6 1.6
box 0.1 4 1.2 0.7
box 8.6 0.1 1.3 1.4         # kitchen: counter, table, fridge
box 4.2 2.2 0.8 0.6
box 4.1 0.1 0.7 0.7
box 13 2.4 0.9 1.9          # living room: sofa, cupboard, table
box 10.1 0.6 0.4 1.5
box 11 2 0.5 0.5
box 13.1 5.4 0.8 1.6        # study: desk, shelf, cabinet
box 10.1 9.4 2.2 0.5
box 10.1 7.4 0.6 0.9
box 6.9 7.4 0.9 0.5         # dining room: table, cupboard, sideboard
box 4.1 8.8 0.5 1.1
box 8.9 7.2 1 0.5
box 0.1 4.9 1.7 0.7         # bathroom: tub, shower, basin
box 3.1 8.9 0.8 1
box 0.1 6.9 0.4 0.6

waypoint 4.6 5
waypoint 4.6 3.7
waypoint 2.6 3.7            # bedroom
waypoint 1.2 2.2
waypoint 2.6 1.2
waypoint 2.6 3.7
waypoint 4.6 3.7
waypoint 7.1 3.6
waypoint 7.1 1.6            # kitchen
waypoint 5.4 1.4
waypoint 7.1 1.6
waypoint 7.1 3.6
waypoint 9.4 3.7
waypoint 12 3.8             # living room
waypoint 12.4 1.6
waypoint 12 3.8
waypoint 9.4 3.7
waypoint 9.4 6.2
waypoint 11.8 6.2           # study
waypoint 12.2 8.4
waypoint 11.8 6.2
waypoint 9.4 6.2
waypoint 6.1 6.4
waypoint 6.1 8.2            # dining room
waypoint 8.2 8.6
waypoint 6.1 8.2
waypoint 6.1 6.4
waypoint 4.6 6.3
waypoint 2.2 6.3            # bathroom
waypoint 1.4 8.4
waypoint 2.2 6.3
waypoint 4.6 6.3
waypoint 4.6 5
)";

constexpr const char* kCorridor =
    R"(# A corridor of 1.6 m with four bends, niches and pillars: wherever the laser stands, it
# sees walls along the corridor and walls across it.
laser 240 240 5.6 10 0.01
speed 0.3 0.5

wall -0.8 -0.8 -0.8 0.8     # west end
wall -0.8 0.8 1.5 0.8       # left wall
wall 1.5 0.8 1.5 1.3
wall 1.5 1.3 2.4 1.3
wall 2.4 1.3 2.4 0.8
wall 2.4 0.8 5.2 0.8
wall 5.2 0.8 5.2 2.4
wall 5.2 2.4 4.7 2.4
wall 4.7 2.4 4.7 3.3
wall 4.7 3.3 5.2 3.3
wall 5.2 3.3 5.2 5.8
wall 5.2 5.8 8.2 5.8
wall 8.2 5.8 8.2 6.3
wall 8.2 6.3 9.2 6.3
wall 9.2 6.3 9.2 5.8
wall 9.2 5.8 11.8 5.8
wall 11.8 5.8 12.8 4.8
wall 12.8 4.8 12.8 3.4
wall 12.8 3.4 13.3 3.4
wall 13.3 3.4 13.3 2.5
wall 13.3 2.5 12.8 2.5
wall 12.8 2.5 12.8 0.8
wall 12.8 0.8 15 0.8
wall 15 0.8 15 1.3
wall 15 1.3 15.8 1.3
wall 15.8 1.3 15.8 0.8
wall 15.8 0.8 17.8 0.8
wall 17.8 0.8 17.8 -0.8     # east end
wall 17.8 -0.8 11.2 -0.8    # right wall
wall 11.2 -0.8 11.2 4.2
wall 11.2 4.2 6.8 4.2
wall 6.8 4.2 6.8 -0.8
wall 6.8 -0.8 4.4 -0.8
wall 4.4 -0.8 4.4 -1.3
wall 4.4 -1.3 3.4 -1.3
wall 3.4 -1.3 3.4 -0.8
wall 3.4 -0.8 -0.8 -0.8
box 0.4 -0.8 0.3 0.25       # pillars
box 6.4 1.2 0.4 0.4
box 9.9 4.2 0.4 0.3
box 11.2 1.4 0.25 0.4
box 13.9 -0.8 0.3 0.3
box 16.6 0.5 0.3 0.3

waypoint 0 0
waypoint 6 0
waypoint 6 5
waypoint 12 5
waypoint 12 0
waypoint 17 0
)";

// The worlds of the paper's experiments (sections 4 and 7). The paper gives the areas of its three simulated ones, the
// laser and the speeds; the plans are ours. Five scans a second, 3 cm apart, so that all experiments end within the
// hour; the paper allows 20 cm. The corners are those that CMSE looks for: each is seen from both of its sides.

constexpr const char* kEnv1 = R"(# Environment 1: four large rooms with many obstacles, 24 x 17.5 m = 420 m2.
laser 270 270 9.5 5 0.01
speed 0.15 0.12

box 0 0 24 17.5
wall 12 0 12 3.5            # south-west | south-east
wall 12 5 12 12.5
wall 12 14 12 17.5
wall 0 8.5 5 8.5            # south | north
wall 6.5 8.5 17 8.5
wall 18.5 8.5 24 8.5

box 1.2 1 1.6 0.8           # south-west room
box 5 1.5 1 1
box 8.5 0 0.6 2.2
box 8.8 6.2 1.4 0.9
box 0 6.6 2 0.5
box 3.4 6.2 0.7 0.7
wall 10.2 1.2 11.2 2.2
box 14 1.2 0.8 1.9          # south-east room
box 16.8 0.6 2 0.7
box 14.4 5.8 1.1 1.1
box 20.6 3 0.6 2.4
box 22.4 0.8 0.9 0.9
box 21.2 7 1.8 0.8
wall 19.4 1.9 20.2 2.7
box 20.8 10.4 1.2 1.2       # north-east room
box 14.2 9.6 1.8 0.6
box 19.6 15.2 2.4 0.7
box 22.8 12.6 0.7 1.9
box 14.8 15.6 0.8 0.8
box 13 11 0.5 0.5
wall 16.8 15.4 17.8 16.4
box 8.8 10.2 1.3 0.9        # north-west room
box 1 10.2 0.8 2.2
box 3 15 2 0.9
box 7.6 15.2 0.9 0.9
box 10.3 15.8 1.1 0.6
box 2.6 12.6 0.8 0.8
wall 0.6 14.2 1.4 15

waypoint 2.4 4.2
waypoint 7.4 4.6
waypoint 10 4.2
waypoint 13.4 4.2
waypoint 17.7 3.4
waypoint 18 6.4
waypoint 17.7 10
waypoint 18.4 13
waypoint 14.6 13.3
waypoint 10.2 13.3
waypoint 6.2 13.2
waypoint 5.7 10
waypoint 5.8 6.6
waypoint 6.6 4.4

corner south_west 0 0
corner north_west 0 17.5
corner middle 12 8.5
corner box_1 2.8 1.8
corner box_2 5 2.5
corner box_3 14.8 3.1
corner box_4 20.6 5.4
corner box_5 20.8 11.6
corner box_6 5 15
corner box_7 8.8 11.1
corner box_8 8.8 6.2
corner box_9 4.1 6.2
)";

constexpr const char* kEnv2 =
    R"(# Environment 2: long narrow corridors with junctions, 22 x 12 m = 264 m2. Every 1.6 m a pillar or a cabinet
# stands out of a wall: without them a corridor whose ends are out of range looks the same all along.
laser 270 270 9.5 5 0.01
speed 0.15 0.12

box 0 0 22 12
box 1.8 1.8 8.3 8.4         # the two blocks that the corridors go around
box 11.9 1.8 8.3 8.4

box 2.4 0 0.3 0.3           # south corridor, western half
box 4.1 1.45 0.9 0.35
box 5.6 0 0.4 0.4
box 7.3 1.5 0.3 0.3
box 8.8 0 0.6 0.35
box 12.5 1.45 0.9 0.35      # south corridor, eastern half
box 14.2 0 0.4 0.4
box 15.8 1.5 0.3 0.3
box 17.5 0 0.6 0.35
box 19.1 1.4 0.3 0.4
box 0 2.5 0.4 0.4           # west corridor
box 1.5 4.1 0.3 0.3
box 0 5.7 0.35 0.6
box 1.4 7.3 0.4 0.3
box 0 8.8 0.3 0.9
box 10.1 2.6 0.3 0.3        # middle corridor
box 11.55 4.2 0.35 0.6
box 10.1 5.6 0.4 0.3
box 11.6 7.3 0.3 0.9
box 10.1 8.9 0.35 0.4
box 21.65 2.6 0.35 0.6      # east corridor
box 20.2 4.1 0.4 0.3
box 21.7 5.8 0.3 0.9
box 20.2 7.4 0.35 0.4
box 21.6 8.8 0.4 0.3
box 2.6 10.2 0.3 0.4        # north corridor, western half
box 4.2 11.7 0.9 0.3
box 5.8 10.2 0.4 0.35
box 7.3 11.6 0.3 0.4
box 8.9 10.2 0.6 0.3
box 12.6 11.7 0.9 0.3       # north corridor, eastern half
box 14.2 10.2 0.4 0.35
box 15.7 11.6 0.3 0.4
box 17.4 10.2 0.6 0.3
box 19 11.65 0.3 0.35

waypoint 11 0.9
waypoint 0.9 0.9
waypoint 0.9 11.1
waypoint 11 11.1
waypoint 11 0.9
waypoint 21.1 0.9
waypoint 21.1 11.1
waypoint 12 11.1

corner south_west 0 0
corner north_west 0 12
corner south_east 22 0
corner north_east 22 12
corner west_block_south_west 1.8 1.8
corner west_block_north_west 1.8 10.2
corner west_block_north_east 10.1 10.2
corner west_block_south_east 10.1 1.8
corner east_block_south_west 11.9 1.8
corner east_block_south_east 20.2 1.8
corner east_block_north_east 20.2 10.2
corner east_block_north_west 11.9 10.2
)";

constexpr const char* kEnv3 = R"(# Environment 3: one twisted corridor, 17 x 10 m = 170 m2.
laser 270 270 9.5 5 0.01
speed 0.15 0.12

box 0 0 17 10
wall 0 2.5 14.5 2.5
wall 2.5 5 17 5
wall 0 7.5 14.5 7.5

box 0.4 0 0.4 0.4           # first lane
box 1.9 2 0.4 0.5
box 3.2 0 0.4 0.5
box 4.8 2.1 0.9 0.4
box 6.6 0 0.4 0.4
box 8.2 2 0.4 0.5
box 9.6 0 0.9 0.5
box 11.4 2.1 0.4 0.4
box 13 0 0.4 0.5
wall 16 0 17 1              # its end is cut off at an angle
wall 17 4 16 5
box 16.5 2.3 0.5 0.4
box 13.4 2.5 0.5 0.4        # second lane
box 12 4.6 0.4 0.4
box 10.4 2.5 0.4 0.5
box 8.8 4.5 0.9 0.5
box 7.2 2.5 0.4 0.4
box 5.6 4.5 0.4 0.5
box 4 2.5 0.6 0.4
box 2.9 4.6 0.3 0.4
wall 1 2.5 0 3.5
box 0 4.8 0.4 0.4
wall 0 6.5 1 7.5
box 3.4 5 0.4 0.5           # third lane
box 5 7 0.4 0.5
box 6.4 5 0.5 0.4
box 8 7.1 0.9 0.4
box 9.8 5 0.4 0.5
box 11.2 7 0.4 0.5
box 12.6 5 0.6 0.4
box 14 7.1 0.3 0.4
box 16.4 5 0.6 0.6
box 16.6 7.4 0.4 0.4
wall 16 10 17 9
box 13.4 7.5 0.4 0.4        # fourth lane
box 11.8 9.5 0.4 0.5
box 10.2 7.5 0.9 0.4
box 8.6 9.5 0.4 0.5
box 7 7.5 0.4 0.5
box 5.2 9.6 0.6 0.4
box 3.6 7.5 0.4 0.5
box 1.8 9.6 0.4 0.4
wall 0 9 1 10

waypoint 1.2 1.25
waypoint 15.7 1.25
waypoint 15.7 3.75
waypoint 1.3 3.75
waypoint 1.3 6.25
waypoint 15.7 6.25
waypoint 15.7 8.75
waypoint 2 8.75

corner first_south 3.6 0.5
corner first_north 4.8 2.1
corner first_middle 9.6 0.5
corner first_end 11.4 2.1
corner second_south 7.6 2.9
corner second_north 9.7 4.5
corner second_end 3.2 4.6
corner third_north 8 7.1
corner third_south 9.8 5.5
corner third_end 16.4 5.6
corner fourth_north 12.2 9.5
corner fourth_south 10.2 7.9
corner fourth_end 4 8
)";

constexpr const char* kEnv4 =
    R"(# Environment 4: a cluttered lab of 9 x 7 m for a laser like Hokuyo's URG-04LX.
laser 240 682 4 10 0.01 dropout 0.01 quantum_m 0.001
speed 0.15 0.12

box 0 0 9 7
box 0 0 2.4 0.8             # desks along the walls
box 3.2 0 1.6 0.8
box 7.2 0.6 1.8 0.8
box 0 4.4 0.8 1.8
box 2.2 6.2 2 0.8
box 5.4 6.2 1.6 0.8
box 8.2 3.4 0.8 2
box 3 3 1.6 0.8             # tables in the middle
box 5.4 3.4 0.8 0.8
box 6 0 0.6 0.4             # cabinets, boxes, chairs and their legs
box 0 1.6 0.4 0.8
box 1.2 6.5 0.5 0.5
box 8.4 6.3 0.6 0.7
box 1.4 1.1 0.45 0.05
box 1.4 1.35 0.05 0.05
box 1.8 1.35 0.05 0.05
box 3.8 1.0 0.4 0.05
box 3.8 1.3 0.05 0.05
box 4.15 1.3 0.05 0.05
box 3.5 4.1 0.4 0.05
box 3.5 4.4 0.05 0.05
box 3.85 4.4 0.05 0.05
box 1.1 5 0.05 0.4
box 1.4 5 0.05 0.05
box 1.4 5.35 0.05 0.05
box 7.7 4.2 0.05 0.4
box 7.4 4.2 0.05 0.05
box 7.4 4.55 0.05 0.05
box 2.7 5.8 0.4 0.05
box 6 5.7 0.05 0.05
box 6.4 5.7 0.05 0.05
wall 5.2 0.9 5.6 1.3
wall 2.2 3.2 2.5 3.6

waypoint 1.2 2.4
waypoint 5.2 2.2
waypoint 6.9 2.6
waypoint 6.9 5
waypoint 4.8 5
waypoint 2.2 4.8
waypoint 1.4 3.4
waypoint 2.4 2.4
)";

}  // namespace

const std::map<std::string, const char*>& BuiltInWorlds() {
  static const std::map<std::string, const char*> kWorlds = {{"demo", kDemo}, {"corridor", kCorridor}, {"env1", kEnv1},
                                                             {"env2", kEnv2}, {"env3", kEnv3},         {"env4", kEnv4}};
  return kWorlds;
}

}  // namespace crsm
