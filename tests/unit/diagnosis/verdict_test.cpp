#include "common/diagnosis/verdict.hpp"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "common/results/summary.hpp"
#include "diagnosis/wall_ahead.hpp"
#include "synthetic_scans.hpp"

using namespace crsm;

namespace {

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
  void Add(int num, Change&& change) {
    for (int i = 0; i < num; ++i) {
      ScanMatch match = Next();
      change(match);
      statistics.Add(match);
    }
  }
  void Add(int num) {
    Add(num, [](ScanMatch&) {});
  }

  Verdict Judged() const { return Judge(statistics, ByteMap(0.1)); }
};

bool Mentions(const Verdict& verdict, const std::string& words) {
  const auto lines = FormatVerdict(verdict);
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(words) != std::string::npos; });
}

void Lose(ScanMatch& match) { match.state = MatchState::kLost; }

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

TEST_CASE("a run whose scans all fit is good, and says how many there were") {
  Run run;
  run.Add(100);
  const Verdict verdict = run.Judged();
  CHECK(verdict.trust == Trust::kGood);
  CHECK(verdict.warnings.empty());
  CHECK(verdict.text == "100 of 100 scans mapped, 0 lost, 0 degenerate, mean fitness 0.80");
}

TEST_CASE("the longer the way that nothing told, the further off the map may be, and it is said behind where") {
  Run short_one;
  short_one.Add(100);
  CHECK(*short_one.Judged().off_m < 0.05);
  CHECK_FALSE(short_one.Judged().off_at_m);
  CHECK(Mentions(short_one.Judged(), "parts of it may be off by up to 0.04 m"));

  Run open;  // 3.75 m of 12.5 m, in two pieces
  open.step_m = 0.25;
  open.Add(10);
  open.Add(10, [](ScanMatch& match) { match.state = MatchState::kDegenerate; });
  open.Add(10);
  open.Add(5, [](ScanMatch& match) { match.state = MatchState::kDegenerate; });
  open.Add(15);
  CHECK(open.Judged().trust == Trust::kGood);
  CHECK(*open.Judged().off_m > 0.1);
  REQUIRE(open.Judged().off_at_m);
  CHECK(open.Judged().off_at_m->x() == Approx(5.0));
  CHECK(Mentions(open.Judged(), "behind x 5 m, y 0 m"));

  Run lost;
  lost.Add(100);
  lost.Add(25, Lose);
  lost.Add(900);
  CHECK(*lost.Judged().off_m > 20.0);

  Run bad;
  bad.Add(100, [](ScanMatch& match) { match.fitness = 0.3; });
  CHECK_FALSE(bad.Judged().off_m);
}

TEST_CASE("no scan at all is bad, a few tell nothing") {
  CHECK(Run().Judged().trust == Trust::kBad);
  CHECK(Mentions(Run().Judged(), "no scan came"));
  Run few;
  few.Add(19);
  CHECK(few.Judged().trust == Trust::kDoubtful);
  few.Add(1);
  CHECK(few.Judged().trust == Trust::kGood);
}

TEST_CASE("scans without rays point at the range or its unit") {
  Run run;
  run.Add(100, [](ScanMatch& match) {
    match.state = MatchState::kFirst;  // the map stays empty
    match.num_critical = 0;
  });
  CHECK(run.Judged().trust == Trust::kBad);
  CHECK(Mentions(run.Judged(), "--range-max-m"));
  CHECK(run.Judged().warnings.size() == 1);  // nothing else is known
  CHECK(run.Judged().text.starts_with("0 of 100 scans mapped"));
}

