#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace crsm {

/// As text. Names of files and channels need not be UTF-8, which JSON is: bytes that are none become the sign for that.
inline std::string ToText(const nlohmann::json& json, int indent = -1) {
  return json.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace crsm
