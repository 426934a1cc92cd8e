#include "services/map_exporter/trajectory_text.hpp"

#include <algorithm>
#include <string>

#include "common/metrics/trajectory.hpp"

namespace crsm {

void TrajectoryText::Add(const ScanMatch& match) {
  std::string line;
  AppendPose({match.utime, match.T_map_laser}, line);
  const std::lock_guard lock(mutex_);
  file_.Append({reinterpret_cast<const std::uint8_t*>(line.data()), line.size()});
}

std::uint64_t TrajectoryText::num_bytes() const {
  const std::lock_guard lock(mutex_);
  return file_.size();
}

void TrajectoryText::Copy(std::uint64_t begin, std::uint64_t end, const Sink& sink) const {
  std::string piece(std::size_t{1} << 16, '\0');
  for (std::uint64_t at = begin; at < end; at += piece.size()) {
    piece.resize(std::min<std::uint64_t>(piece.size(), end - at));
    {
      const std::lock_guard lock(mutex_);
      file_.Read(at, {reinterpret_cast<std::uint8_t*>(piece.data()), piece.size()});
    }
    if (!sink(piece)) return;
  }
}

}  // namespace crsm
