#include "services/library/overview.hpp"

#include "common/results/pictures.hpp"

namespace crsm_slam {

std::function<std::string(const crsm::Results&)> OverviewEncoder() {
  return [](const crsm::Results& results) { return crsm::EncodeOverview(results); };
}

}  // namespace crsm_slam
