#pragma once

#include "common/math/trigonometry.hpp"

namespace crsm {

/// ComputeSinCos of an angle that comes up in scan after scan, as those of a laser's beams do: each thread keeps the
/// last few hundred.
SinCos LookUpSinCos(double angle_rad);

}  // namespace crsm
