#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace crsm {

/// Turns compressed bytes into what they were, piece by piece. Several streams behind one another are one.
class Unpacker {
 public:
  enum class State {
    kGoesOn,
    kWhole,   ///< a stream has ended, and nothing is left of what came
    kDamaged  ///< the bytes are none of this compression; the last that was given may be wrong, too
  };

  virtual ~Unpacker() = default;

  /// Takes bytes off the front of `packed` and fills the front of `to`, which begin behind them afterwards. Where
  /// neither moves on, one of the two is at its end.
  virtual State Go(std::string_view& packed, std::span<char>& to) = 0;
};

/// compression: "bz2", "gzip", "lz4" (frames), "xz" or "zstd"; nothing for another one.
std::unique_ptr<Unpacker> MakeUnpacker(std::string_view compression);

/// By how a file begins: the name of its compression, or nothing where it has none that is known.
std::string FindCompression(std::string_view start);

}  // namespace crsm
