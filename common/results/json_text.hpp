#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace crsm {

/// As text. Names of files and channels need not be UTF-8, which JSON is: bytes that are none become the sign for that.
/// Json: nlohmann::json or nlohmann::ordered_json.
template <class Json = nlohmann::json>
std::string ToText(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace crsm