TEST_CASE("a low fitness is bad, a fair one doubtful; with jumps the cause is in the rate or the unit of angles") {
  Run still;
  still.Add(100, [](ScanMatch& match) { match.fitness = 0.45; });
  CHECK(still.Judged().trust == Trust::kBad);
  CHECK(Mentions(still.Judged(), "--angle-scale"));
  Run fair;
  fair.Add(100, [](ScanMatch& match) { match.fitness = 0.55; });
  CHECK(fair.Judged().trust == Trust::kDoubtful);
  Run jumping;
  jumping.Add(100, [](ScanMatch& match) {
    match.fitness = 0.45;
    match.T_map_laser.x_m *= 10.0;
  });
  CHECK(jumping.Judged().trust == Trust::kBad);
  CHECK(Mentions(jumping.Judged(), "degrees"));
}

TEST_CASE("a laser that stands is told so, and its low fitness accuses neither angles nor ranges") {
  const auto Stand = [](ScanMatch& match) {
    match.T_map_laser = {match.utime % 2 == 0 ? 0.05 : 0.0, 0.0, match.utime % 3 == 0 ? 0.02 : 0.0};
  };
  Run low;
  low.Add(100, [&](ScanMatch& match) {
    Stand(match);
    match.fitness = 0.33;
  });
  CHECK(low.Judged().trust == Trust::kDoubtful);
  CHECK(Mentions(low.Judged(), "the laser hardly moved (0.05 m and 1 degrees at most)"));
  CHECK_FALSE(Mentions(low.Judged(), "angles"));
  Run good;
  good.Add(100, Stand);
  CHECK(good.Judged().trust == Trust::kGood);
  CHECK(Mentions(good.Judged(), "the laser hardly moved"));
  Run turning;
  turning.Add(100, [](ScanMatch& match) {
    match.T_map_laser = {0.0, 0.0, 0.002 * static_cast<double>(match.utime)};
    match.fitness = 0.33;
  });
  CHECK(turning.Judged().trust == Trust::kBad);
  CHECK(Mentions(turning.Judged(), "angles"));
}

TEST_CASE("a map without more than a tenth of the recording is not called good") {
  Run run;
  run.Add(90);
  Verdict tenth = run.Judged();
  JudgeLeftOut(10, tenth);
  CHECK(tenth.trust == Trust::kGood);
  Verdict more = run.Judged();
  JudgeLeftOut(30, more);
  CHECK(more.trust == Trust::kDoubtful);
  CHECK(Mentions(more, "30 of 120 scans of the recording are left out (25 %)"));
  Verdict none = Run().Judged();
  JudgeLeftOut(30, none);
  CHECK_FALSE(Mentions(none, "left out"));  // nothing came: that is said
}

TEST_CASE("lost scans are bad from a twentieth on, and from a fiftieth on where the laser moves far") {
  Run few;
  few.Add(96);
  few.Add(4, Lose);
  CHECK(few.Judged().trust == Trust::kGood);
  Run many;
  many.Add(94);
  many.Add(6, Lose);
  CHECK(many.Judged().trust == Trust::kBad);
  Run moving;
  moving.Add(90);
  moving.Add(6, [](ScanMatch& match) { match.T_map_laser.x_m *= 10.0; });
  moving.Add(4, Lose);
  CHECK(moving.Judged().trust == Trust::kBad);
  CHECK(Mentions(moving.Judged(), "too few scans"));
}

TEST_CASE("a long time lost, or many far steps, make a map doubtful") {
  Run lost;
  lost.Add(1000);
  lost.Add(20, Lose);
  lost.Add(1000);
  CHECK(lost.statistics.values().longest_lost == 20);
  CHECK(lost.Judged().trust == Trust::kDoubtful);
  Run turning;
  turning.Add(100, [](ScanMatch& match) { match.T_map_laser.yaw_rad = match.utime % 5 == 0 ? 0.3 : 0.0; });
  CHECK(turning.Judged().trust == Trust::kDoubtful);
  CHECK(Mentions(turning.Judged(), "deskewing (--sweep-s)"));
}

TEST_CASE("where nothing holds the position along an axis, lengths are not known") {
  Run run;
  run.Add(100, [](ScanMatch& match) { match.state = match.utime > 10 ? MatchState::kDegenerate : match.state; });
  CHECK(run.Judged().trust == Trust::kBad);
  CHECK(Mentions(run.Judged(), "do not fix the position in one direction"));
}

