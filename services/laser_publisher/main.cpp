// laser_publisher: a log or a simulated world -> LASER, and its ODOMETRY where it has some, in real time, N times that,
// or in lockstep with the map; or a laser -> LASER, as it measures. With a file:// URL it writes an LCM log.

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "common/logs/left_out.hpp"
#include "services/base/backoff.hpp"
#include "services/base/printable.hpp"
#include "services/base/progress.hpp"
#include "services/base/stall_watch.hpp"
#include "services/base/usage_error.hpp"
#include "services/bus/service.hpp"
#include "services/diagnosis/laser_silence.hpp"
#include "services/laser_publisher/log_writer.hpp"
#include "services/laser_publisher/position.hpp"
#include "services/sources/open_laser_source.hpp"
#include "services/wire/conversions.hpp"

namespace crsm {
namespace {

constexpr double kAsFastAsMapped = 0.0;

void PrintCounts(const CommandLine& command_line, const std::string& source_name, const LaserSource& source) {
  const std::string& program = command_line.program();
  const std::string cut = DescribeCut(source_name, source);
  if (!cut.empty()) Say(fmt::format("{}: {}", program, cut));
  for (const auto& [name, count] : source.Counts()) {
    if (count > 0 && name != "truncated") Say(fmt::format("{}: {}: {}", program, name, count));
  }
  for (const std::string& complaint : source.Complaints()) {
    Say(fmt::format("{}: {}", program, MakePrintable(complaint)));
  }
  if (!command_line.settings().odometry) return;
  for (const std::string& line : DescribeOdometry(source_name, source)) Say(fmt::format("{}: {}", program, line));
}

/// Who maps the scans later has no TF that tells.
void SayIfUpsideDown(const CommandLine& command_line, const std::string& name, const LaserSource& source) {
  if (!source.IsUpsideDown() || command_line.settings().mirrored || command_line.WasTyped("mirrored")) return;
  Say(fmt::format("{}: {}: the laser hangs upside down by TF: --mirrored turns its scans round", command_line.program(),
                  name));
}

/// What cannot be meant for a laser.
void CheckNothingIsOfALog(const CommandLine& command_line) {
  for (const char* flag :
       {"rate", "resend_s", "laser_channel", "laser_frame", "position", "odometry_topic", "odometry"}) {
    if (!command_line.WasGiven(flag)) continue;
    throw UsageError(fmt::format("{}: applies to logs only; remove it for a laser", FlagOf(flag)));
  }
}

class LaserPublisher {
 public:
  LaserPublisher(const CommandLine& command_line, LaserSource& source)
      : with_odometry_(command_line.settings().odometry && !source.IsLive()),
        rate_(ParseRate(command_line.settings().rate)),
        resend_(command_line.settings().resend_s),
        source_(source),
        service_(command_line),
        position_(command_line.settings().position),
        progress_(command_line.program()) {
    service_.TakeRole(kPublisherRole);
    service_.bus().SubscribeToOne<map_delta_t>(kMapDeltaChannel, kMapOwnerRole, [this](const map_delta_t& delta) {
      if (delta.utime == awaited_utime_) mapped_ = true;
    });
    service_.bus().SubscribeToOne<scan_answer_t>(
        kScanAnswerChannel, kMapOwnerRole, [this](const scan_answer_t& answer) {
          const bool of_match = answer.requester == 0 && answer.num_matches == 1;
          if (of_match && answer.utime == awaited_utime_) mapped_ = true;
        });
  }

  void Run() {
    CatchSignals();
    Say(service_.name() + ": ready");
    service_.SetState("publishing");
    source_.IsLive() ? RunLive() : RunLog();
    service_.SetState(kPublisherFinished);
    service_.PublishStatus();  // the last counts
    progress_.Finish(num_scans_);
  }

 private:
  /// A laser is not waited for by anybody, nor held up.
  void RunLive() {
    while (!StopRequested()) {
      const auto scan = source_.Poll(std::chrono::milliseconds(50));
      if (scan) Publish(*scan);
      CountWhatWasLeftOut();
      service_.Spin(0);
    }
  }

  void RunLog() {
    std::int64_t last_utime = 0;
    SkipPublished();
    while (const auto scan = source_.Next()) {
      if (StopRequested()) break;
      if (rate_ == kAsFastAsMapped) {
        PublishUntilMapped(*scan);
      } else {
        if (num_scans_ > 0) SleepUntilDue(scan->utime - last_utime);
        if (StopRequested()) break;  // the scan is not due
        ExpectMapOf(scan->utime);
        Publish(*scan);
      }
      if (StopRequested()) break;  // the scan may not be in the map
      position_.Advance();
      last_utime = scan->utime;
      progress_.Show([this] { return source_.Progress(); }, num_scans_);
    }
    if (rate_ != kAsFastAsMapped && num_scans_ > 0) AwaitMap();
    CountWhatWasLeftOut();
  }

  void CountWhatWasLeftOut() {
    for (const auto& [name, count] : source_.Counts()) service_.counters().Set(name, count);
    service_.SetNumLeftOut(CountLeftOut(source_.Counts()));
  }

