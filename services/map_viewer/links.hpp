#pragma once

#include <string>
#include <vector>

#include "services/map_viewer/access.hpp"

namespace crsm {

/// The addresses of this host's interfaces, under which another host may reach it: of those that are up, without the
/// loopback and without link-local addresses, which need a zone that no browser takes. IPv4 first.
std::vector<std::string> ListInterfaceAddresses();

/// The links to a viewer, with its token if it has one. One that listens everywhere (0.0.0.0, [::]) has a link for each
/// of the `interfaces` that can reach it; without any, it has the loopback's.
std::vector<std::string> MakeLinks(const HttpAddress& listens_at, const std::string& token,
                                   const std::vector<std::string>& interfaces);

}  // namespace crsm
