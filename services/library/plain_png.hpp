#pragma once

#include <string>

#include "common/map/dense_grid.hpp"

namespace crsm {

/// The pixels of EncodeMap as a PNG that needs no library: each row less the one above it, and runs of what is the same
/// shortened; up to three times as large. At least one cell. Source: PNG (Third Edition), 5, 9 and 10; RFC 1951, 3.2.6.
std::string EncodePlainMap(const DenseGrid& grid);

}  // namespace crsm
