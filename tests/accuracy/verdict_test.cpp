#include "common/diagnosis/verdict.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "accuracy/gate.hpp"
#include "accuracy/run.hpp"
#include "accuracy/spoil.hpp"
#include "catch.hpp"
#include "real_logs.hpp"

namespace crsm {
namespace {

/// Maps a recording, prints a line of the table, and returns the verdict.
Verdict JudgeMapOf(const std::string& name, const Recording& recording, const Parameters& parameters) {
  RunStatistics statistics;
  const Outcome outcome =
      Map(recording, parameters, [&](const Slam::Step& step) { statistics.Add(step.scan.utime, step.scan.rays); });
  for (const ScanMatch& match : outcome.matches) statistics.Add(match);
  const Verdict verdict = Judge(statistics, *outcome.map, outcome.slam->mapper().FindPiecesAndError());
  const auto& values = verdict.values;
  fmt::print("{:<34} {:<9} scans {:>5}  lost {:>5}  degenerate {:>5}  fitness {:.2f}  agreement {:.2f}  far {:>4}\n",
             name, Name(verdict.trust), values.counts.scans(), values.counts.lost, values.degenerate,
             values.mean_fitness, verdict.agreement.value_or(0.0), values.far_steps);
  std::fflush(stdout);
  return verdict;
}

void CheckGood(const std::string& name, const std::string& source, const std::string& preset, std::uint64_t seed) {
  INFO(name);
  const Parameters parameters = ShippedParameters(preset, seed);
  CHECK(JudgeMapOf(name, Record(source, parameters), parameters).trust == Trust::kGood);
}

void CheckDoubtful(const std::string& name, const std::string& source, const std::string& preset) {
  INFO(name);
  const Parameters parameters = ShippedParameters(preset, 1);
  CHECK(JudgeMapOf(name, Record(source, parameters), parameters).trust == Trust::kDoubtful);
}

/// By their scans alone: a search for loops among spoilt ones takes minutes, and makes them no better.
void CheckBad(const std::string& name, const std::string& source, const std::string& preset,
              const std::vector<std::string>& ways) {
  const Parameters parameters = ShippedParameters(preset, 1, {"--no-loops"});
  const Recording recording = Record(source, parameters);
  for (const std::string& way : ways) {
    const std::string title = fmt::format("{}, {}", name, way);
    INFO(title);
    const Verdict verdict = JudgeMapOf(title, Spoil(recording, way), parameters);
    CHECK(verdict.trust == Trust::kBad);
    CHECK(!verdict.warnings.empty());
  }
}

}  // namespace

TEST_CASE("maps of simulated worlds are called good") {
  for (const char* world : {"demo", "corridor", "hall", "env1", "env2", "env3", "env4"}) {
    CheckGood(world, fmt::format("sim:{}", world), "", 1);
  }
}

TEST_CASE("maps of spoilt scans of simulated worlds are called bad") {
  CheckBad("hall", "sim:hall", "", WaysToSpoil());
  std::vector<std::string> ways = WaysToSpoil();
  std::erase(ways, "every 20th scan");  // a scan every two seconds is enough there: see the course "demo, slow"
  CheckBad("demo", "sim:demo", "", ways);
}

TEST_CASE("maps of real logs that are right are called good", "[logs]") {
  for (const char* name : {"fr079", "intel", "aces", "killian"}) {
    if (const auto log = FindRealLog(fmt::format("radish/{}.clf.gz", name))) CheckGood(name, *log, "sick", 1);
  }
}

TEST_CASE("maps of corridors that look alike, driven once, are good") {  // right to 0.15 m, and say up to 0.9 m
  for (std::uint64_t seed = 1; seed <= 3; ++seed) CheckGood("twins", "sim:twins", "", seed);
}

TEST_CASE("maps of drives of which a third is on degenerate scans, without a loop, are doubtful", "[logs]") {
  for (const char* name : {"exp1", "exp3"}) {
    if (const auto log = FindRealLog(fmt::format("urg04lx/{}.clf.gz", name))) CheckDoubtful(name, *log, "urg-04lx");
  }
}

TEST_CASE("maps of spoilt scans of real logs are called bad", "[logs]") {
  if (const auto log = FindRealLog("radish/fr079.clf.gz")) CheckBad("fr079", *log, "sick", WaysToSpoil());
  // Half the angles of a laser that sees only 4 m still make a map that agrees with itself: that one is called
  // doubtful.
  if (const auto log = FindRealLog("urg04lx/exp3.clf.gz")) {
    CheckBad("exp3", *log, "urg-04lx", {"angles in degrees", "beams shuffled", "ranges +- 0.3 m", "every 20th scan"});
  }
}

}  // namespace crsm
