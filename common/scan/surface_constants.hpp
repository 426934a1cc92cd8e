#pragma once

namespace crsm {

/// When hits lie on one surface.
struct SurfaceConstants {
  double cosine_min = 0.966;        ///< of the angle by which it bends from one hit to the next: 15 degrees
  double beside_max_m = 0.05;       ///< a door that stands back by more is no part of its wall
  double growth_max = 3.0;          ///< of a wall seen at 10 degrees, one beam a degree: a quarter; the rest is noise
  double along_beam_sine = 0.0872;  ///< 5 degrees
};

}  // namespace crsm
