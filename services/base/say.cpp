#include "services/base/say.hpp"

#include <cstdio>

#include "services/base/printable.hpp"

namespace crsm {

void Say(const std::string& line) { std::fputs((WithoutControls(line) + '\n').c_str(), stderr); }

}  // namespace crsm
