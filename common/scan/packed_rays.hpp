#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/scan/valid_rays.hpp"

namespace crsm {

/// The rays of a scan for as long as a map is kept, in a third of the memory or less: exact, and without the times at
/// which they were measured. Copies share them.
class PackedRays {
 public:
  PackedRays() = default;
  PackedRays(const ValidRays& rays);  // NOLINT(google-explicit-constructor): the same in less room

  /// They share the angles of beams with those of another scan, if that has them, and they do not know these already: a
  /// laser's beams are the same in each scan, unless it is deskewed.
  void ShareAngles(const PackedRays& other);

  std::size_t size() const { return packed_ ? packed_->num_rays : 0; }
  ValidRays Unpack() const;
  /// What they take of memory, but for what they share with others [bytes].
  std::size_t num_bytes() const;

  friend bool operator==(const PackedRays& a, const PackedRays& b) {
    return a.packed_ == b.packed_ || a.Unpack() == b.Unpack();
  }

 private:
  using Angles = std::shared_ptr<const std::vector<float>>;  // rising

  struct Packed {
    std::size_t num_rays = 0;
    Angles angle_rad;                      ///< of all beams
    std::vector<std::uint64_t> has_range;  ///< by beam: a bit each
    std::vector<std::uint16_t> range_mm;   ///< of whole millimetres ...
    std::vector<float> range_m;            ///< ... or of any
  };

  std::shared_ptr<const Packed> packed_;
};

}  // namespace crsm
