#pragma once

namespace crsm {

struct Point {
  double x_m = 0.0;
  double y_m = 0.0;
};

}  // namespace crsm
