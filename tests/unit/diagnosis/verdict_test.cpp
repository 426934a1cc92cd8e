#include "common/diagnosis/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "common/results/summary.hpp"
#include "diagnosis/wall_ahead.hpp"
#include "synthetic_scans.hpp"

using namespace crsm;

namespace {

/// Of a map that hangs together. How far off it may be is not said.
const MapPieces kOnePiece{.num_pieces = 1};

/// A run of scans that were all matched well, so far apart.
struct Run {
  double step_m = 0.05;
  std::int64_t utime = 0;
  RunStatistics statistics = {};

  ScanMatch Next() {
    ScanMatch match;
    match.utime = ++utime;
    match.T_map_laser = {step_m * static_cast<double>(utime), 0.0, 0.0};
    match.state = utime == 1 ? MatchState::kFirst : MatchState::kOk;
    match.fitness = 0.8;
    match.num_critical = 70;
    match.map_version = utime - 1;
    return match;
  }

  template <class Change>
  Run& Add(int num, Change&& change) {
    for (int i = 0; i < num; ++i) {
      ScanMatch match = Next();
      change(match);
      statistics.Add(match);
    }
    return *this;
  }
  Run& Add(int num) {
    return Add(num, [](ScanMatch&) {});
  }

  Verdict Judged(const MapPieces& pieces = kOnePiece, const DiagnosisConstants::Verdict& constants = {}) const {
    return Judge(statistics, ByteMap(0.1), pieces, constants);
  }
};

ByteMap RoomMap() { return PaintMap(-2, 1, RoomByte); }

bool Mentions(const Verdict& verdict, const std::string& words) {
  const auto lines = FormatVerdict(verdict);
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(words) != std::string::npos; });
}

// What befalls a scan.
void Lose(ScanMatch& match) { match.state = MatchState::kLost; }
void Float(ScanMatch& match) {
  match.floating = true;
  match.trajectory = 1;
  match.T_map_laser.x_m += 100.0;  // in a frame of its own
}
void SeeNoRays(ScanMatch& match) { match.num_critical = 0; }
void Degenerate(ScanMatch& match) { match.state = MatchState::kDegenerate; }
void FitBadly(ScanMatch& match) { match.fitness = 0.45; }
void Jump(ScanMatch& match) { match.T_map_laser.y_m = match.utime % 2 == 0 ? 1.0 : 0.0; }
void TurnFar(ScanMatch& match) { match.T_map_laser.yaw_rad = match.utime % 5 == 0 ? 0.3 : 0.0; }
void Stand(ScanMatch& match) {
  match.T_map_laser = {match.utime % 2 == 0 ? 0.05 : 0.0, 0.0, match.utime % 3 == 0 ? 0.02 : 0.0};
}
void TurnOnTheSpot(ScanMatch& match) { match.T_map_laser = {0.0, 0.0, 0.002 * static_cast<double>(match.utime)}; }
void SeeNothing(ScanMatch& match) {
  match.state = MatchState::kFirst;  // the map stays empty
  match.num_critical = 0;
}
/// Wheels whose turns have that sense.
auto Turning(double sense) {
  return [sense](ScanMatch& match) {
    const double turn_rad = 0.1 * static_cast<double>(match.utime % 20);
    match.T_map_laser.yaw_rad = turn_rad;
    match.T_odom_robot = Pose2{match.T_map_laser.x_m, 0.0, sense * turn_rad};
  };
}
void DriveBackwards(ScanMatch& match) { match.T_odom_robot = Pose2{-match.T_map_laser.x_m, 0.0, 0.0}; }
void OnFinishedMap(ScanMatch& match) { match.map_version = 0; }
auto Both(void (*one)(ScanMatch&), void (*other)(ScanMatch&)) {
  return [=](ScanMatch& match) {
    one(match);
    other(match);
  };
}

/// A localization, of whose 100 scans so many are lost. There is no first scan.
Run Localized(int num_lost) {
  return Run{.utime = 1}.Add(num_lost, Both(OnFinishedMap, Lose)).Add(100 - num_lost, OnFinishedMap);
}

/// One that is 5 m elsewhere from one scan to the next.
Run Displaced() {
  return Localized(0).Add(1, Both(OnFinishedMap, [](ScanMatch& match) { match.T_map_laser.y_m += 5.0; }));
}

std::optional<double> AgreementOf(float range_m, int num_scans, bool rays_first = true) {
  RunStatistics statistics;
  for (int i = 0; i < num_scans; ++i) {
    ScanMatch match;
    match.utime = i;
    match.state = MatchState::kOk;
    if (rays_first) statistics.Add(i, LookAhead(range_m));
    statistics.Add(match);
    if (!rays_first) statistics.Add(i, LookAhead(range_m));
  }
  return statistics.ComputeMeanAgreement(MakeWall());
}

}  // namespace

