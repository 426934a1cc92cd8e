#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/diagnosis/diagnosis_constants.hpp"
#include "common/diagnosis/run_statistics.hpp"
#include "common/graph/pieces.hpp"
#include "common/match/guess/wheel_model.hpp"

namespace crsm {

/// Whether a map, or the poses on a finished one, are to be trusted.
enum class Trust {
  kGood,      ///< nothing speaks against them
  kDoubtful,  ///< look at the map: runs like this one have come out right, and wrong
  kBad,       ///< not to be trusted
};

struct Verdict {
  Trust trust = Trust::kGood;
  RunStatistics::Values values;
  std::optional<double> agreement;  ///< as of RunStatistics::ComputeMeanAgreement
  SelfContradiction contradiction;  ///< of scans where the robot was twice
  /// How far off parts of the map may be [m]: more in one map of twenty. Not of poses on a finished map, nor of a map
  /// that is bad, was made without loops, or contradicts itself.
  std::optional<double> off_m;
  std::optional<Point> off_at;        ///< near where, map frame, if that is known
  std::vector<Doubt> doubts;          ///< the same by places along the path, where off_m is known
  std::optional<WayBack> way_back;    ///< the drive that would tell most, if one would help much
  std::int64_t left_out = 0;          ///< scans that were never tried
  std::vector<std::string> notes;     ///< a line each: what is good to know, and speaks against nothing
  std::vector<std::string> warnings;  ///< a line each: what speaks against the map, and the likely cause
};

/// Judges a run by its statistics.
///
/// The thresholds were chosen on fr079, intel, exp1 and the simulated worlds demo and env1 to env3, and checked on
/// aces, killian, exp3, hall, twins, corridor and env4: as they are, and spoilt (every 2nd to 50th scan only, angles in
/// degrees or 0.5 to 2 times what they are, ranges with noise or 0.5 m too long, scans shuffled in time, beams
/// shuffled, searches too short to keep the track). Where the truth is known, a run counts as wrong from 0.5 m
/// (relations 0.3 m).
///
/// Those for the lasers that see little, and for scans that contradict each other, were chosen on seeds 1 and 2 of the
/// simulated worlds seen by lasers of 3.5 to 8 m and 57 to 360 degrees and of the logs with ranges up to 5 and 8 m, and
/// checked on seeds 4 and 5 of the worlds and 5 of the logs: of 205 maps 50 are wrong, one of them called good; 155 are
/// right, 35 of them called doubtful and none bad.
/// Later, on seeds 6 to 25 of demo, env2 and a campus by ten lasers of 57 to 360 degrees and 3.5 to 8 m: of 600 maps
/// 115 are wrong, none of them called good; 485 are right, none of them called bad.
///
/// What it cannot see, because the map agrees with every scan: a building that is mirrored, turned or scaled as a whole
/// (unless odometry tells); a loop that does not close where the robot comes only once; and a single slip in a bare
/// corridor. Some runs on every 5th to 8th scan are wrong while others are right with the same statistics: they are
/// called doubtful.
///
/// Where the laser stood, a low fitness accuses nobody: one scan is drawn, and the beams of the others fall between its
/// points. The map is doubtful then, because nothing has checked it.
///
/// pieces: how the map hangs together. A map with less than 98 % of the matched scans on its largest piece is doubtful
/// at best, and with less than half of all that measured anything it is not to be trusted.
///
/// A map is also doubtful whose loops were rejected again: of 90 runs on fr079, intel, aces and killian whose maps are
/// right, three had such loops; simulated ones of kilometres that slipped in corridors had more of them than loops that
/// stayed.
Verdict Judge(const RunStatistics& statistics, const ByteMap& map, const MapPieces& pieces = {},
              const DiagnosisConstants::Verdict& constants = {});

/// Adds a note of what was learned of the wheels, and a warning where they contradict the laser: so far apart, one of
/// the two is wrong, and nobody knows by how much. In eight logs with right maps they differ by 0.02 to 0.06 m after a
/// metre; a depth camera that bends walls, and orbits before them while the robot turns, differs by 0.22 m.
void JudgeWheels(const WheelModel::Values& wheels, Verdict& verdict);

/// Scans that were never tried.
struct LeftOut {
  std::int64_t all = 0;
  std::int64_t dropped = 0;  ///< of these, because the machine was too slow; the others were refused or repeated
};

/// Adds what scans say that were never tried: a map without more than a tenth of the recording is doubtful at best.
/// Scans are dropped one by one, between others that saw the same.
void JudgeLeftOut(const LeftOut& left_out, Verdict& verdict, const DiagnosisConstants::Verdict& constants = {});

/// Adds a note that somebody has told a robot on a finished map so often where it is.
void JudgeToldStarts(std::int64_t num, Verdict& verdict);

/// Adds a warning that loops were still searched when the run was ended.
void JudgeUnsearched(Verdict& verdict);

const char* Name(Trust trust);

/// For people, ready to be printed: what has become of the scans, the verdict, and a line for each note and each
/// warning.
std::vector<std::string> FormatVerdict(const Verdict& verdict);

}  // namespace crsm
