// Maps the ROBOTLASER1 lines of a CARMEN log: map_log sick <run.log >map.pgm
#include <cmath>
#include <crsm_slam/slam.hpp>
#include <iostream>
#include <sstream>
#include <string>

int main(int argc, char** argv) {
  crsm_slam::Slam slam({.preset = argc > 1 ? argv[1] : ""});
  for (std::string line, word; std::getline(std::cin, line);) {
    std::istringstream words(line);
    double seconds = 0.0;
    std::size_t num_beams = 0;
    crsm_slam::Scan scan;
    words >> word;
    if (word != "ROBOTLASER1") continue;
    words >> word >> scan.angle_min_rad >> word >> scan.angle_step_rad >> word >> word >> word >> num_beams;
    scan.ranges_m.resize(num_beams);
    for (float& range_m : scan.ranges_m) words >> range_m;
    for (int i = 0; i < 12; ++i) words >> word;  // no remissions; the robot's poses and speeds
    words >> seconds;
    scan.utime = std::llround(1e6 * seconds);
    slam.Process(scan);
  }
  const crsm_slam::Map map = slam.MakeMap();
  std::cout << "P5\n" << map.width_cells << " " << map.height_cells << "\n255\n";
  for (auto row = map.cells.end(); row != map.cells.begin();) {
    row -= map.width_cells;  // the highest first
    std::cout.write(reinterpret_cast<const char*>(&*row), map.width_cells);
  }
}
