#include "services/map_viewer/qr_code.hpp"

#include <qrencode.h>

#include <array>
#include <memory>

namespace crsm {

std::vector<std::string> DrawQrCode(const std::string& text) {
  constexpr int kMargin = 4;  // modules
  const std::unique_ptr<QRcode, decltype(&QRcode_free)> code(QRcode_encodeString8bit(text.c_str(), 0, QR_ECLEVEL_L),
                                                             &QRcode_free);
  if (!code) return {};
  const auto IsLight = [&](int row, int column) {
    if (row < 0 || column < 0 || row >= code->width || column >= code->width) return true;
    return (code->data[row * code->width + column] & 1) == 0;
  };
  const int end = code->width + kMargin;
  std::vector<std::string> lines;
  for (int row = -kMargin; row < end; row += 2) {
    constexpr std::array<const char*, 4> kBlocks{" ", "\u2584", "\u2580", "\u2588"};  // dark, lower, upper, both light
    std::string& line = lines.emplace_back();
    for (int column = -kMargin; column < end; ++column) {
      const bool lower = row + 1 < end && IsLight(row + 1, column);
      line += kBlocks[(IsLight(row, column) ? 2U : 0U) + (lower ? 1U : 0U)];
    }
  }
  return lines;
}

}  // namespace crsm
