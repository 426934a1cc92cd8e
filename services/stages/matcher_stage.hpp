#pragma once

#include <memory>
#include <optional>
#include <span>

#include "common/match/match_scan.hpp"
#include "common/match/matcher.hpp"
#include "common/scan/odometry_buffer.hpp"
#include "services/base/line_limit.hpp"
#include "services/bus/look_limiter.hpp"
#include "services/bus/service.hpp"
#include "services/diagnosis/left_out_news.hpp"
#include "services/replica/matched_map.hpp"
#include "services/stages/scan_queue.hpp"
#include "services/wire/conversions.hpp"

namespace crsm {

/// What a process is that matches scans, whatever matches them: CRITICAL_RAYS, the map so far and ODOMETRY, if there is
/// any, -> SCAN_MATCH, POSE and POSE_LOCAL.
///
/// All that a match depends on comes with messages: the rays, their odometry, the map and the tracking state from the
/// map's owner. A matcher that is started anew goes on where the last one stood. A scan that comes once more gets its
/// last answer once more, before anything else; each new one waits for the map that the last one made: without an end
/// in lockstep, else for a bounded time. On a finished map START_POSE tells where the next scan is searched.
class MatcherStage {
 public:
  MatcherStage(const CommandLine& command_line, MakeMatcher make_matcher);

  /// Until a signal asks to end.
  void Run();

  /// Names of the settings that become flags, for the command line.
  static std::vector<std::string> Settings() { return FlagsOfMatcher().settings; }

 private:
  void Receive(CriticalRays scan);
  bool ReceiveStart(std::span<const std::uint8_t> bytes);
  bool AnswerAgain(std::int64_t utime);
  bool Answer(const CriticalRays& scan);
  bool MapIsCurrent();
  bool WasAnswered(std::int64_t utime) const;
  void CheckAnswer();
  std::optional<bool> IsInMap(std::int64_t utime);
  ScanOdometry FindOdometry(std::int64_t utime);
  bool HasWaitedLong(std::int64_t utime);
  StallWatch::Awaited Awaited() const;
  void SayLeftOut();
  void Match(const CriticalRays& scan, const std::optional<Pose2>& T_odom_robot);
  void Publish(const ScanMatch& match, const Pose2& T_local_map);
  ScanMatch LastMatchAsOfNow() const;

  MatchOptions matching_;
  const crsm::Settings& settings_;
  Service service_;
  ScanQueue<CriticalRays> scans_;
  OdometryBuffer odometry_;
  bool expects_odometry_ = false;  ///< live: it has come, and since then no scan has waited for it in vain
  MakeMatcher make_matcher_;
  std::unique_ptr<Matcher> matcher_;  ///< none before the map's owner was heard
  MatchedMap map_;
  std::optional<Pose2> told_start_;                         ///< for the next scan on a finished map
  LookLimiter start_looks_{std::chrono::milliseconds(10)};  ///< at who tells it
  LineLimit start_lines_;
  std::optional<ScanMatch> last_match_;  ///< sent once more when its scan comes once more
  Pose2 T_local_map_;                    ///< of the tracking state when that was found
  Clock::time_point last_match_time_{};
  Backoff doubt_{std::chrono::milliseconds(100)};  ///< while its map does not come
  bool has_doubted_ = false;                       ///< the owner was asked for it
  LeftOutNews left_out_;                           ///< of scans that are in the map already
  StallWatch stall_watch_;
  std::optional<std::int64_t> odometry_awaited_;  ///< of the scan with this utime, which will be sent again with it
  std::int64_t held_utime_ = -1;                  ///< of the scan that waits for an answer or for its odometry, ...
  Clock::time_point held_since_{};                ///< ... and since when
};

}  // namespace crsm
