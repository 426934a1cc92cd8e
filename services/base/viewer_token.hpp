#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace crsm {

/// The environment variable that hands a token to map_viewer. Other users of this host can read the flags of a
/// process, but not its environment.
inline constexpr const char* kViewerTokenVariable = "CRSM_VIEWER_TOKEN";

/// A token that nobody guesses: 32 hexadecimal digits, in lower case.
std::string DrawViewerToken();

/// Whether a text has the form of such a token.
bool IsViewerToken(std::string_view text);

/// The token in the environment; nothing if the variable is not set, or empty. Throws UsageError that names the
/// variable, and not its value, if it has another form.
std::optional<std::string> ReadViewerToken();

}  // namespace crsm