TEST_CASE("a pose that jumps as no robot can is doubtful, once is enough; one behind a break, or a slow one, is none") {
  const auto BeCarried = [](ScanMatch& match) { match.T_map_laser.y_m = 12.0; };
  const Verdict verdict = Run().Add(100).Add(1, BeCarried).Add(300).Judged();
  CHECK(verdict.trust == Trust::kDoubtful);
  CHECK(Mentions(verdict, "the pose jumps by 12.0 m, to x 5 m, y 12 m"));
  const auto BeginElsewhere = [&](ScanMatch& match) { BeCarried(match), match.trajectory = 1; };
  CHECK_FALSE(Mentions(Run().Add(100).Add(100, BeginElsewhere).Judged(), "jumps"));
  // Within two lost scans no robot gets so far either, on whichever trajectory it is found again.
  CHECK(Mentions(Run().Add(100).Add(2, Lose).Add(100, BeginElsewhere).Judged(), "jumps by 12.0 m"));
  const auto BeginLater = [&](ScanMatch& match) { BeginElsewhere(match), match.utime += 2'000'000; };
  CHECK_FALSE(Mentions(Run().Add(100).Add(2, Lose).Add(100, BeginLater).Judged(), "jumps"));
  const auto BeCarriedSlowly = [&](ScanMatch& match) { BeCarried(match), match.utime += 2'000'000; };
  CHECK_FALSE(Mentions(Run().Add(100).Add(100, BeCarriedSlowly).Judged(), "jumps"));
}

TEST_CASE("a run is as good as its scans, and what speaks against it is said") {
  struct Case {
    const char* drive;
    Run run;
    Trust trust;
    const char* says = "";
  };
  using enum Trust;
  const std::vector<Case> cases{
      {"all scans fit", Run().Add(100), kGood, "100 of 100 scans mapped, 0 lost, 0 degenerate, mean fitness 0.80"},
      {"no scan", Run(), kBad, "no scan came"},
      {"too few to tell", Run().Add(19), kDoubtful},
      {"just enough", Run().Add(20), kGood},
      {"no rays", Run().Add(100, SeeNothing), kBad, "--range-max-m"},
      {"low fitness", Run().Add(100, FitBadly), kBad, "--angle-scale"},
      {"fair fitness", Run().Add(100, [](ScanMatch& match) { match.fitness = 0.55; }), kDoubtful},
      {"low fitness with jumps: rate or unit of angles", Run().Add(100, Both(FitBadly, Jump)), kBad, "degrees"},
      {"it stands", Run().Add(100, Stand), kGood, "the laser hardly moved (0.05 m and 1 degrees at most)"},
      {"it stands and fits badly", Run().Add(100, Both(Stand, FitBadly)), kDoubtful, "the laser hardly moved"},
      {"it turns and fits badly", Run().Add(100, Both(TurnOnTheSpot, FitBadly)), kBad, "angles"},
      {"4 % lost", Run().Add(96).Add(4, Lose), kGood},
      {"6 % lost", Run().Add(94).Add(6, Lose), kBad, "6 % of the scans are lost"},
      {"4 % lost among far steps", Run().Add(90).Add(6, Jump).Add(4, Lose), kBad, "too few scans"},
      {"1 % lost, in a row", Run().Add(1000).Add(20, Lose).Add(1000), kDoubtful,
       "20 scans in a row were lost: the map"},
      {"1 % lost or without rays, in a row", Run().Add(1000).Add(10, Lose).Add(10, Both(Lose, SeeNoRays)).Add(1000),
       kDoubtful, "20 scans in a row were lost or had no rays: the map after them"},
      {"4 % without rays are not lost", Run().Add(96).Add(4, Both(Lose, SeeNoRays)), kGood,
       "96 of 100 scans mapped, 0 lost, 4 without rays, 0 degenerate"},
      {"far turns", Run().Add(100, TurnFar), kDoubtful, "more scans per second would help"},
      {"degenerate", Run().Add(10).Add(90, Degenerate), kBad, "do not fix the position in one direction"},
      {"wheels turn as the laser does", Run().Add(200, Turning(1.0)), kGood},
      {"wheels turn the other way", Run().Add(200, Turning(-1.0)), kDoubtful, "mirrored"},
      {"wheels drive backwards", Run().Add(200, DriveBackwards), kDoubtful, "mounted rotated"},
      {"localized", Localized(5), kGood},
      {"localized, and elsewhere at once", Displaced(), kDoubtful, "no robot is so fast"},
      {"localized with many lost scans", Localized(30), kDoubtful},
      {"localized in another building", Localized(80), kBad, "another building"},
      {"poses, not a map", Localized(80), kBad, "the poses are not to be trusted"},
  };
  for (const Case& tested : cases) {
    CAPTURE(tested.drive);
    const Verdict verdict = tested.run.Judged();
    CHECK(verdict.trust == tested.trust);
    CHECK(Mentions(verdict, tested.says));
  }
  CHECK(Run().Add(100).Judged().warnings.empty());
  CHECK(Run().Add(100, SeeNothing).Judged().warnings.size() == 1);  // nothing else is known
  CHECK_FALSE(Mentions(Run().Add(100, Both(Stand, FitBadly)).Judged(), "angles"));
}

