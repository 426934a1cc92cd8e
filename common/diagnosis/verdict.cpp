#include "common/diagnosis/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/math/trigonometry.hpp"

namespace crsm {
namespace {

using Constants = DiagnosisConstants::Verdict;

double Share(std::int64_t part, std::int64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

void Warn(Verdict& verdict, Trust trust, std::string text) {
  verdict.trust = std::max(verdict.trust, trust);
  verdict.warnings.push_back(std::move(text));
}

/// Two decimals, rounded down: what is below a threshold must not read as the threshold.
double RoundDown(double share) { return std::floor(100.0 * share + 1e-9) / 100.0; }

constexpr const char* kTooFewScans = "likely too few scans per second for the motion, or scans out of order";

void JudgeRays(const Constants& constants, Verdict& verdict) {
  const auto& values = verdict.values;
  if (values.counts.scans() == 0) return Warn(verdict, Trust::kBad, "no scan came");
  const double share = Share(values.counts.without_rays, values.counts.scans());
  if (share <= constants.most_lost) return;
  Warn(verdict, share > constants.mostly_blind ? Trust::kBad : Trust::kDoubtful,
       fmt::format("{:.0f} % of the scans have no rays: likely a wrong --preset or --range-max-m, or ranges that are "
                   "not in metres",
                   100.0 * share));
}

/// From one place wrong angles and ranges cannot be told from right ones.
void JudgeStanding(const Constants& constants, Verdict& verdict) {
  const auto& values = verdict.values;
  std::string text = fmt::format(
      "the laser hardly moved ({:.2f} m and {:.0f} degrees at most): the map shows what it sees from one place",
      values.furthest_m, values.furthest_rad * 180.0 / kPi);
  if (values.mean_fitness >= constants.fair_fitness) return verdict.notes.push_back(std::move(text));
  Warn(verdict, Trust::kDoubtful,
       text + fmt::format(", and the low fitness ({:.2f}) tells nothing: drive, to have the map checked",
                          RoundDown(values.mean_fitness)));
}

bool IsStanding(const RunStatistics::Values& values, const Constants& constants) {
  return values.steps > 0 && values.furthest_m < constants.stands_within_m &&
         values.furthest_rad < constants.stands_within_rad;
}

bool Jumps(const RunStatistics::Values& values, const Constants& constants) {
  return Share(values.far_steps, values.steps) > constants.many_far_steps;
}

void JudgeFit(const Constants& constants, Verdict& verdict) {
  const auto& values = verdict.values;
  if (IsStanding(values, constants)) return JudgeStanding(constants, verdict);
  if (values.mean_fitness >= constants.fair_fitness) return;
  // Outdoors, and with a scan a metre, scans of right maps fit badly too, but their rays agree with the map.
  const bool agrees = verdict.agreement.value_or(0.0) >= constants.least_agreement;
  Warn(verdict, values.mean_fitness < constants.least_fitness && !agrees ? Trust::kBad : Trust::kDoubtful,
       fmt::format("the scans fit the map badly (mean fitness {:.2f}; correct maps have {} or more): {}",
                   RoundDown(values.mean_fitness), constants.fair_fitness,
                   Jumps(values, constants)
                       ? fmt::format("{}, or angles in degrees", kTooFewScans)
                       : "likely wrong angles (--angle-scale), noisy ranges, or the preset of another laser"));
}

void JudgeAgreement(const Constants& constants, Verdict& verdict) {
  if (!verdict.agreement || *verdict.agreement >= constants.fair_agreement) return;
  const std::string text =
      fmt::format("the scans contradict the map: only {:.0f} % of their rays pass through free space and end at walls",
                  100.0 * RoundDown(*verdict.agreement));
  if (verdict.values.finished_map) {
    return Warn(verdict, Trust::kDoubtful,
                text + ": likely much has changed there since, or the robot was found where it is not");
  }
  const std::string cause = IsStanding(verdict.values, constants) ? "likely wrong ranges, or things that moved"
                            : Jumps(verdict.values, constants)
                                ? kTooFewScans
                                : "likely wrong angles (--angle-scale), wrong ranges, or one room drawn over another "
                                  "after a wrong match";
  Warn(verdict, *verdict.agreement < constants.least_agreement ? Trust::kBad : Trust::kDoubtful,
       fmt::format("{} (correct maps have {:.0f} % or more): {}", text, 100.0 * constants.fair_agreement, cause));
}

bool IsInPieces(const ScanCounts& counts, const Constants& constants) {
  return counts.floating > 0 && Share(counts.on_map, counts.on_map + counts.floating) < constants.least_on_largest;
}

void JudgeBridges(const MapPieces& pieces, Verdict& verdict) {
  if (pieces.num_bridged == 0) return;
  Warn(
      verdict, Trust::kDoubtful,
      fmt::format("{} of {} interruptions of the track are bridged by the wheels alone, and the map behind each may be "
                  "off by what they err: drive once more where the robot was before",
                  pieces.num_bridged, pieces.num_breaks));
}

void JudgePieces(const MapPieces& pieces, const Constants& constants, Verdict& verdict) {
  if (pieces.num_breaks == 0) return;
  JudgeBridges(pieces, verdict);
  if (pieces.num_pieces <= 1 && pieces.num_bridged > 0) return;
  if (pieces.num_pieces <= 1) {
    verdict.notes.push_back(
        pieces.num_breaks == 1
            ? "the track was lost or interrupted once, and the two parts of the map were joined"
            : fmt::format("the track was lost or interrupted {} times, and all parts of the map were joined",
                          pieces.num_breaks));
    return;
  }
  const ScanCounts& counts = verdict.values.counts;
  const std::int64_t num_measured = counts.scans() - counts.without_rays;
  const std::size_t num_maps = pieces.OthersWithMap().size();
  std::string text = fmt::format(
      "the map is in {} pieces: the largest, which is shown, has {:.0f} % of the scans that measured anything",
      pieces.num_pieces, 100.0 * Share(counts.on_map, num_measured));
  if (num_maps > 0) text += fmt::format("; see pieces/ for {} more", num_maps);
  if (!IsInPieces(counts, constants)) return verdict.notes.push_back(text);
  Warn(verdict, Share(counts.on_map, num_measured) < constants.least_of_all ? Trust::kBad : Trust::kDoubtful,
       text + "; how they lie to each other is not known: drive once more where the robot was before");
}

void JudgeTrack(const Constants& constants, Verdict& verdict) {
  const auto& values = verdict.values;
  const double lost = Share(values.counts.lost, values.counts.scans());
  const double far_steps = Share(values.far_steps, values.steps);
  const bool moves_far = far_steps > constants.few_far_steps;
  if (lost > (moves_far ? constants.most_lost_in_motion : constants.most_lost)) {
    Warn(verdict, Trust::kBad,
         fmt::format("{:.0f} % of the scans are lost, and the map after them may be metres off: {}", 100.0 * lost,
                     moves_far ? kTooFewScans : "likely a wrong --preset, or a blocked view"));
  } else if (values.longest_unmatched >= constants.long_lost && !IsInPieces(values.counts, constants)) {
    Warn(verdict, Trust::kDoubtful,
         fmt::format("{} scans in a row were lost{}: the map after them may be metres off", values.longest_unmatched,
                     values.counts.without_rays > 0 ? " or had no rays" : ""));
  }
  if (far_steps > constants.many_far_steps) {
    Warn(verdict, Trust::kDoubtful,
         fmt::format(
             "in {:.0f} % of the steps the laser moved by more than 0.4 m or 0.25 rad from one scan to the next: check "
             "the map for doubled or rotated walls; more scans per second would help",
             100.0 * far_steps));
  }
}

void JudgeJumps(Verdict& verdict) {
  const auto& values = verdict.values;
  if (values.longest_jump_m == 0.0) return;
  Warn(verdict, Trust::kDoubtful,
       fmt::format(
           "the pose jumps by {:.1f} m, to x {:.0f} m, y {:.0f} m, and no robot is so fast: likely a wrong match or "
           "join, or another program that publishes poses on this bus",
           values.longest_jump_m, values.longest_jump_ends.x_m, values.longest_jump_ends.y_m));
}

void JudgeAxes(const Constants& constants, Verdict& verdict) {
  const double degenerate = Share(verdict.values.degenerate, verdict.values.counts.scans());
  if (degenerate <= constants.most_degenerate) return;
  Warn(verdict, Trust::kBad,
       fmt::format("{:.0f} % of the scans are degenerate: they do not fix the position in one direction, and lengths "
                   "in the map are unknown: likely a bare corridor, a wrong --preset or --range-max-m, or ranges "
                   "that are not in metres",
                   100.0 * degenerate));
}

bool IsContradiction(const SelfContradiction& found, const Constants& constants) {
  return (found.num_looks >= constants.few_looks && found.share > constants.most_contradict) ||
         (found.num_looks >= constants.very_few_looks && found.share > constants.most_of_few_contradict);
}

/// What was seen where the robot was twice.
void JudgeContradiction(const Constants& constants, Verdict& verdict) {
  const SelfContradiction& found = verdict.contradiction;
  if (!IsContradiction(found, constants)) return;
  std::string text = fmt::format(
      "{:.0f} % of the scans contradict others that were taken at about the same place before", 100.0 * found.share);
  if (found.worst_share > 0.0) {
    text += fmt::format(", most of all near x {:.1f} m, y {:.1f} m", found.worst_place.x_m, found.worst_place.y_m);
  }
  Warn(verdict, Trust::kDoubtful,
       text + ": check the map for doubled walls there; a loop may be missed (wheel odometry helps)");
}

/// The diagonal of the rectangle around a map [m].
double FindSize(const ByteMap& map) {
  if (map.empty()) return 0.0;
  const auto [low, high] = map.FindTiled();
  return map.geometry().cell_size_m() * std::hypot(high.x - low.x + 1, high.y - low.y + 1);
}

std::string DescribeWayBack(const std::optional<WayBack>& way_back) {
  if (!way_back) return "drive once more where the robot was before";
  const auto& [from, to, then_m] = *way_back;
  return fmt::format(
      "a drive from x {:.1f} m, y {:.1f} m to x {:.1f} m, y {:.1f} m, by another way than before, would "
      "tell most, and leave about {:.1f} m",
      from.x_m, from.y_m, to.x_m, to.y_m, then_m);
}

/// How far off the map may be, by its pose graph: a graph that is contradicted says nothing.
void JudgeMetres(const ByteMap& map, const MapPieces& pieces, const Constants& constants, Verdict& verdict) {
  if (pieces.num_pieces == 0) {
    return Warn(verdict, Trust::kDoubtful, "without loops (--no-loops) nothing tells how far off the map may be");
  }
  if (!pieces.error || pieces.num_rejected > 0 || IsContradiction(verdict.contradiction, constants)) return;
  const double size_m = FindSize(map);
  verdict.off_m = std::min(pieces.error->most_m, size_m);
  if (*verdict.off_m > constants.off_place_m) verdict.off_at = pieces.error->at;
  verdict.doubts = pieces.error->doubts;
  for (Doubt& doubt : verdict.doubts) doubt.off_m = std::min(doubt.off_m, *verdict.off_m);
  verdict.way_back = pieces.error->way_back;
  if (*verdict.off_m <= std::max(constants.far_off_m, constants.far_off_share * size_m)) return;
  Warn(verdict, Trust::kDoubtful,
       fmt::format("what the laser saw leaves the lengths of the path open by up to {:.1f} m: {} (wheel odometry, or a "
                   "laser that sees further, would tell, too)",
                   *verdict.off_m, DescribeWayBack(verdict.way_back)));
}

/// Of a step that loops have put right there is nothing to fear any more.
void NoteSlip(const MapPieces& pieces, Verdict& verdict) {
  if (!pieces.slip) return;
  verdict.notes.push_back(
      fmt::format("slip near x {:.1f} m, y {:.1f} m: one match was wrong by {:.1f} m, and loops "
                  "have put it right",
                  pieces.slip->at.x_m, pieces.slip->at.y_m, pieces.slip->off_m));
}

void JudgeOdometry(const Constants& constants, Verdict& verdict) {
  const auto& values = verdict.values;
  if (values.turns_by_odometry && *values.turns_by_odometry < constants.opposite) {
    Warn(verdict, Trust::kDoubtful,
         "the odometry turns left where the laser turns right: one of the two is mirrored; if it is the laser, the map "
         "is mirrored too");
  } else if (values.ways_by_odometry && *values.ways_by_odometry < constants.across) {
    Warn(verdict, Trust::kDoubtful,
         "the odometry and the laser move in different directions: likely the laser is mounted rotated, and the poses "
         "are the laser's, not the robot's");
  }
}

/// On a finished map there is nothing to go wrong but the poses.
void JudgeLocalization(const Constants& constants, Verdict& verdict) {
  const double lost = Share(verdict.values.counts.lost, verdict.values.counts.scans());
  if (lost <= constants.most_lost_on_map) return;
  Warn(verdict, lost > constants.mostly_lost_on_map ? Trust::kBad : Trust::kDoubtful,
       fmt::format("{:.0f} % of the scans were not found on the map: likely another building, an unmapped part of it, "
                   "or rooms that look alike (--start helps)",
                   100.0 * lost));
}

/// What has become of the scans.
std::string DescribeScans(const Verdict& verdict) {
  const auto& values = verdict.values;
  std::string text = fmt::format("{} of {} scans {}, {}", values.counts.on_map, values.counts.scans(),
                                 values.finished_map ? "found on the map" : "mapped", DescribeOthers(values.counts));
  if (verdict.left_out > 0) text += fmt::format(", {} more left out", verdict.left_out);
  text += fmt::format(", {} degenerate, mean fitness {:.2f}", values.degenerate, RoundDown(values.mean_fitness));
  if (verdict.agreement)
    text += fmt::format(", {:.0f} % of the rays agree with the map", 100.0 * RoundDown(*verdict.agreement));
  return text;
}

std::string DescribeMetres(const Verdict& verdict) {
  std::string text =
      fmt::format("parts of it may be off by up to {:.{}f} m", *verdict.off_m, *verdict.off_m < 1.0 ? 2 : 1);
  if (verdict.off_at) {
    text += fmt::format(", most likely past x {:.1f} m, y {:.1f} m", verdict.off_at->x_m, verdict.off_at->y_m);
  }
  return text;
}

void JudgeLoops(const MapPieces& pieces, Verdict& verdict) {
  if (pieces.num_rejected == 0) return;
  Warn(verdict, Trust::kDoubtful,
       fmt::format("{} of {} loops were rejected, because the rest of the path contradicts them: one of the two is "
                   "wrong, and parts of the map may be metres off",
                   pieces.num_rejected, pieces.num_closed + pieces.num_rejected));
}

/// But for what the loops say.
Verdict JudgeScans(const RunStatistics& statistics, const ByteMap& map, const MapPieces& pieces,
                   const Constants& constants) {
  Verdict verdict;
  verdict.values = statistics.values();
  verdict.agreement = statistics.ComputeMeanAgreement(map);
  verdict.contradiction = statistics.FindContradiction();
  JudgeRays(constants, verdict);
  const std::int64_t num_scans = verdict.values.counts.scans();
  if (num_scans < constants.few_scans) {
    if (num_scans > 0) Warn(verdict, Trust::kDoubtful, "too few scans to judge the map");
    return verdict;
  }
  if (verdict.values.finished_map) {
    JudgeLocalization(constants, verdict);
    JudgeAgreement(constants, verdict);
    JudgeJumps(verdict);
    return verdict;
  }
  const bool blind = verdict.trust == Trust::kBad;
  if (!blind) JudgeFit(constants, verdict);
  if (!blind) JudgeAgreement(constants, verdict);
  if (!blind) JudgeTrack(constants, verdict);
  if (!blind) JudgeJumps(verdict);
  if (!blind) JudgeAxes(constants, verdict);
  if (!blind) JudgeContradiction(constants, verdict);
  JudgeOdometry(constants, verdict);
  JudgePieces(pieces, constants, verdict);
  if (verdict.trust != Trust::kBad) JudgeMetres(map, pieces, constants, verdict);
  NoteSlip(pieces, verdict);
  return verdict;
}

}  // namespace

Verdict Judge(const RunStatistics& statistics, const ByteMap& map, const MapPieces& pieces,
              const DiagnosisConstants::Verdict& constants) {
  Verdict verdict = JudgeScans(statistics, map, pieces, constants);
  JudgeLoops(pieces, verdict);
  return verdict;
}

void JudgeWheels(const WheelModel::Values& wheels, Verdict& verdict) {
  if (!wheels.have_moved) {
    verdict.notes.emplace_back("the wheels never moved, and the laser did: they were not used");
    return;
  }
  verdict.notes.push_back(
      fmt::format("the wheels: a metre is {:.3f} m by the laser, to {:.3f} m, and a turn of 1 rad is {:.3f} rad, to "
                  "{:.3f} rad; {} of {} "
                  "steps slipped",
                  wheels.scale, wheels.way_per_m, wheels.turn_scale, wheels.turn_per_rad, wheels.slips, wheels.steps));
  if (!wheels.ContradictLaser() || verdict.values.finished_map) return;
  Warn(verdict, Trust::kDoubtful,
       fmt::format("the wheels and the laser tell different ways, {:.2f} m apart after a metre and {:.2f} rad after a "
                   "turn of 1 rad: one of the two is wrong; compare with a map made with --no-odometry",
                   wheels.way_per_m, wheels.turn_per_rad));
  verdict.off_m.reset();
  verdict.off_at.reset();
  verdict.doubts.clear();
  verdict.way_back.reset();
}

void JudgeLeftOut(const LeftOut& left_out, Verdict& verdict, const DiagnosisConstants::Verdict& constants) {
  verdict.left_out = left_out.all;
  const std::int64_t num_unusable = left_out.all - left_out.dropped;
  const std::int64_t num_scans = verdict.values.counts.scans();
  const std::int64_t num_all = num_scans + num_unusable;
  if (num_scans == 0 || Share(num_unusable, num_all) <= constants.most_left_out) return;
  Warn(verdict, Trust::kDoubtful,
       fmt::format("{} of {} scans of the recording were refused or repeated ({:.0f} %): what only they saw is not in "
                   "the map",
                   num_unusable, num_all, 100.0 * Share(num_unusable, num_all)));
}

void JudgeToldStarts(std::int64_t num, Verdict& verdict) {
  if (num == 0) return;
  verdict.notes.push_back(
      fmt::format("the robot was told where it is {} (START_POSE): the poses after that are right only if that was",
                  num == 1 ? "once" : fmt::format("{} times", num)));
}

void JudgeUnsearched(Verdict& verdict) {
  Warn(verdict, Trust::kDoubtful,
       "the run was ended while loops were still searched: what they would correct is not judged; --resume searches "
       "them");
}

const char* Name(Trust trust) {
  switch (trust) {
    case Trust::kGood:
      return "good";
    case Trust::kDoubtful:
      return "doubtful";
    case Trust::kBad:
      return "bad";
  }
  return "";
}

std::vector<std::string> FormatVerdict(const Verdict& verdict) {
  const char* meaning = verdict.trust == Trust::kGood       ? "good: no check found a fault"
                        : verdict.trust == Trust::kDoubtful ? "doubtful: look at the map before you rely on the result"
                                                            : "not to be trusted";
  const char* subject = verdict.values.finished_map ? "the poses are" : "the map is";
  std::vector<std::string> lines{DescribeScans(verdict), fmt::format("{} {}", subject, meaning)};
  if (verdict.off_m) lines.push_back(DescribeMetres(verdict));
  lines.insert(lines.end(), verdict.notes.begin(), verdict.notes.end());
  for (const std::string& warning : verdict.warnings) lines.push_back("warning: " + warning);
  return lines;
}

}  // namespace crsm
