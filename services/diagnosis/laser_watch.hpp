#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <string>

#include "common/diagnosis/handedness.hpp"
#include "common/diagnosis/laser_judge.hpp"
#include "services/base/line_limit.hpp"
#include "services/bus/service.hpp"
#include "services/diagnosis/laser_search.hpp"
#include "services/diagnosis/laser_silence.hpp"
#include "services/diagnosis/left_out_news.hpp"
#include "services/diagnosis/live_study.hpp"
#include "services/wire/laser_types.hpp"

namespace crsm {

/// Says on stderr, in a line that names the mend, what is wrong with a live laser: nothing on its channel, messages of
/// a wrong type or with angles in degrees, what LaserJudge and LiveStudy see in its scans, that they turn against the
/// robot's odometry where there is some, that another sender sends, too, and that it has fallen silent or is
/// back. Scans that a publisher of ours sends are not studied: who reads logs has done so.
class LaserWatch {
 public:
  /// channel: of the laser, without prefix.
  LaserWatch(Service& service, const CommandLine& command_line, std::string channel);

  /// A scan came, also one that is sent again, in a message of that type.
  void Hear(const LaserScan& scan, const LaserType& type);
  /// A scan of another laser came on the channel.
  void HearOther() { others_came_ = true; }
  /// A scan came of another sender than that whose scans are used.
  void RefuseSender(const Sender& refused, const std::optional<Sender>& used);
  /// A message came that is no scan.
  void Refuse(std::span<const std::uint8_t> bytes);

  /// Says what somebody else has found, unless it was said before or there is nothing.
  void SayOnce(const std::string& complaint);

  /// Says what is due by the clock; to be called often.
  void Poll();

 private:
  void JudgeHandedness(const LaserScan& scan, const LaserType& type);
  void SayOf(const std::string& complaint) const;
  void SaySeldom(const std::string& line, Clock::time_point now);
  void NoteArrival(Clock::time_point now);

  Service& service_;
  std::string channel_;  ///< with the prefix
  LaserMessageOptions messages_;
  LaserJudge judge_;
  std::optional<HandednessJudge> handedness_;  ///< from the first odometry until it has told
  bool handedness_told_ = false;
  LaserSilence silence_;
  LaserSearch search_;
  LiveStudy study_;
  LeftOutNews left_out_;
  std::set<std::string> said_;  ///< by SayOnce
  bool others_came_ = false;    ///< scans of other lasers
  LineLimit coming_and_going_;
};

}  // namespace crsm