TEST_CASE("what is just below a threshold does not read as the threshold, in any line") {
  const auto JudgeAt = [](double fitness) {
    return Run().Add(100, [=](ScanMatch& match) { match.fitness = fitness; }).Judged();
  };
  CHECK(Mentions(JudgeAt(0.5999), "(mean fitness 0.59; correct maps have 0.6 or more)"));
  CHECK(Mentions(JudgeAt(0.5999), "0 degenerate, mean fitness 0.59"));
  CHECK(JudgeAt(0.6).warnings.empty());
  CHECK(Mentions(JudgeAt(0.6), "mean fitness 0.60"));
}

TEST_CASE("a warning of few rays that agree names the share that is asked for") {
  // 99 of 200 scans agree with all of their rays.
  Run run;
  for (int i = 0; i < 200; ++i) {
    ScanMatch match = run.Next();
    match.T_map_laser = {0.0, 0.2 * (i % 2), 0.0};  // it drives to and fro
    run.statistics.Add(match.utime, LookAhead(i < 101 ? 3.0f : 2.05f));
    run.statistics.Add(match);
  }
  const auto Says = [&](double fair_agreement) {
    DiagnosisConstants::Verdict constants;
    constants.fair_agreement = fair_agreement;
    const Verdict verdict = Judge(run.statistics, MakeWall(), kOnePiece, constants);
    REQUIRE(verdict.agreement == Approx(0.495));
    CHECK(Mentions(verdict, ", 49 % of the rays agree with the map"));
    return Mentions(verdict, fmt::format("only 49 % of their rays pass through free space and end at walls (correct "
                                         "maps have {:.0f} % or more)",
                                         100.0 * fair_agreement));
  };
  CHECK(Says(0.5));
  CHECK(Says(0.7));
}

TEST_CASE("how far off a map may be is what its pose graph says, and more than is of use makes it doubtful") {
  const auto JudgeWith = [](double most_m, const Run& run, std::int64_t num_rejected = 0) {
    return Judge(run.statistics, RoomMap(),
                 {.num_pieces = 1, .num_rejected = num_rejected, .error = MapError{most_m, {5.0, -1.5}}});
  };
  const Verdict sure = JudgeWith(0.08, Run().Add(100));
  CHECK(sure.trust == Trust::kGood);
  CHECK(*sure.off_m == 0.08);
  CHECK_FALSE(sure.off_at);
  CHECK(Mentions(sure, "parts of it may be off by up to 0.08 m"));
  const Verdict fair = JudgeWith(0.9, Run().Add(100));
  CHECK(fair.trust == Trust::kGood);
  CHECK(Mentions(fair, "may be off by up to 0.90 m, most likely past x 5.0 m, y -1.5 m"));
  const Verdict open = JudgeWith(1.1, Run().Add(100));
  CHECK(open.trust == Trust::kDoubtful);
  CHECK(Mentions(open, "leaves the lengths of the path open by up to 1.1 m"));
  CHECK(Mentions(open, "drive once more where the robot was before"));
  const MapPieces helped{
      .num_pieces = 1,
      .error = MapError{3.0, {5.0, -1.5}, {{{1.0, 2.0}, 9.0}}, WayBack{{3.0, 40.0}, {60.0, 41.0}, 0.4}}};
  const Verdict told = Judge(Run().Add(100).statistics, RoomMap(), helped);
  CHECK(Mentions(told, "a drive from x 3.0 m, y 40.0 m to x 60.0 m, y 41.0 m, by another way than before"));
  CHECK(Mentions(told, "leave about 0.4 m"));
  CHECK(told.way_back == helped.error->way_back);
  REQUIRE(told.doubts.size() == 1);
  CHECK(told.doubts[0].off_m == *told.off_m);  // a place is no further off than the map
  const Verdict slipped =
      Judge(Run().Add(100).statistics, RoomMap(), {.num_pieces = 1, .slip = Slip{{4.0, -2.0}, 0.9}});
  CHECK(slipped.trust == Trust::kGood);
  CHECK(Mentions(slipped, "slip near x 4.0 m, y -2.0 m: one match was wrong by 0.9 m"));
  CHECK(*JudgeWith(1e6, Run().Add(100)).off_m < 100.0);  // no further than the map is large
  CHECK_FALSE(Run().Add(100).Judged().off_m);
  CHECK_FALSE(JudgeWith(0.08, Run().Add(100, FitBadly)).off_m);
  CHECK_FALSE(JudgeWith(0.08, Run().Add(100), 1).off_m);  // the graph contradicts itself
  const Verdict without_loops = Run().Add(100).Judged({});
  CHECK(without_loops.trust == Trust::kDoubtful);
  CHECK(Mentions(without_loops, "without loops (--no-loops) nothing tells how far off the map may be"));
}

