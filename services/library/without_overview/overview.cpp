#include "services/library/overview.hpp"

namespace crsm_slam {

std::function<std::string(const crsm::Results&)> OverviewEncoder() { return {}; }

}  // namespace crsm_slam