TEST_CASE("odometry that turns the other way tells that one of the two is mirrored") {
  const auto Judged = [](double sign) {
    Run run;
    run.Add(200, [&](ScanMatch& match) {
      const double turn = 0.1 * static_cast<double>(match.utime % 20);
      match.T_map_laser.yaw_rad = turn;
      match.T_odom_robot = Pose2{match.T_map_laser.x_m, 0.0, sign * turn};
    });
    return run.Judged();
  };
  CHECK(Judged(1.0).trust == Trust::kGood);
  CHECK(Judged(-1.0).trust == Trust::kDoubtful);
  CHECK(Mentions(Judged(-1.0), "mirrored"));
}

TEST_CASE("odometry that drives backwards tells that the laser is mounted rotated") {
  Run run;
  run.Add(200, [](ScanMatch& match) { match.T_odom_robot = Pose2{-match.T_map_laser.x_m, 0.0, 0.0}; });
  CHECK(run.Judged().trust == Trust::kDoubtful);
  CHECK(Mentions(run.Judged(), "mounted rotated"));
}

TEST_CASE("on a finished map lost scans are of another building") {
  const auto Judged = [](int num_lost) {
    Run run;
    run.utime = 1;  // no first scan
    run.Add(num_lost, [](ScanMatch& match) {
      match.map_version = 0;
      match.state = MatchState::kLost;
    });
    run.Add(100 - num_lost, [](ScanMatch& match) { match.map_version = 0; });
    return run.Judged();
  };
  CHECK(Judged(5).trust == Trust::kGood);
  CHECK(Judged(30).trust == Trust::kDoubtful);
  CHECK(Judged(80).trust == Trust::kBad);
  CHECK(Mentions(Judged(80), "another building"));
  CHECK(Mentions(Judged(80), "the poses are not to be trusted"));
}

TEST_CASE("agreement is the share of rays that end at walls, in whatever order rays and matches come") {
  CHECK(AgreementOf(2.05f, 30) == 1.0);
  CHECK(AgreementOf(2.05f, 30, false) == 1.0);
  CHECK(AgreementOf(3.0f, 30) == 0.0);  // through the wall
  CHECK(AgreementOf(1.0f, 30) == 0.0);  // in the open
}

