#include "services/sources/study_laser.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "common/diagnosis/handedness.hpp"
#include "common/diagnosis/range_study.hpp"
#include "common/diagnosis/sweep_study.hpp"
#include "common/math/trigonometry.hpp"
#include "common/scan/valid_rays.hpp"
#include "services/base/printable.hpp"
#include "services/base/process.hpp"
#include "services/diagnosis/study_text.hpp"
#include "services/sources/devices/live_laser.hpp"
#include "services/sources/open_laser_source.hpp"

namespace crsm {
namespace {

constexpr std::size_t kForRanges = 300;  // scans

struct FirstScans {
  std::vector<LaserScan> scans;
  std::string odometry;  ///< as of LaserSource::OdometryName
};

FirstScans ReadFirstScans(const std::string& log, const CommandLine& command_line, std::size_t most) {
  const auto source = OpenLaserSource(log, SourceOptionsOf(command_line));
  std::vector<LaserScan> scans;
  while (auto scan = source->Next()) {
    scans.push_back(std::move(*scan));
    if (scans.size() >= most) break;
  }
  return {std::move(scans), source->OdometryName()};
}

/// Whether the scans of a log are mirror images as they were sent.
struct MirrorFinding {
  std::optional<bool> is_mirrored = std::nullopt;  ///< nothing where nothing tells
  std::string why = {};                            ///< in words for people, where something does
  bool is_against_tf = false;
};

/// Odometry tells, whether or not it is used, and where it does not, TF. Reads until odometry has told, and all where
/// it never does, unless the first scans have none.
MirrorFinding StudyMirror(const std::string& log, const CommandLine& command_line) {
  using Verdict = HandednessJudge::Verdict;
  constexpr int kForOdometry = 300;  // scans
  SourceOptions options = SourceOptionsOf(command_line);
  options.messages.mirrored = false;
  const auto source = OpenLaserSource(log, options);
  HandednessJudge judge;
  bool has_odometry = false;
  for (int i = 0; judge.verdict() == Verdict::kUnknown; ++i) {
    const auto scan = source->Next();
    if (!scan || StopRequested() || (!has_odometry && i == kForOdometry)) break;
    const auto T_odom_robot = source->Odometry();
    has_odometry = has_odometry || T_odom_robot;
    judge.Add(*scan);
    judge.Add(Odometry{scan->utime, T_odom_robot});
  }
  const bool is_upside_down = source->IsUpsideDown();
  switch (judge.verdict()) {
    case Verdict::kMirrored:
      return {true, "the scans turn in the opposite direction to the odometry"};
    case Verdict::kRight:
      return {false, fmt::format("the scans turn as the odometry does{}", is_upside_down ? ", against TF" : ""),
              is_upside_down};
    case Verdict::kUnknown:
      break;
  }
  return is_upside_down ? MirrorFinding{true, "the scans are of a laser that hangs upside down by TF"}
                        : MirrorFinding();
}

/// What became of mirrored scans, for the line.
std::string StudyHandedness(const std::string& log, CommandLine& command_line) {
  const MirrorFinding finding = StudyMirror(log, command_line);
  const bool was_mirrored = command_line.settings().mirrored;
  const bool is_mirrored = finding.is_mirrored.value_or(was_mirrored);
  const bool is_typed = command_line.WasTyped("mirrored");
  if (is_mirrored == was_mirrored && (is_typed || !finding.is_against_tf)) return "";
  if (is_typed) return fmt::format("; {}: remove {}", finding.why, was_mirrored ? "--mirrored" : "--no-mirrored");
  command_line.Correct("mirrored", is_mirrored ? "true" : "false");
  return fmt::format("; {}: they are {}", finding.why,
                     is_mirrored ? "turned round (--no-mirrored leaves them as they are)" : "left as they are");
}

/// hits_a_scan: of most scans. A driver may have more places for beams than the laser has beams.
std::string DescribeBeams(const LaserScan& scan, double hits_a_scan) {
  const std::size_t num_beams = scan.ranges_m.size();
  std::string text = fmt::format("{} beams over {:.0f} degrees", num_beams, ViewOf(scan) * 180.0 / kPi);
  const bool most_are_empty = 2.0 * hits_a_scan < static_cast<double>(num_beams);
  if (most_are_empty) text += fmt::format(", of which about {:.0f} measure anything", hits_a_scan);
  return text;
}

/// What became of the ranges, for the line.
std::string DescribeReach(const RangeFinding& finding, CommandLine& command_line) {
  constexpr double kMany = 0.2;  // of all hits
  const ScanParameters& parameters = command_line.parameters().scan;
  std::string text = fmt::format("hits to {:.4g} m", finding.reach_m);
  if (finding.no_return_is_hit) {
    text += ", and " + DescribeNoReturn(finding);
    if (command_line.WasGiven("range_max_m")) {
      text += fmt::format(", which --range-max-m {} takes for hits", parameters.range_max_m);
    } else {
      command_line.Correct("range_max_m", fmt::format("{:.4f}", finding.RangeMax()));
      text += fmt::format(": range_max_m {}", parameters.range_max_m);
    }
  }
  if (finding.beyond_share > kMany) {
    text += fmt::format("; {} leaves out {:.0f} % of the hits, which lie beyond it",
                        command_line.WhoSaid("range_max_m"), 100.0 * finding.beyond_share);
  }
  return text;
}

/// What became of the beams' times, for the line. --sweep-s, --no-beam-times and what a map was made with stay.
std::string StudyTimes(std::span<const LaserScan> scans, CommandLine& command_line) {
  const ScanParameters& parameters = command_line.parameters().scan;
  if (!command_line.WasGiven("sweep_s") && command_line.WasGiven("beam_times") && !parameters.beam_times &&
      parameters.sweep_s == 0.0) {
    return "";
  }
  const auto finding = StudySweep(scans, command_line.parameters());
  if (!finding) return "";
  const bool has_times = parameters.beam_times && !scans.front().times_s.empty();
  const std::string who = has_times ? "its messages say" : command_line.WhoSaid("sweep_s") + " says";
  const std::string text = "; " + DescribeSweep(*finding, scans.front(), who);
  if (!finding->agrees() && command_line.WasGiven("sweep_s")) {
    return text + fmt::format(": {} stays", command_line.WhoSaid("sweep_s"));
  }
  if (!finding->agrees()) {
    command_line.Correct("sweep_s", fmt::format("{:.4f}", finding->sweep_s));
    command_line.Correct("beam_times", "false");
  }
  return text + (finding->sweep_s == 0.0 ? ": not corrected" : ": corrected");
}

}  // namespace

void StudyLaser(const std::string& log, CommandLine& command_line) {
  if (ParseDevice(log)) return;
  const auto [scans, odometry] = ReadFirstScans(log, command_line, DiagnosisConstants::SweepStudy{}.num_scans);
  if (scans.empty()) return;
  const RangeFinding finding =
      StudyRanges(std::span(scans).first(std::min(scans.size(), kForRanges)), command_line.parameters().scan);
  std::string line = DescribeBeams(scans.front(), finding.hits_a_scan) + ", " + DescribeReach(finding, command_line);
  line += StudyTimes(scans, command_line);
  if (odometry.empty()) {
    line += "; its first scans have no odometry";
  } else {
    line += fmt::format("; its odometry ({}) is {}used", MakePrintable(odometry),
                        command_line.settings().odometry ? "" : "not ");
  }
  line += StudyHandedness(log, command_line);
  Say(fmt::format("{}: {}: {}", command_line.program(), log, line));
}

bool FindMirrored(const std::string& log, const CommandLine& command_line) {
  const bool is_set = command_line.settings().mirrored;
  return command_line.WasTyped("mirrored") ? is_set : StudyMirror(log, command_line).is_mirrored.value_or(is_set);
}

LaserScan ScanCorrection::Apply(LaserScan scan) const {
  std::ranges::replace_if(
      scan.ranges_m, [this](float each_m) { return each_m >= range_m; }, 0.0f);
  return is_mirrored ? Mirror(std::move(scan)) : scan;
}

ScanCorrection StudyFurtherLog(const std::string& log, const CommandLine& command_line) {
  ScanCorrection correction;
  const auto SayOf = [&](const std::string& finding) {
    Say(fmt::format("{}: {}: {} in this log", command_line.program(), log, finding));
  };
  if (!command_line.WasTyped("range_max_m")) {
    const RangeFinding finding =
        StudyRanges(ReadFirstScans(log, command_line, kForRanges).scans, command_line.parameters().scan);
    if (finding.no_return_is_hit) {
      correction.range_m = static_cast<float>(LargestUsableRange({.range_max_m = finding.RangeMax()}));
      SayOf(DescribeNoReturn(finding) + ": not taken for hits");
    }
  }
  if (command_line.WasTyped("mirrored")) return correction;
  const bool is_turned = command_line.settings().mirrored;  // as the first log is
  const MirrorFinding finding = StudyMirror(log, command_line);
  correction.is_mirrored = finding.is_mirrored.value_or(is_turned) != is_turned;
  if (correction.is_mirrored) {
    SayOf(fmt::format("{}: they are {}", finding.why, is_turned ? "left as they are" : "turned round"));
  }
  return correction;
}

}  // namespace crsm
