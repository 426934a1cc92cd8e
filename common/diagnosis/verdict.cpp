#include "common/diagnosis/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/math/trigonometry.hpp"

namespace crsm {
namespace {

// Below each threshold: the extremes of the maps that are right, and of those that are wrong, in our logs and worlds.

constexpr std::int64_t kFewScans = 20;  // fewer tell nothing

// Right: 0.58 (aces) to 0.98, outdoors 0.49. Wrong by angles, ranges, order or noise: 0.02 to 0.5, a few 0.8.
constexpr double kLeastAgreement = 0.45;
constexpr double kFairAgreement = 0.5;

// Right: 0.63 (exp3) to 0.84. Scans that do not belong together: 0.21 to 0.5, a few 0.58.
constexpr double kLeastFitness = 0.5;
constexpr double kFairFitness = 0.6;

// Right: 0 to 0.01. Every 20th scan: 0.02 to 0.5; what else loses the track: 0.06 to 0.8.
constexpr double kMostLost = 0.05;
constexpr double kMostLostInMotion = 0.02;  // where the laser also moves far between scans
constexpr double kFewFarSteps = 0.03;       // right, at full rate: 0 to 0.006, and 0.13 in hall, with nothing lost

// Right: 0 to 0.18, 0.59 of a laser with a reach of 4 m. Ranges of a tenth: 0.7 to 1.
constexpr double kMostDegenerate = 0.8;

// Right: 0 to 0.13 (hall), turns of 3 rad/s 0.17 if they are deskewed, on every 5th scan up to 0.98. Wrong: 0.17 to
// 0.95.
constexpr double kManyFarSteps = 0.15;

// Right: 4. Tracks that were found again elsewhere: 10 to 770.
constexpr std::int64_t kLongLost = 20;

// Right: 244 at most (killian). A smooth corridor of 40 m, in which the robot seems to stand: 430 to 450.
constexpr std::int64_t kLongOpen = 300;

// What is not on the map is missing: a room, say. Right: 1.
constexpr double kLeastOnLargest = 0.98;
constexpr double kLeastOfAll = 0.25;  // so little of what was seen is no map of it

// Scans of about the same place, long apart along the path. Right by the mean of their errors: 0.041 at most, but for
// killian at 8 m with odometry (0.076), aces without loops (0.48) and the flat by 70 and 90 degrees (0.41). Wrong: up
// to 1, but also as little as 0.014 (aces at 8 m).
constexpr std::int64_t kFewLooks = 20;
constexpr double kMostContradict = 0.05;
constexpr std::int64_t kVeryFewLooks = 10;
constexpr double kMostOfFewContradict = 0.2;

// Where next to nothing was seen twice nothing vouches for what degenerate scans leave open. Right: 6 m at most by
// lasers that see 180 degrees and 5 m; those that see less are right with 72 m, and wrong from 9 m on.
constexpr std::int64_t kManyLooks = 200;
constexpr double kLongOpenPath_m = 8.0;

// Right: 0.34 at most, and 0.45 of a laser that sees 3.5 m in rooms around a corridor. Wrong: 0.375 and more.
constexpr double kMostOpenPath = 0.36;

// A laser that stands seems to move by 0.055 m and 0.023 rad (an RPLidar in a hall).
constexpr double kStandsWithin_m = 0.15;
constexpr double kStandsWithin_rad = 0.1;

constexpr double kMostLeftOut = 0.1;  // of the recording: that much may be a room

constexpr double kOpposite = -0.5;  // of the correlation of two motions
constexpr double kAcross = 0.5;

double Share(std::int64_t part, std::int64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

void Warn(Verdict& verdict, Trust trust, std::string text) {
  verdict.trust = std::max(verdict.trust, trust);
  verdict.warnings.push_back(std::move(text));
}

constexpr const char* kTooFewScans =
    "likely too few scans per second for the motion, scans out of order, or sweeps without deskewing (--sweep-s)";

void JudgeRays(Verdict& verdict) {
  const auto& values = verdict.values;
  if (values.scans == 0) return Warn(verdict, Trust::kBad, "no scan came");
  const double share = Share(values.without_rays, values.scans);
  if (share <= kMostLost) return;
  Warn(verdict, share > 0.5 ? Trust::kBad : Trust::kDoubtful,
       fmt::format("{:.0f} % of the scans have no rays: likely a wrong --preset or --range-max-m, or ranges that are "
                   "not in metres",
                   100.0 * share));
}

/// From one place wrong angles and ranges cannot be told from right ones.
void JudgeStanding(Verdict& verdict) {
  const auto& values = verdict.values;
  std::string text = fmt::format(
      "the laser hardly moved ({:.2f} m and {:.0f} degrees at most): the map shows what it sees from one place",
      values.furthest_m, values.furthest_rad * 180.0 / kPi);
  if (values.mean_fitness >= kFairFitness) return verdict.notes.push_back(std::move(text));
  Warn(verdict, Trust::kDoubtful,
       text + fmt::format(", and the low fitness ({:.2f}) tells nothing: drive, to have the map checked",
                          values.mean_fitness));
}

bool IsStanding(const RunStatistics::Values& values) {
  return values.steps > 0 && values.furthest_m < kStandsWithin_m && values.furthest_rad < kStandsWithin_rad;
}

bool Jumps(const RunStatistics::Values& values) { return Share(values.far_steps, values.steps) > kManyFarSteps; }

void JudgeFit(Verdict& verdict) {
  const auto& values = verdict.values;
  if (IsStanding(values)) return JudgeStanding(verdict);
  if (values.mean_fitness >= kFairFitness) return;
  // Outdoors, and with a scan a metre, scans of right maps fit badly too, but their rays agree with the map.
  const bool agrees = verdict.agreement.value_or(0.0) >= kLeastAgreement;
  Warn(verdict, values.mean_fitness < kLeastFitness && !agrees ? Trust::kBad : Trust::kDoubtful,
       fmt::format(
           "the scans fit the map badly (mean fitness {:.2f}; correct maps have 0.6 or more): {}", values.mean_fitness,
           Jumps(values) ? fmt::format("{}, or angles in degrees", kTooFewScans)
                         : "likely wrong angles (--angle-scale), noisy ranges, or the preset of another laser"));
}

void JudgeAgreement(Verdict& verdict) {
  if (!verdict.agreement || *verdict.agreement >= kFairAgreement) return;
  const char* cause = IsStanding(verdict.values) ? "likely wrong ranges, or things that moved"
                      : Jumps(verdict.values)
                          ? kTooFewScans
                          : "likely wrong angles (--angle-scale), wrong ranges, or one room drawn over another after "
                            "a wrong match";
  Warn(verdict, *verdict.agreement < kLeastAgreement ? Trust::kBad : Trust::kDoubtful,
       fmt::format("the scans contradict the map: only {:.0f} % of their rays pass through free space and end at "
                   "walls (correct maps have 58 % or more): {}",
                   100.0 * *verdict.agreement, cause));
}

/// Of all scans that were matched, those that are on the map.
double ShareOnLargest(const MapPieces& pieces) {
  return pieces.num_matched > 0 ? Share(pieces.num_matched - pieces.num_elsewhere(), pieces.num_matched) : 1.0;
}

bool IsInPieces(const MapPieces& pieces) { return pieces.num_pieces > 1 && ShareOnLargest(pieces) < kLeastOnLargest; }

void JudgeBridges(const MapPieces& pieces, Verdict& verdict) {
  if (pieces.num_bridged == 0) return;
  Warn(
      verdict, Trust::kDoubtful,
      fmt::format("{} of {} interruptions of the track are bridged by the wheels alone, and the map behind each may be "
                  "off by what they err: drive once more where the robot was before",
                  pieces.num_bridged, pieces.num_breaks));
}

void JudgePieces(const MapPieces& pieces, Verdict& verdict) {
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
  const std::size_t num_maps = pieces.OthersWithMap().size();
  std::string text = fmt::format("the map is in {} pieces: the largest has {} of {} mapped scans", pieces.num_pieces,
                                 pieces.num_matched - pieces.num_elsewhere(), pieces.num_matched);
  if (num_maps > 0) text += fmt::format("; see pieces/ for {} more", num_maps);
  if (!IsInPieces(pieces)) return verdict.notes.push_back(text);
  Warn(verdict, ShareOnLargest(pieces) < kLeastOfAll ? Trust::kBad : Trust::kDoubtful,
       text + "; how they lie to each other is not known: drive once more where the robot was before");
}

void JudgeTrack(const MapPieces& pieces, Verdict& verdict) {
  const auto& values = verdict.values;
  const std::int64_t num_lost = values.lost - values.without_rays - pieces.num_elsewhere();
  const double lost = Share(std::max<std::int64_t>(0, num_lost), values.scans);
  const double far_steps = Share(values.far_steps, values.steps);
  const bool moves_far = far_steps > kFewFarSteps;
  if (lost > (moves_far ? kMostLostInMotion : kMostLost)) {
    Warn(verdict, Trust::kBad,
         fmt::format("{:.0f} % of the scans are lost, and the map after them may be metres off: {}", 100.0 * lost,
                     moves_far ? kTooFewScans : "likely a wrong --preset, or a blocked view"));
  } else if (values.longest_lost >= kLongLost && !IsInPieces(pieces)) {
    Warn(verdict, Trust::kDoubtful,
         fmt::format("{} scans in a row were lost: the map after them may be metres off", values.longest_lost));
  }
  if (far_steps > kManyFarSteps) {
    Warn(verdict, Trust::kDoubtful,
         fmt::format(
             "in {:.0f} % of the steps the laser moved by more than 0.4 m or 0.25 rad from one scan to the next: check "
             "the map for doubled or rotated walls; more scans per second or deskewing (--sweep-s) would help",
             100.0 * far_steps));
  }
}

void JudgeAxes(Verdict& verdict) {
  const auto& values = verdict.values;
  const double degenerate = Share(values.degenerate, values.scans);
  if (degenerate > kMostDegenerate) {
    Warn(verdict, Trust::kBad,
         fmt::format("{:.0f} % of the scans are degenerate: they do not fix the position in one direction, and lengths "
                     "in the map are unknown: likely a bare corridor, a wrong --preset or --range-max-m, or ranges "
                     "that are not in metres",
                     100.0 * degenerate));
  } else if (values.longest_open > kLongOpen) {
    Warn(verdict, Trust::kDoubtful,
         fmt::format("{} scans in a row are degenerate: unless the robot stood still, the length of its path there is "
                     "unknown (--odometry helps)",
                     values.longest_open));
  }
}

bool IsContradiction(const SelfContradiction& found) {
  return (found.num_looks >= kFewLooks && found.share > kMostContradict) ||
         (found.num_looks >= kVeryFewLooks && found.share > kMostOfFewContradict);
}

/// What was seen where the robot was twice.
void JudgeContradiction(Verdict& verdict) {
  const SelfContradiction& found = verdict.contradiction;
  if (!IsContradiction(found)) return;
  std::string text = fmt::format(
      "{:.0f} % of the scans contradict others that were taken at about the same place before", 100.0 * found.share);
  if (found.worst_share > 0.0) {
    text += fmt::format(", most of all near x {:.0f} m, y {:.0f} m", found.worst_place_m.x(), found.worst_place_m.y());
  }
  Warn(verdict, Trust::kDoubtful,
       text + ": check the map for doubled walls there; a loop may be missed (--odometry helps)");
}

/// How far the robot drove where the walls did not tell how far.
void JudgeOpenPath(Verdict& verdict) {
  const double open_path_m = verdict.values.open_path_m;
  if (open_path_m < kLongOpenPath_m) return;
  const bool seen_twice = verdict.contradiction.num_looks >= kManyLooks;
  if (seen_twice && open_path_m <= kMostOpenPath * verdict.values.path_m) return;
  Warn(verdict, Trust::kDoubtful,
       fmt::format(
           "along {:.0f} m of the path of {:.0f} m nothing in view told how far the robot drove{}: lengths there may "
           "be off (--odometry, or a laser that sees further, would tell)",
           open_path_m, verdict.values.path_m, seen_twice ? "" : ", and hardly any place was seen twice"));
}

/// The longer the way along which nothing told how far the robot drove, the further off the map may be: less where
/// places were seen twice and go together.
///
/// Chosen on seeds 1, 2 and 4 of the simulated worlds and on the logs, see Judge.
void JudgeMetres(Verdict& verdict) {
  constexpr double kAnyMap_m = 0.04;
  constexpr double kPerPath = 0.0003;
  constexpr double kPerOpenPath = 0.01;      // where places were seen twice
  constexpr double kPerUnseenPath = 0.03;    // where hardly any was
  constexpr double kPerDoubtfulPath = 0.05;  // more of it where most of the way was open
  constexpr double kMuchOpenPath = 0.5;      // of the open path, where places contradict each other
  constexpr double kContradicts_m = 0.5;
  const auto& values = verdict.values;
  const SelfContradiction& found = verdict.contradiction;
  const double open_path_m = values.open_path_m;
  const bool seen_twice = found.num_looks >= kManyLooks;
  const bool contradicts = IsContradiction(found);
  double off_m = kAnyMap_m + kPerPath * values.path_m + (seen_twice ? kPerOpenPath : kPerUnseenPath) * open_path_m;
  if (open_path_m > kMostOpenPath * values.path_m) off_m += kPerDoubtfulPath * open_path_m;
  if (contradicts) off_m += std::max(kContradicts_m, kMuchOpenPath * open_path_m);
  if (!contradicts && !seen_twice && open_path_m > kLongOpenPath_m) off_m += kMuchOpenPath * open_path_m;
  if (values.longest_lost >= kLongLost) off_m += kMuchOpenPath * values.path_m;
  verdict.off_m = off_m;
  if (contradicts && found.worst_share > 0.0) {
    verdict.off_at_m = found.worst_place_m;
  } else if (values.longest_open_m > kLongOpenPath_m / 4.0) {
    verdict.off_at_m = values.longest_open_ends_m;
  }
}

void JudgeOdometry(Verdict& verdict) {
  const auto& values = verdict.values;
  if (values.turns_by_odometry && *values.turns_by_odometry < kOpposite) {
    Warn(verdict, Trust::kDoubtful,
         "the odometry turns left where the laser turns right: one of the two is mirrored; if it is the laser, the map "
         "is mirrored too");
  } else if (values.ways_by_odometry && *values.ways_by_odometry < kAcross) {
    Warn(verdict, Trust::kDoubtful,
         "the odometry and the laser move in different directions: likely the laser is mounted rotated, and the poses "
         "are the laser's, not the robot's");
  }
}

/// On a finished map there is nothing to go wrong but the poses.
void JudgeLocalization(Verdict& verdict) {
  constexpr double kMostLostOnMap = 0.1;
  const double lost = Share(verdict.values.lost, verdict.values.scans);
  if (lost <= kMostLostOnMap) return;
  Warn(verdict, lost > 0.5 ? Trust::kBad : Trust::kDoubtful,
       fmt::format("{:.0f} % of the scans were not found on the map: likely another building, an unmapped part of it, "
                   "or rooms that look alike (--start helps)",
                   100.0 * lost));
}

std::string Describe(const MapPieces& pieces, const Verdict& verdict) {
  const auto& values = verdict.values;
  const std::int64_t found = values.scans - std::max(values.lost, values.without_rays);
  const std::int64_t elsewhere = std::min(pieces.num_elsewhere(), values.lost);
  std::string text =
      fmt::format("{} of {} scans {}, ", found, values.scans, values.finished_map ? "found on the map" : "mapped");
  if (elsewhere > 0) text += fmt::format("{} on other pieces, ", elsewhere);
  text += fmt::format("{} lost, {} degenerate, mean fitness {:.2f}", values.lost - elsewhere, values.degenerate,
                      values.mean_fitness);
  if (verdict.agreement) text += fmt::format(", {:.0f} % of the rays agree with the map", 100.0 * *verdict.agreement);
  return text;
}

std::string DescribeMetres(const Verdict& verdict) {
  std::string text =
      fmt::format("parts of it may be off by up to {:.{}f} m", *verdict.off_m, *verdict.off_m < 1.0 ? 2 : 1);
  if (verdict.off_at_m) {
    text += fmt::format(", behind x {:.0f} m, y {:.0f} m most likely", verdict.off_at_m->x(), verdict.off_at_m->y());
  }
  return text;
}

}  // namespace

Verdict Judge(const RunStatistics& statistics, const ByteMap& map, const MapPieces& pieces) {
  Verdict verdict;
  verdict.values = statistics.values();
  verdict.agreement = statistics.ComputeMeanAgreement(map);
  verdict.contradiction = statistics.FindContradiction();
  verdict.text = Describe(pieces, verdict);
  JudgeRays(verdict);
  if (verdict.values.scans < kFewScans) {
    if (verdict.values.scans > 0) Warn(verdict, Trust::kDoubtful, "too few scans to judge the map");
    return verdict;
  }
  if (verdict.values.finished_map) {
    JudgeLocalization(verdict);
    return verdict;
  }
  const bool blind = verdict.trust == Trust::kBad;
  if (!blind) JudgeFit(verdict);
  if (!blind) JudgeAgreement(verdict);
  if (!blind) JudgeTrack(pieces, verdict);
  if (!blind) JudgeAxes(verdict);
  if (!blind) JudgeOpenPath(verdict);
  if (!blind) JudgeContradiction(verdict);
  JudgeOdometry(verdict);
  JudgePieces(pieces, verdict);
  if (verdict.trust != Trust::kBad) JudgeMetres(verdict);
  return verdict;
}

void JudgeLoops(std::int64_t closed, std::int64_t rejected, Verdict& verdict) {
  if (rejected == 0) return;
  Warn(verdict, Trust::kDoubtful,
       fmt::format("{} of {} loops were rejected, because the rest of the path contradicts them: one of the two is "
                   "wrong, and parts of the map may be metres off",
                   rejected, closed + rejected));
}

void JudgeWheels(const WheelModel::Values& wheels, Verdict& verdict) {
  constexpr double kSigmas = 3.0;
  if (!wheels.ContradictLaser() || verdict.values.finished_map) return;
  Warn(verdict, Trust::kDoubtful,
       fmt::format("the wheels and the laser tell different ways, {:.2f} m apart after a metre and {:.2f} rad after a "
                   "turn of 1 rad: one of the two is wrong; compare with a map without --odometry",
                   wheels.way_per_m, wheels.turn_per_rad));
  if (verdict.off_m) *verdict.off_m += kSigmas * wheels.way_per_m * std::sqrt(verdict.values.path_m);
}

void JudgeLeftOut(std::int64_t num_left_out, Verdict& verdict) {
  const std::int64_t num_all = verdict.values.scans + num_left_out;
  if (verdict.values.scans == 0 || Share(num_left_out, num_all) <= kMostLeftOut) return;
  Warn(verdict, Trust::kDoubtful,
       fmt::format("{} of {} scans of the recording are left out ({:.0f} %): what only they saw is not in the map",
                   num_left_out, num_all, 100.0 * Share(num_left_out, num_all)));
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
  std::vector<std::string> lines{verdict.text, fmt::format("{} {}", subject, meaning)};
  if (verdict.off_m) lines.push_back(DescribeMetres(verdict));
  lines.insert(lines.end(), verdict.notes.begin(), verdict.notes.end());
  for (const std::string& warning : verdict.warnings) lines.push_back("warning: " + warning);
  return lines;
}

}  // namespace crsm