TEST_CASE("a map without more than a tenth of the recording is not called good") {
  const auto JudgeWithout = [](int num_left_out, const Run& run, int num_dropped = 0) {
    Verdict verdict = run.Judged();
    JudgeLeftOut({num_left_out, num_dropped}, verdict);
    return verdict;
  };
  CHECK(JudgeWithout(10, Run().Add(90)).trust == Trust::kGood);
  CHECK(Mentions(JudgeWithout(10, Run().Add(90)), "90 of 90 scans mapped, 0 lost, 10 more left out, 0 degenerate"));
  CHECK(JudgeWithout(30, Run().Add(90)).trust == Trust::kDoubtful);
  CHECK(Mentions(JudgeWithout(30, Run().Add(90)), "30 of 120 scans of the recording were refused or repeated (25 %)"));
  CHECK_FALSE(Mentions(JudgeWithout(30, Run()), "refused"));  // nothing came: that is said
  const Verdict slow = JudgeWithout(85, Run().Add(90), 80);   // 5 of 95 alone were refused
  CHECK(slow.trust == Trust::kGood);
  CHECK(Mentions(slow, "85 more left out"));
}

TEST_CASE("agreement is the share of rays that end at walls, in whatever order rays and matches come") {
  CHECK(AgreementOf(2.05f, 30) == 1.0);
  CHECK(AgreementOf(2.05f, 30, false) == 1.0);
  CHECK(AgreementOf(3.0f, 30) == 0.0);  // through the wall
  CHECK(AgreementOf(1.0f, 30) == 0.0);  // in the open
  CHECK(!AgreementOf(2.05f, 19));       // too few to tell
  CHECK(AgreementOf(2.05f, 20) == 1.0);
  CHECK(AgreementOf(2.05f, 5000) == 1.0);  // more than are kept
}

TEST_CASE("lost scans and scans whose rays were not heard do not count for the agreement") {
  RunStatistics statistics;
  for (int i = 0; i < 60; ++i) {
    ScanMatch match;
    match.utime = i;
    match.state = i % 3 == 0 ? MatchState::kLost : MatchState::kOk;
    if (i % 3 != 1) statistics.Add(i, LookAhead(i % 3 == 0 ? 3.0f : 2.05f));
    statistics.Add(match);
  }
  CHECK(statistics.ComputeMeanAgreement(MakeWall()) == 1.0);
}

TEST_CASE("scans that contradict the map are bad, and where they are localised on it, doubtful") {
  const auto JudgeScans = [](bool localised) {
    Run run{.utime = localised ? 1 : 0};
    for (int i = 0; i < 50; ++i) {
      ScanMatch match = run.Next();
      match.T_map_laser = {};
      if (localised) OnFinishedMap(match);
      run.statistics.Add(match.utime, LookAhead(i % 5 < 3 ? 3.0f : 2.05f));
      run.statistics.Add(match);
    }
    return Judge(run.statistics, MakeWall());
  };
  const Verdict mapped = JudgeScans(false);
  CHECK(mapped.agreement == Approx(0.4));
  CHECK(mapped.trust == Trust::kBad);
  CHECK(Mentions(mapped, "contradict the map: only 40 %"));
  const Verdict localised = JudgeScans(true);
  CHECK(localised.agreement == Approx(0.4));
  CHECK(localised.trust == Trust::kDoubtful);
  CHECK(
      Mentions(localised, "only 40 % of their rays pass through free space and end at walls: likely much has changed"));
}

