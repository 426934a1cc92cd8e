#pragma once

#include <functional>
#include <map>
#include <optional>
#include <span>

#include "common/scan/critical_rays.hpp"
#include "common/scan/laser_scan.hpp"
#include "services/bus/service.hpp"
#include "services/diagnosis/laser_frames.hpp"
#include "services/diagnosis/laser_watch.hpp"
#include "services/stages/scan_queue.hpp"
#include "services/wire/laser_types.hpp"

namespace crsm {

/// What a process is that picks critical rays, whatever picks them: LASER, or --laser-channel, -> CRITICAL_RAYS. A
/// laser may speak any type that the program knows (laser_types.hpp). A scan that comes once more gets its last answer
/// once more, so that a message lost on the way costs time and nothing else. It also watches the laser, and says what
/// is wrong with it.
///
/// Scans of one sender are used: of the process with the publisher's role, or else of the first that is heard, until it
/// ends or falls silent. What others send on the channel is counted, and is no part of the recording.
class SelectorStage {
 public:
  using Select = std::function<CriticalRays(const LaserScan&)>;

  SelectorStage(const CommandLine& command_line, Select select);

  /// Until a signal asks to end.
  void Run();

 private:
  bool Receive(std::span<const std::uint8_t> bytes, const LaserMessageOptions& options);
  void RefuseJunk(std::span<const std::uint8_t> bytes);
  bool IsOfTheLaser();
  void CountJunk();
  void Answer(const LaserScan& scan);

  Service service_;
  Select select_;
  LaserWatch watch_;
  LaserFrames frames_;
  SoleSender laser_sender_;
  std::optional<Sender> laser_;  ///< who sends the scans that are used
  std::int64_t num_junk_ = 0;    ///< of those: messages that are no scans
  std::map<Sender, std::int64_t> junk_of_others_;
  ScanQueue<LaserScan> scans_;
  std::optional<critical_rays_t> last_answer_;
};

}  // namespace crsm
