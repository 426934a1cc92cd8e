#pragma once

#include <Eigen/Core>

#include "common/scan/valid_rays.hpp"

namespace crsm {

/// Where the rays end. 2 x N, laser frame, metres.
Eigen::Matrix2Xd ComputeHits(const ValidRays& rays);

}  // namespace crsm