TEST_CASE("scans that fit badly, but whose rays agree with the map, make it doubtful: as outdoors") {
  const auto JudgeRays = [](float range_m) {
    Run run;
    run.step_m = 0.0;
    for (int i = 0; i < 50; ++i) {
      ScanMatch match = run.Next();
      match.T_map_laser = {0.0, 0.2 * (i % 2), 0.0};  // it drives to and fro
      match.fitness = 0.45;
      run.statistics.Add(match.utime, LookAhead(range_m));
      run.statistics.Add(match);
    }
    return Judge(run.statistics, MakeWall());
  };
  CHECK(JudgeRays(2.05f).trust == Trust::kDoubtful);
  CHECK(JudgeRays(3.0f).trust == Trust::kBad);
}

TEST_CASE("loops that were rejected make a map doubtful, and never better than it was") {
  const auto JudgeWith = [](int num_rejected, const Run& run) {
    return run.Judged({.num_pieces = 1, .num_closed = 12, .num_rejected = num_rejected, .pieces = {}, .breaks = {}});
  };
  CHECK(JudgeWith(0, Run().Add(100)).trust == Trust::kGood);
  CHECK(JudgeWith(0, Run().Add(100)).warnings.empty());
  CHECK(JudgeWith(3, Run().Add(100)).trust == Trust::kDoubtful);
  CHECK(Mentions(JudgeWith(3, Run().Add(100)), "3 of 15 loops were rejected"));
  CHECK(JudgeWith(3, Run()).trust == Trust::kBad);
}

TEST_CASE("wheels that tell another way than the laser make a map doubtful, and nobody knows how far off") {
  const Verdict good = Run{.step_m = 0.25}.Add(100).Judged({.num_pieces = 1, .error = MapError{0.1, {}}});
  REQUIRE(good.off_m);
  const auto JudgeBy = [&good](double way_per_m, double turn_per_rad, std::int64_t steps) {
    Verdict verdict = good;
    WheelModel::Values wheels;
    wheels.way_per_m = way_per_m;
    wheels.turn_per_rad = turn_per_rad;
    wheels.steps = steps;
    JudgeWheels(wheels, verdict);
    return verdict;
  };
  CHECK(JudgeBy(0.06, 0.16, 100).trust == Trust::kGood);
  CHECK(JudgeBy(0.06, 0.16, 100).off_m == good.off_m);
  CHECK(JudgeBy(0.22, 0.1, 3).trust == Trust::kGood);  // too little was learned
  CHECK(JudgeBy(0.06, 0.16, 100).notes.back().starts_with("the wheels: a metre is 1.000 m by the laser, to 0.060 m"));
  Verdict standing = good;
  JudgeWheels({.way_per_m = 0.22, .steps = 100, .have_moved = false}, standing);
  CHECK(standing.trust == Trust::kGood);
  CHECK(standing.notes.back() == "the wheels never moved, and the laser did: they were not used");
  for (const Verdict& verdict : {JudgeBy(0.22, 0.1, 8), JudgeBy(0.06, 0.3, 8)}) {
    CHECK(verdict.trust == Trust::kDoubtful);
    CHECK(Mentions(verdict, "the wheels and the laser tell different ways"));
  }
  CHECK_FALSE(JudgeBy(0.22, 0.1, 8).off_m);
}

TEST_CASE("a map in pieces is never good where more than a fiftieth of the matched scans is on others") {
  const auto JudgeWith = [](std::int64_t on_largest, std::int64_t elsewhere) {
    const MapPieces pieces{.num_pieces = 3,
                           .num_breaks = 2,
                           .num_matched = on_largest + elsewhere,
                           .pieces = {{90, on_largest, 40.0}, {20, elsewhere - 1, 5.0}, {1, 1, 0.0}},
                           .breaks = {}};
    return Run().Add(static_cast<int>(on_largest)).Add(static_cast<int>(elsewhere), Float).Judged(pieces);
  };
  const Verdict few = JudgeWith(990, 10);
  CHECK(few.trust == Trust::kGood);
  CHECK(Mentions(few, "990 of 1000 scans mapped, 10 floating (on another piece), 0 lost, 0 degenerate"));
  CHECK(Mentions(few,
                 "the map is in 3 pieces: the largest, which is shown, has 99 % of the scans that measured "
                 "anything; see pieces/ for 1 more"));
  const Verdict some = JudgeWith(970, 30);
  CHECK(some.trust == Trust::kDoubtful);
  CHECK(some.warnings.size() == 1);  // they are not lost
  CHECK(Mentions(some, "warning: the map is in 3 pieces: the largest, which is shown, has 97 % of the scans"));
  CHECK(JudgeWith(500, 500).trust == Trust::kDoubtful);
}

