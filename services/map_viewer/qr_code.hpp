#pragma once

#include <string>
#include <vector>

namespace crsm {

/// A QR code for a terminal, two rows of it in a line: half blocks, which are light where the code is light, on a dark
/// terminal. Four light modules stand around it, as the standard wants. Empty where the text is too long for a code.
/// Source: ISO/IEC 18004, by libqrencode.
std::vector<std::string> DrawQrCode(const std::string& text);

}  // namespace crsm