  /// What an earlier process with the same --position has sent. It may have died behind one scan more: that is known to
  /// be in the map, as every scan that comes twice.
  void SkipPublished() {
    for (std::int64_t i = 0; i < position_.num_scans() && !StopRequested(); ++i) {
      if (source_.Next() || StopRequested()) continue;
      throw std::runtime_error(fmt::format(
          "the log has {} scans, but {} of it were published before: it is another one", i, position_.num_scans()));
    }
    if (position_.num_scans() > 0) {
      Say(fmt::format("{}: continues after {} published scans", service_.name(), position_.num_scans()));
    }
  }

  void Publish(const LaserScan& scan) {
    const auto start = Clock::now();
    service_.bus().Together([&] {
      Send(scan);
      if (const auto T_map_laser = source_.TruePose()) {
        service_.bus().Publish(kTruePoseChannel, ToPoseMessage(scan.utime, *T_map_laser));
      }
    });
    service_.RecordLatency(start);
    service_.counters().Add("published");
    ++num_scans_;
  }

  /// The odometry goes first: it is there when the rays of the scan come. In lockstep it is waited for.
  void Send(const LaserScan& scan) {
    has_odometry_ |= with_odometry_ && (rate_ == kAsFastAsMapped || source_.Odometry());
    if (has_odometry_) service_.bus().Publish(kOdometryChannel, ToMessage(Odometry{scan.utime, source_.Odometry()}));
    AsLaserMessage(scan, [this](const auto& message) { service_.bus().Publish(kLaserChannel, message); });
  }

  /// Lockstep: sends the scan again and again until its map has come. A message lost on the way, or a process that is
  /// started anew, costs time and nothing else. The pause doubles each time, up to 2 s: where the network is slow, more
  /// messages make it no faster.
  void PublishUntilMapped(const LaserScan& scan) {
    ExpectMapOf(scan.utime);
    Publish(scan);
    Backoff resend(std::chrono::duration_cast<Clock::duration>(resend_));
    resend.Restart(Clock::now());
    while (!mapped_ && !StopRequested()) {
      service_.Spin(20);
      if (!mapped_ && resend.Due(Clock::now())) {
        Send(scan);
        service_.counters().Add("resent");
      }
      stall_watch_.Look({"the map of scan {} (are ray_selector, rrhc_matcher and map_updater running?)", scan.utime},
                        Clock::now());
    }
  }

  void ExpectMapOf(std::int64_t utime) {
    awaited_utime_ = utime;
    mapped_ = false;
  }

  /// Live: the time between two scans as it was recorded, over the rate. No time difference is trusted unchecked: one
  /// that goes back is none, and a recorder that paused is not waited for.
  void SleepUntilDue(std::int64_t gap_us) {
    constexpr double kLongestGap_s = 5.0;
    const double gap_s = std::clamp(static_cast<double>(gap_us) * 1e-6, 0.0, kLongestGap_s);
    due_ = std::max(due_, Clock::now() - std::chrono::seconds(1));  // a publisher that fell far behind does not rush
    due_ += std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(gap_s / rate_));
    while (Clock::now() < due_ && !StopRequested()) {
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(due_ - Clock::now()).count();
      service_.Spin(static_cast<int>(std::clamp<std::int64_t>(left, 0, 50)));
    }
  }

  /// Gives the stages behind the time to finish the last scan.
  void AwaitMap() {
    const auto give_up = Clock::now() + std::chrono::seconds(2);
    while (!mapped_ && Clock::now() < give_up && !StopRequested()) service_.Spin(20);
  }

  bool with_odometry_;
  bool has_odometry_ = false;  ///< so far; also where scans say that they have none
  double rate_;
  std::chrono::duration<double> resend_;
  LaserSource& source_;
  Service service_;
  Position position_;
  Progress progress_;
  std::int64_t num_scans_ = 0;       ///< of this process
  std::int64_t awaited_utime_ = -1;  ///< of the scan that was published last, ...
  bool mapped_ = false;              ///< ... and whether its map has come
  StallWatch stall_watch_{service_.name(), Say};
  Clock::time_point due_ = Clock::now();
};

}  // namespace
}  // namespace crsm

int main(int argc, char** argv) {
  crsm::CommandLine command_line(
      "laser_publisher",
      "Publishes the scans of a log, of a simulated world or of a laser on LASER. With --lcm-url "
      "\"file://run.lcm?mode=w\" it writes them to an LCM log.",
      crsm::FlagsOfPublisher());
  std::string name;
  command_line.AddWord("SOURCE", name, crsm::DescribeSources());
  if (const auto exit_code = command_line.Parse(argc, argv)) return *exit_code;
  return crsm::RunMain(command_line.program(), [&] {
    const crsm::Settings& settings = command_line.settings();
    const auto source = crsm::OpenLaserSource(name, crsm::SourceOptionsOf(command_line));
    if (source->IsLive()) crsm::CheckNothingIsOfALog(command_line);
    crsm::SayIfUpsideDown(command_line, name, *source);
    if (settings.lcm_url.rfind("file://", 0) == 0) {
      crsm::WriteLog(*source, name, settings.lcm_url, settings.channel_prefix, settings.odometry);
    } else {
      crsm::LaserPublisher(command_line, *source).Run();
    }
    crsm::PrintCounts(command_line, name, *source);
  });
}
