#pragma once

#include <functional>
#include <optional>

#include "common/scan/critical_rays.hpp"
#include "common/scan/laser_scan.hpp"
#include "services/bus/service.hpp"
#include "services/diagnosis/laser_frames.hpp"
#include "services/diagnosis/laser_watch.hpp"
#include "services/stages/scan_queue.hpp"

namespace crsm {

/// What a process is that picks critical rays, whatever picks them: LASER, or --laser-channel, -> CRITICAL_RAYS. A
/// laser may speak any type that the program knows (laser_types.hpp). A scan that comes once more gets its last answer
/// once more, so that a message lost on the way costs time and nothing else. It also watches the laser, and says what
/// is wrong with it.
class SelectorStage {
 public:
  using Select = std::function<CriticalRays(const LaserScan&)>;

  SelectorStage(const CommandLine& command_line, Select select);

  /// Until a signal asks to end.
  void Run();

 private:
  void Answer(const LaserScan& scan);

  Service service_;
  Select select_;
  LaserWatch watch_;
  LaserFrames frames_;
  ScanQueue<LaserScan> scans_;
  std::optional<critical_rays_t> last_answer_;
};

}  // namespace crsm
