#pragma once

#include <map>
#include <string>

namespace crsm {

/// The texts of the built-in worlds by name, as ParseWorld reads them.
const std::map<std::string, const char*>& BuiltInWorlds();

}  // namespace crsm