TEST_CASE("a map with less than half of the scans that measured anything is not to be trusted") {
  const auto JudgeWith = [](int on_map, int floating, int lost, int without_rays) {
    const MapPieces pieces{.num_pieces = 2, .num_breaks = 1, .pieces = {{90, 0, 40.0}, {20, 0, 5.0}}, .breaks = {}};
    Run run;
    run.Add(on_map).Add(floating, Float).Add(lost, Lose).Add(without_rays, Both(Lose, SeeNoRays));
    return run.Judged(pieces).trust;
  };
  CHECK(JudgeWith(500, 500, 0, 0) == Trust::kDoubtful);
  CHECK(JudgeWith(490, 500, 10, 0) == Trust::kBad);
  CHECK(JudgeWith(500, 490, 10, 40) == Trust::kDoubtful);  // those without rays measured nothing
  CHECK(JudgeWith(300, 700, 0, 0) == Trust::kBad);
}

TEST_CASE("scans that are lost beside a piece are bad as ever") {
  const MapPieces pieces{
      .num_pieces = 2, .num_breaks = 1, .num_matched = 910, .pieces = {{90, 900, 40.0}, {2, 10, 1.0}}, .breaks = {}};
  const Verdict verdict = Run().Add(900).Add(10, Float).Add(90, Lose).Judged(pieces);
  CHECK(verdict.trust == Trust::kBad);
  CHECK(Mentions(verdict, "9 % of the scans are lost"));
}

TEST_CASE("breaks that were joined speak against nothing, those that the wheels alone bridge make a map doubtful") {
  const auto JudgeWith = [](std::int64_t num_breaks, std::int64_t num_bridged) {
    return Run().Add(1000).Judged({.num_pieces = 1,
                                   .num_breaks = num_breaks,
                                   .num_matched = 1000,
                                   .num_bridged = num_bridged,
                                   .pieces = {{90, 1000, 40.0}},
                                   .breaks = {}});
  };
  CHECK(JudgeWith(4, 0).trust == Trust::kGood);
  CHECK(FormatVerdict(JudgeWith(4, 0)).size() == 3);  // the scans, the verdict, and the breaks
  CHECK(Mentions(JudgeWith(4, 0), "lost or interrupted 4 times, and all parts of the map were joined"));
  CHECK(Mentions(JudgeWith(1, 0), "lost or interrupted once, and the two parts"));
  CHECK(JudgeWith(3, 2).trust == Trust::kDoubtful);
  CHECK(Mentions(JudgeWith(3, 2), "warning: 2 of 3 interruptions of the track are bridged by the wheels alone"));
}

TEST_CASE("a map whose scans contradict each other where the robot was twice is doubtful, and says where") {
  const auto JudgeDrive = [](double off_m, int every = 1) {
    Run run;
    for (int i = 0; i < 400; ++i) {
      const double along_m = 0.05 * (i % 200 < 100 ? i % 200 : 199 - i % 200);
      const Pose2 truth{-2.5 + along_m, 0.0, i < 200 ? 0.0 : 0.3};
      ScanMatch match = run.Next();
      match.T_map_laser = {truth.x_m, truth.y_m + (i < 200 ? 0.0 : off_m), truth.yaw_rad};
      if (i % every == 0) run.statistics.Add(match.utime, FindValidRays(ScanNiche(truth, i), {}));
      run.statistics.Add(match);
    }
    return run.Judged();
  };
  CHECK_FALSE(Mentions(JudgeDrive(0.0), "contradict others"));
  const Verdict verdict = JudgeDrive(0.8);
  CHECK(verdict.trust != Trust::kGood);
  CHECK(Mentions(verdict, "contradict others that were taken at about the same place"));
  CHECK(Mentions(verdict, "near x "));
  constexpr int kSeldom = 36;
  CHECK(JudgeDrive(0.8, kSeldom).contradiction.num_looks < 20);
  CHECK(Mentions(JudgeDrive(0.8, kSeldom), "contradict others"));  // most of a few
  CHECK_FALSE(Mentions(JudgeDrive(0.0, kSeldom), "contradict others"));
}

