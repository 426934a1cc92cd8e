#include "services/base/stall_watch.hpp"

#include <fmt/core.h>

#include <utility>

namespace crsm {

void StallWatch::Look(const Awaited& awaited, Clock::time_point now) {
  if (awaited != awaited_) {
    awaited_ = awaited;
    since_ = now;
    said_ = false;
  }
  if (!awaited_.what || said_ || now - since_ < kLong) return;
  said_ = true;
  say_(fmt::format("{}: has waited {} s for {}", program_, kLong.count(),
                   fmt::format(fmt::runtime(awaited_.what), awaited_.number)));
}

}  // namespace crsm
