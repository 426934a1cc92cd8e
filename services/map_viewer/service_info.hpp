#pragma once

#include <nlohmann/json.hpp>

#include "services/wire/wire.hpp"

namespace crsm {

/// A process as the page shows it. silent_s: since its last status.
inline nlohmann::json DescribeService(const service_status_t& status, double silent_s) {
  nlohmann::json counters = nlohmann::json::object();
  for (std::size_t i = 0; i < status.counter_name.size(); ++i) {
    counters[status.counter_name[i]] = status.counter_value[i];
  }
  return {{"name", status.name},
          {"version", status.version},
          {"pid", status.pid},
          {"state", status.state},
          {"silent_s", silent_s},
          {"counters", std::move(counters)},
          {"p50_ms", status.latency_p50_ms},
          {"p99_ms", status.latency_p99_ms},
          {"max_ms", status.latency_max_ms},
          {"resident_mb", status.resident_mb}};
}

}  // namespace crsm
