#include "common/graph/default_loop_closer.hpp"

#include "common/graph/submap_loop_closer.hpp"

namespace crsm {

MakeLoopCloser DefaultLoopCloser(const LoopParameters& parameters, const DrawingRules& drawing,
                                 const GraphConstants& constants, const MatchConstants& match) {
  return [=] { return std::make_unique<SubmapLoopCloser>(parameters, drawing, constants, match); };
}

}  // namespace crsm