TEST_CASE("summary.json has the pieces, and where and why each break was") {
  Summary summary;
  CHECK_FALSE(nlohmann::json::parse(FormatSummary(summary)).contains("breaks"));
  summary.pieces = {
      .num_pieces = 3,
      .num_breaks = 2,
      .num_matched = 100,
      .pieces = {{90, 80, 40.0}, {10, 15, 5.0}, {2, 5, 0.5}},
      .breaks = {{7, 40, BreakReason::kGap, 9.5, {1.0, 2.0, 0.5}, 1, 2}, {9, 60, BreakReason::kLost, 1.5, {}, 1, 1}}};
  const auto json = nlohmann::json::parse(FormatSummary(summary));
  CHECK(json["pieces"]["count"] == 3);
  CHECK(json["pieces"]["scans"] == 100);
  CHECK(json["pieces"]["largest_first"][1] ==
        nlohmann::json{{"piece", 2}, {"scans", 15}, {"keyframes", 10}, {"way_m", 5.0}, {"folder", "pieces/2"}});
  CHECK(json["pieces"]["largest_first"][2]["folder"].is_null());
  CHECK(json["num_breaks"] == 2);
  CHECK(json["breaks"][0] == nlohmann::json{{"utime", 7},
                                            {"scan", 40},
                                            {"reason", "gap"},
                                            {"seconds", 9.5},
                                            {"pose_before", {{"x_m", 1.0}, {"y_m", 2.0}, {"yaw_rad", 0.5}}},
                                            {"piece_before", 1},
                                            {"piece", 2},
                                            {"joined", false}});
  CHECK(json["breaks"][1]["joined"] == true);
}

TEST_CASE("summary.json has the verdict, with the lines that a program prints") {
  Summary summary;
  summary.verdict = Run().Add(94).Add(6, Lose).Judged();
  const auto json = nlohmann::json::parse(FormatSummary(summary))["verdict"];
  CHECK(json["trust"] == "bad");
  CHECK(json["agreement"].is_null());
  CHECK(json["lines"].size() == 3);
  CHECK(json["lines"][1] == "the map is not to be trusted");
  CHECK(json["lines"][2].get<std::string>().rfind("warning: 6 % of the scans are lost", 0) == 0);
}

TEST_CASE("a verdict goes by the constants that it is given") {
  using Constants = DiagnosisConstants::Verdict;
  using enum Trust;
  struct Case {
    const char* constant;
    void (*change)(Constants&);
    Run run;
    Trust before;
    Trust after;
  };
  const Run few_jumps = Run().Add(90).Add(6, Jump).Add(4, Lose);
  for (const Case& tested :
       {Case{"few_scans", [](Constants& c) { c.few_scans = 101; }, Run().Add(100), kGood, kDoubtful},
        {"least_fitness", [](Constants& c) { c.least_fitness = 0.4; }, Run().Add(100, FitBadly), kBad, kDoubtful},
        {"fair_fitness", [](Constants& c) { c.fair_fitness = 0.85; }, Run().Add(100), kGood, kDoubtful},
        {"most_lost", [](Constants& c) { c.most_lost = 0.03; }, Run().Add(96).Add(4, Lose), kGood, kBad},
        {"most_lost_in_motion", [](Constants& c) { c.most_lost_in_motion = 0.05; }, few_jumps, kBad, kGood},
        {"few_far_steps", [](Constants& c) { c.few_far_steps = 0.1; }, few_jumps, kBad, kGood},
        {"most_degenerate", [](Constants& c) { c.most_degenerate = 0.95; }, Run().Add(10).Add(90, Degenerate), kBad,
         kGood},
        {"many_far_steps", [](Constants& c) { c.many_far_steps = 0.9; }, Run().Add(100, TurnFar), kDoubtful, kGood},
        {"long_lost", [](Constants& c) { c.long_lost = 21; }, Run().Add(1000).Add(20, Lose).Add(1000), kDoubtful,
         kGood},
        {"stands_within_m", [](Constants& c) { c.stands_within_m = 0.01; }, Run().Add(100, Both(Stand, FitBadly)),
         kDoubtful, kBad},
        {"stands_within_rad", [](Constants& c) { c.stands_within_rad = 0.01; }, Run().Add(100, Both(Stand, FitBadly)),
         kDoubtful, kBad},
        {"opposite", [](Constants& c) { c.opposite = c.across = -1.1; }, Run().Add(200, Turning(-1.0)), kDoubtful,
         kGood},
        {"across", [](Constants& c) { c.across = -1.1; }, Run().Add(200, DriveBackwards), kDoubtful, kGood},
        {"most_lost_on_map", [](Constants& c) { c.most_lost_on_map = 0.4; }, Localized(30), kDoubtful, kGood},
        {"mostly_lost_on_map", [](Constants& c) { c.mostly_lost_on_map = 0.9; }, Localized(80), kBad, kDoubtful}}) {
    CAPTURE(tested.constant);
    Constants constants;
    tested.change(constants);
    CHECK(tested.run.Judged().trust == tested.before);
    CHECK(tested.run.Judged(kOnePiece, constants).trust == tested.after);
  }
}

