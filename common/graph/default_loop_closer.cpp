#include "common/graph/default_loop_closer.hpp"

#include "common/graph/submap_loop_closer.hpp"

namespace crsm {

MakeLoopCloser DefaultLoopCloser(const LoopParameters& parameters, const DrawingRules& drawing,
                                 const GraphConstants& constants) {
  return [=] { return std::make_unique<SubmapLoopCloser>(parameters, drawing, constants); };
}

}  // namespace crsm
