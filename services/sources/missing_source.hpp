#pragma once

#include <string>

namespace crsm {

/// Throws, in one line, for a source that is no file. UsageError: of "live", which run_stack alone maps, and of a kind
/// of laser without its port. Else std::runtime_error, with the file, world or laser that was probably meant.
[[noreturn]] void ThrowMissingSource(const std::string& name);

}  // namespace crsm