TEST_CASE("so do what is said of pieces, of scans that are left out, and how far off a map may be") {
  DiagnosisConstants::Verdict constants;
  constants.most_left_out = 0.3;
  constants.least_on_largest = 0.5;
  constants.long_lost = 100;
  constants.least_of_all = 0.05;
  constants.far_off_m = 3.0;
  constants.off_place_m = 2.5;
  const Run run = Run{.step_m = 0.25}.Add(100);
  const MapPieces off{.num_pieces = 1, .error = MapError{2.0, {}}};
  CHECK(Judge(run.statistics, RoomMap(), off).trust == Trust::kDoubtful);
  CHECK(Judge(run.statistics, RoomMap(), off).off_at);
  Verdict verdict = Judge(run.statistics, RoomMap(), off, constants);
  CHECK_FALSE(verdict.off_at);
  constants.far_off_m = 1.0;
  constants.far_off_share = 1.0;
  CHECK(Judge(run.statistics, RoomMap(), off, constants).trust == Trust::kGood);
  JudgeLeftOut({30}, verdict, constants);
  CHECK(verdict.trust == Trust::kGood);

  const MapPieces pieces{
      .num_pieces = 2, .num_breaks = 1, .num_matched = 100, .pieces = {{9, 60, 9.0}, {9, 40, 9.0}}, .breaks = {}};
  CHECK(Run().Add(60).Add(40, Float).Judged(pieces).trust == Trust::kDoubtful);
  CHECK(Run().Add(60).Add(40, Float).Judged(pieces, constants).trust == Trust::kGood);
  const MapPieces many{
      .num_pieces = 9, .num_breaks = 8, .num_matched = 100, .pieces = {{9, 20, 9.0}, {9, 10, 9.0}}, .breaks = {}};
  CHECK(Run().Add(20).Add(80, Float).Judged(many).trust == Trust::kBad);
  CHECK(Run().Add(20).Add(80, Float).Judged(many, constants).trust == Trust::kDoubtful);
}

TEST_CASE("a threshold of agreement, or of contradiction, is the one that is given") {
  Run against_wall;
  Run to_and_fro;
  for (int i = 0; i < 50; ++i) {
    ScanMatch match = against_wall.Next();
    match.T_map_laser = {0.0, 0.2 * (i % 2), 0.0};
    against_wall.statistics.Add(match.utime, LookAhead(i % 5 < 3 ? 3.0f : 2.05f));
    against_wall.statistics.Add(match);
  }
  for (int i = 0; i < 400; ++i) {
    const double along_m = 0.05 * (i % 200 < 100 ? i % 200 : 199 - i % 200);
    const Pose2 truth{-2.5 + along_m, 0.0, i < 200 ? 0.0 : 0.3};
    ScanMatch match = to_and_fro.Next();
    match.T_map_laser = {truth.x_m, truth.y_m + (i < 200 ? 0.0 : 0.8), truth.yaw_rad};
    to_and_fro.statistics.Add(match.utime, FindValidRays(ScanNiche(truth, i), {}));
    to_and_fro.statistics.Add(match);
  }
  DiagnosisConstants::Verdict constants;
  constants.least_agreement = 0.3;
  CHECK(Judge(against_wall.statistics, MakeWall()).trust == Trust::kBad);
  CHECK(Judge(against_wall.statistics, MakeWall(), kOnePiece, constants).trust == Trust::kDoubtful);
  constants.fair_agreement = 0.3;
  CHECK(Judge(against_wall.statistics, MakeWall(), kOnePiece, constants).trust == Trust::kGood);

  constants.few_looks = constants.very_few_looks = 100'000;
  CHECK(Mentions(to_and_fro.Judged(), "contradict others"));
  CHECK_FALSE(Mentions(to_and_fro.Judged(kOnePiece, constants), "contradict others"));
  constants = {};
  constants.most_contradict = constants.most_of_few_contradict = 1.0;
  CHECK_FALSE(Mentions(to_and_fro.Judged(kOnePiece, constants), "contradict others"));
}
TEST_CASE("what a verdict cannot judge is said: loops that are still searched, and where a robot was told to be") {
  Verdict verdict = Run().Add(200).Judged();
  REQUIRE(verdict.trust == Trust::kGood);
  JudgeToldStarts(0, verdict);
  const std::size_t num_lines = FormatVerdict(verdict).size();
  JudgeToldStarts(3, verdict);
  CHECK(verdict.trust == Trust::kGood);
  REQUIRE(FormatVerdict(verdict).size() == num_lines + 1);
  CHECK(FormatVerdict(verdict).back().find("was told where it is 3 times (START_POSE)") != std::string::npos);
  JudgeUnsearched(verdict);
  CHECK(verdict.trust == Trust::kDoubtful);
  CHECK(FormatVerdict(verdict).back().find("loops were still searched") != std::string::npos);
}
