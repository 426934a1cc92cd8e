#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <map>
#include <string>
#include <string_view>

#include "services/base/printable.hpp"
#include "services/bus/service.hpp"
#include "services/wire/channels.hpp"

namespace crsm {

/// Whether the status of a process may be kept beside those that are, of a few processes only: the names come from the
/// network. Those of the stack always may. Counts and says once where not; `keeper` is what leaves it out.
template <class Status>
bool MayKeepStatus(const std::map<std::string, Status>& kept, const std::string& name, std::string_view keeper,
                   Service& service) {
  constexpr std::size_t kMostOthers = 64;
  if (IsOfStack(name) || kept.count(name) > 0 || kept.size() < kMostOthers) return true;
  service.Complain(
      "status_ignored",
      fmt::format("{}: more than {} processes say SERVICE_STATUS: {} leaves out {} and those that come later",
                  service.name(), kMostOthers, keeper, MakePrintable(name)));
  return false;
}

}  // namespace crsm
