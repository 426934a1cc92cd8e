#pragma once

#include <time.h>

namespace crsm {

/// CPU time of this thread [s]: what others take of the machine does not count.
inline double CpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace crsm