TEST_CASE("agreement is unknown below twenty scans, and its sample is bounded") {
  CHECK(!AgreementOf(2.05f, 19));
  CHECK(AgreementOf(2.05f, 20) == 1.0);
  CHECK(AgreementOf(2.05f, 5000) == 1.0);
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

TEST_CASE("scans that contradict the map are bad") {
  Run run;
  for (int i = 0; i < 50; ++i) {
    ScanMatch match = run.Next();
    match.T_map_laser = {};
    run.statistics.Add(match.utime, LookAhead(i % 5 < 3 ? 3.0f : 2.05f));
    run.statistics.Add(match);
  }
  const Verdict verdict = Judge(run.statistics, MakeWall());
  CHECK(verdict.agreement == Approx(0.4));
  CHECK(verdict.trust == Trust::kBad);
  CHECK(Mentions(verdict, "contradict the map: only 40 %"));
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

TEST_CASE("many scans in a row in which nothing holds the position along an axis are doubtful, unless odometry does") {
  const auto IsOpen = [](ScanMatch& match) { match.state = MatchState::kDegenerate; };
  const auto IsHeldByWheels = [&](ScanMatch& match) {
    match.state = MatchState::kDegenerate;
    match.T_odom_robot = match.T_map_laser;
  };
  Run bare{0.01};
  bare.Add(200);
  bare.Add(150, IsOpen);
  bare.Add(3);  // by chance
  bare.Add(150, IsOpen);
  CHECK(bare.Judged().trust == Trust::kGood);
  bare.Add(1, IsOpen);
  bare.Add(200);
  CHECK(bare.Judged().trust == Trust::kDoubtful);
  CHECK(Mentions(bare.Judged(), "301 scans in a row are degenerate"));

  Run with_a_door{0.01};
  with_a_door.Add(200);
  with_a_door.Add(200, IsOpen);
  with_a_door.Add(4);
  with_a_door.Add(200, IsOpen);
  with_a_door.Add(200);
  CHECK(with_a_door.Judged().trust == Trust::kGood);

  Run with_wheels{0.01};
  with_wheels.Add(200);
  with_wheels.Add(400, IsHeldByWheels);
  CHECK(with_wheels.Judged().trust == Trust::kGood);
}

TEST_CASE("loops that were rejected make a map doubtful, and never better than it was") {
  Run run;
  run.Add(100);
  Verdict verdict = run.Judged();
  JudgeLoops(12, 0, verdict);
  CHECK(verdict.trust == Trust::kGood);
  CHECK(verdict.warnings.empty());
  JudgeLoops(12, 3, verdict);
  CHECK(verdict.trust == Trust::kDoubtful);
  CHECK(Mentions(verdict, "3 of 15 loops were rejected"));

  Verdict bad = Run().Judged();
  JudgeLoops(12, 3, bad);
  CHECK(bad.trust == Trust::kBad);
}

TEST_CASE("wheels that tell another way than the laser make a map doubtful, and further off") {
  Run run;
  run.step_m = 0.25;
  run.Add(100);
  const Verdict good = run.Judged();
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

  for (const Verdict& verdict : {JudgeBy(0.22, 0.1, 8), JudgeBy(0.06, 0.3, 8)}) {
    CHECK(verdict.trust == Trust::kDoubtful);
    CHECK(Mentions(verdict, "the wheels and the laser tell different ways"));
  }
  CHECK(JudgeBy(0.22, 0.1, 8).off_m > good.off_m);
}

TEST_CASE("a map in pieces is never good where more than a fiftieth of the matched scans is on others") {
  const auto JudgeWith = [](std::int64_t on_largest, std::int64_t elsewhere) {
    Run run;
    run.Add(static_cast<int>(on_largest));
    run.Add(static_cast<int>(elsewhere), Lose);  // as scans of other pieces come
    MapPieces pieces;
    pieces.num_pieces = 3;
    pieces.num_breaks = 2;
    pieces.num_matched = on_largest + elsewhere;
    pieces.pieces = {{90, on_largest, 40.0}, {20, elsewhere - 1, 5.0}, {1, 1, 0.0}};
    return Judge(run.statistics, ByteMap(0.1), pieces);
  };
  const Verdict few = JudgeWith(990, 10);
  CHECK(few.trust == Trust::kGood);
  CHECK(few.text.find("990 of 1000 scans mapped, 10 on other pieces, 0 lost") == 0);
  CHECK(Mentions(few, "the map is in 3 pieces: the largest has 990 of 1000 mapped scans; see pieces/ for 1 more"));
  const Verdict some = JudgeWith(970, 30);
  CHECK(some.trust == Trust::kDoubtful);
  CHECK(some.warnings.size() == 1);  // they are not lost
  CHECK(Mentions(some, "warning: the map is in 3 pieces: the largest has 970 of 1000 mapped scans"));
  CHECK(JudgeWith(600, 400).trust == Trust::kDoubtful);
  CHECK(JudgeWith(300, 700).trust == Trust::kDoubtful);  // right in itself
  CHECK(JudgeWith(200, 800).trust == Trust::kBad);
}

TEST_CASE("a map that hangs together by the wheels alone is doubtful, and says where it hangs on them") {
  const auto JudgeWith = [](std::int64_t num_bridged) {
    Run run;
    run.Add(1000);
    MapPieces pieces;
    pieces.num_pieces = 1;
    pieces.num_breaks = 3;
    pieces.num_bridged = num_bridged;
    pieces.num_matched = 1000;
    pieces.pieces = {{90, 1000, 40.0}};
    return Judge(run.statistics, ByteMap(0.1), pieces);
  };
  CHECK(JudgeWith(0).trust == Trust::kGood);
  CHECK(JudgeWith(2).trust == Trust::kDoubtful);
  CHECK(Mentions(JudgeWith(2), "warning: 2 of 3 interruptions of the track are bridged by the wheels alone"));
}

TEST_CASE("scans that are lost beside a piece are bad as ever") {
  Run run;
  run.Add(900);
  run.Add(100, Lose);
  MapPieces pieces;
  pieces.num_pieces = 2;
  pieces.num_breaks = 1;
  pieces.num_matched = 910;
  pieces.pieces = {{90, 900, 40.0}, {2, 10, 1.0}};
  const Verdict verdict = Judge(run.statistics, ByteMap(0.1), pieces);
  CHECK(verdict.trust == Trust::kBad);
  CHECK(Mentions(verdict, "9 % of the scans are lost"));
}

TEST_CASE(
    "a long way on degenerate scans of which hardly any place was seen twice is doubtful, unless wheels tell it") {
  const auto JudgeDrive = [](int num_degenerate, bool wheels) {
    Run run;
    run.Add(200);
    run.Add(num_degenerate, [&](ScanMatch& match) {
      match.state = MatchState::kDegenerate;
      if (wheels) match.by_wheels = WheelMotion{};
    });
    run.Add(300);
    return run.Judged();
  };
  CHECK(JudgeDrive(120, false).trust == Trust::kGood);  // 6 m
  const Verdict verdict = JudgeDrive(200, false);       // 10 m
  CHECK(verdict.trust == Trust::kDoubtful);
  CHECK(Mentions(verdict, "along 10 m of the path of 35 m nothing in view told how far the robot drove, and hardly"));
  CHECK(JudgeDrive(200, true).trust == Trust::kGood);
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

TEST_CASE("breaks that were all joined are told in one line, and speak against nothing") {
  Run run;
  run.Add(100);
  MapPieces pieces;
  pieces.num_pieces = 1;
  pieces.num_breaks = 4;
  pieces.num_matched = 100;
  pieces.pieces = {{90, 100, 40.0}};
  const Verdict verdict = Judge(run.statistics, ByteMap(0.1), pieces);
  CHECK(verdict.trust == Trust::kGood);
  CHECK(FormatVerdict(verdict).size() == 4);  // the scans, the verdict, its metres
  CHECK(Mentions(verdict, "lost or interrupted 4 times, and all parts of the map were joined"));
  pieces.num_breaks = 1;
  CHECK(Mentions(Judge(run.statistics, ByteMap(0.1), pieces), "lost or interrupted once, and the two parts"));
}

TEST_CASE("summary.json has the pieces, and where and why each break was") {
  Summary summary;
  CHECK_FALSE(nlohmann::json::parse(FormatSummary(summary)).contains("breaks"));
  MapPieces pieces;
  pieces.num_pieces = 3;
  pieces.num_breaks = 2;
  pieces.num_matched = 100;
  pieces.pieces = {{90, 80, 40.0}, {10, 15, 5.0}, {2, 5, 0.5}};
  pieces.breaks = {{7, 40, BreakReason::kGap, 9.5, {1.0, 2.0, 0.5}, 1, 2}, {9, 60, BreakReason::kLost, 1.5, {}, 1, 1}};
  summary.pieces = pieces;
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
  Run run;
  run.Add(94);
  run.Add(6, Lose);
  Summary summary;
  summary.verdict = run.Judged();
  const auto json = nlohmann::json::parse(FormatSummary(summary))["verdict"];
  CHECK(json["trust"] == "bad");
  CHECK(json["agreement"].is_null());
  CHECK(json["lines"].size() == 3);
  CHECK(json["lines"][1] == "the map is not to be trusted");
  CHECK(json["lines"][2].get<std::string>().rfind("warning: 6 % of the scans are lost", 0) == 0);
}
