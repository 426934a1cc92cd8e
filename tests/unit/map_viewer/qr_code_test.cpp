#include "services/map_viewer/qr_code.hpp"

#include <algorithm>

#include "catch.hpp"

namespace crsm {
namespace {

/// Rows of modules, true for a dark one, back from half blocks.
std::vector<std::vector<bool>> ReadModules(const std::vector<std::string>& lines) {
  std::vector<std::vector<bool>> rows;
  for (const std::string& line : lines) {
    auto& upper = rows.emplace_back();
    std::vector<bool> lower;
    for (std::size_t at = 0; at < line.size();) {
      const std::string block = line[at] == ' ' ? " " : line.substr(at, 3);
      at += block.size();
      upper.push_back(block == " " || block == "▄");
      lower.push_back(block == " " || block == "▀");
    }
    rows.push_back(lower);
  }
  return rows;
}

}  // namespace

TEST_CASE("a QR code has three finders in its corners, and four light modules around") {
  const auto rows = ReadModules(DrawQrCode("http://192.168.1.2:8765/#token=0123456789abcdef0123456789abcdef"));
  constexpr std::size_t kMargin = 4;
  constexpr std::size_t kFinder = 7;
  const std::size_t num = rows.front().size();
  REQUIRE(num > 2 * kMargin);
  const std::size_t width = num - 2 * kMargin;
  CHECK(width % 4 == 1);            // 17 + 4 * version, ISO/IEC 18004
  REQUIRE(rows.size() == num + 1);  // an odd number of rows in pairs
  for (const auto& row : rows) REQUIRE(row.size() == num);
  for (std::size_t row = 0; row < num; ++row) {
    for (std::size_t column = 0; column < num; ++column) {
      const bool is_margin = row < kMargin || column < kMargin || row >= kMargin + width || column >= kMargin + width;
      if (is_margin) REQUIRE_FALSE(rows[row][column]);
    }
  }
  // A dark ring of 7 x 7 modules, a light one in it, and a dark square of 3 x 3 in that.
  const auto IsFinder = [&](std::size_t top, std::size_t left) {
    for (std::size_t i = 0; i < kFinder; ++i) {
      for (std::size_t j = 0; j < kFinder; ++j) {
        const std::size_t ring = std::min({i, j, kFinder - 1 - i, kFinder - 1 - j});
        if (rows[top + i][left + j] != (ring != 1)) return false;
      }
    }
    return true;
  };
  const std::size_t far = kMargin + width - kFinder;
  CHECK(IsFinder(kMargin, kMargin));
  CHECK(IsFinder(kMargin, far));
  CHECK(IsFinder(far, kMargin));
  CHECK_FALSE(IsFinder(far, far));
}

TEST_CASE("what is too long for a QR code has none") {
  CHECK(DrawQrCode(std::string(4000, 'x')).empty());  // the largest one holds 2953 bytes
  CHECK(DrawQrCode("").empty());
}

}  // namespace crsm
