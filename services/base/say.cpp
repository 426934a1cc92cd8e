#include "services/base/say.hpp"

#include <unistd.h>

#include <cstdio>

#include "services/base/printable.hpp"

namespace crsm {

void Say(const std::string& line) {
  static const bool is_terminal = isatty(STDERR_FILENO) == 1;  // where the line of a Progress may stand
  std::fputs(((is_terminal ? "\r\033[K" : "") + WithoutControls(line) + '\n').c_str(), stderr);
}

}  // namespace crsm
