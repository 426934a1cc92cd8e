#!/usr/bin/env python3
"""Says what each constant of the matcher is worth: halves and doubles it, one at a time, and maps logs and worlds anew.

usage: tests/ablation/ablate.py [--only TEXT] [--seeds 1,2,3] [--logs quick|all] [--out FILE]
  --seeds       of the varied program; that as it is has 1 to 5
  --only TEXT   the constants whose name holds this, as Search.window_m
  --logs        quick: those of a second or two (default); all: all at hand
  --out FILE    a line for each constant, added as soon as it is known; what is there already is not measured again.
                scripts/results ablation goes on with the default one, and writes the table of RESULTS.md
Builds a program of its own in build/ablation, whose constants are read from the environment. An error of a log is compared
with those of the program as it is: by how many spreads of its seeds it is off. A constant by which no log is off by more
than one earns nothing there.
"""
import argparse
import gzip
import math
import os
import pathlib
import re
import shutil
import statistics
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
PROJECT = HERE.parents[1]
sys.path.insert(0, str(HERE.parent / "results"))
BUILD = PROJECT / "build/ablation"
BIN = BUILD / "build/bin"

import json  # noqa: E402
from measure import DATA, SICK, Failed, Section, call, map_all, progress  # noqa: E402
from page import table  # noqa: E402

CONSTANTS = "common/match/match_constants.hpp"
TUNABLE = re.compile(r"^(    (?:bool|int|float|double|std::\w+) )(\w+) = ([^;]+);", re.M)
READ = """
#include <cstdlib>
#include <cstring>

namespace crsm {
/// The value, unless the environment has another one: CRSM_VARIED="Search.window_m=0.8 Search.restart_draws=3".
template <class Value>
inline Value Varied(const char* name, Value value) {
  static const char* const varied = std::getenv("CRSM_VARIED");
  const std::size_t length = std::strlen(name);
  for (const char* at = varied; at && (at = std::strstr(at, name)); at += length) {
    if ((at == varied || at[-1] == ' ') && at[length] == '=') return static_cast<Value>(std::atof(at + length + 1));
  }
  return value;
}
}  // namespace crsm
"""

OUT = PROJECT / "out/ablation.tsv"
PLAIN_SEEDS = range(1, 6)
NO_WHEELS = [*SICK, "--no-odometry"]
RELATIONS, TRUTH, END, AGREEMENT = range(4)
# Name, source, flags, and what the error is of: relations, a true path, where the way ends, how well
# rays agree with the map.
CASES = [
    ("seattle, wheels", "beyond/seattle.clf.gz", SICK, TRUTH, "beyond/seattle.ref.tum.gz"),
    ("seattle", "beyond/seattle.clf.gz", NO_WHEELS, TRUTH, "beyond/seattle.ref.tum.gz"),
    ("belgioioso, wheels", "beyond/belgioioso.clf.gz", SICK, TRUTH, "beyond/belgioioso.ref.tum.gz"),
    ("bare hallway", "beyond/hallway_bare.bag.gz", [], END, 17.1),
    ("race track", "beyond/race_track_4mps_10hz.lcm.gz", [], TRUTH, "beyond/race_track_4mps_10hz.ref.tum.gz"),
    ("sweep 20 Hz", "beyond/sweep_20hz_fast_turns_no_times.lcm.gz", [], TRUTH,
     "beyond/sweep_20hz_fast_turns_no_times.ref.tum.gz"),
    ("rover", "beyond/rplidar-rover3.bag.gz", ["--preset", "rplidar-a1"], AGREEMENT, None),
    ("corridor, wheels", "beyond/bare_corridor_40m_wheels.world", ["--range-max-m", 10.6], TRUTH, None),
    ("demo", "sim:demo", [], TRUTH, None),
]
MORE = [
    ("edmonton, wheels", "beyond/edmonton.clf.gz", SICK, TRUTH, "beyond/edmonton.ref.tum.gz"),
    ("edmonton", "beyond/edmonton.clf.gz", NO_WHEELS, TRUTH, "beyond/edmonton.ref.tum.gz"),
    ("arena", "beyond/ld19-arena.db3.gz", [], AGREEMENT, None),
    ("aces at 8 m", "radish/aces.clf.gz", [*NO_WHEELS, "--range-max-m", 8.42], RELATIONS, "radish/aces.relations"),
    ("intel", "radish/intel.clf.gz", NO_WHEELS, RELATIONS, "radish/intel.relations"),
    ("fr079", "radish/fr079.clf.gz", NO_WHEELS, RELATIONS, "radish/fr079.relations"),
    ("aces", "radish/aces.clf.gz", NO_WHEELS, RELATIONS, "radish/aces.relations"),
    ("killian", "radish/killian.clf.gz", NO_WHEELS, RELATIONS, "radish/killian.relations"),
    ("fr-clinic, wheels", "radish/fr-clinic.clf.gz", SICK, RELATIONS, "radish/fr-clinic.relations"),
    ("fr-clinic", "radish/fr-clinic.clf.gz", NO_WHEELS, RELATIONS, "radish/fr-clinic.relations"),
    ("belgioioso", "beyond/belgioioso.clf.gz", NO_WHEELS, TRUTH, "beyond/belgioioso.ref.tum.gz"),
    ("campus", "sim:campus:3000:{seed}", SICK, TRUTH, None),
]


def read_tunables():
    """Names, and values as they are written."""
    struct, found = None, []
    for line in (PROJECT / CONSTANTS).read_text().splitlines():
        if begin := re.match(r"  struct (\w+) \{", line):
            struct = begin[1]
        elif tunable := TUNABLE.match(line):
            found.append((f"{struct}.{tunable[2]}", tunable[3]))
    return found


def build():
    source = BUILD / "source"
    shutil.rmtree(source, ignore_errors=True)
    files = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=PROJECT, capture_output=True, text=True, check=True).stdout.split("\n")
    for name in filter(None, files):
        if not (PROJECT / name).is_file() or name.startswith(("logs/", "tests/view", "tests/readme")):
            continue
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(PROJECT / name, source / name)
    path, struct, lines = source / CONSTANTS, None, []
    for line in path.read_text().splitlines():
        if begin := re.match(r"  struct (\w+) \{", line):
            struct = begin[1]
        lines.append(TUNABLE.sub(lambda found: f'{found[1]}{found[2]} = [] {{ static const auto value = Varied<{found[1].strip()}>'
                                               f'("{struct}.{found[2]}", {found[3]}); return value; }}();', line))
    path.write_text("\n".join(lines).replace("#include <cstdint>\n", "#include <cstdint>\n" + READ, 1) + "\n")
    for path in (source / "common").rglob("*.[ch]pp"):
        text = path.read_text()
        if "constexpr MatchConstants" in text:
            path.write_text(text.replace("constexpr MatchConstants", "const MatchConstants"))
    subprocess.run(["cmake", "-G", "Ninja", "-S", source, "-B", BUILD / "build", "-DCMAKE_BUILD_TYPE=Release"], check=True,
                   stdout=sys.stderr)
    subprocess.run(["ninja", "-C", BUILD / "build", "slam_offline", "slam_eval"], check=True, stdout=sys.stderr)


def measure(case, seed, varied):
    """The error [m]; inf where there is no map. agreement: one less its share."""
    _, source, flags, how, reference = case
    with tempfile.TemporaryDirectory(prefix="crsm_ablate_") as folder:
        out = pathlib.Path(folder) / "out"
        log = source.format(seed=seed)
        if not log.startswith("sim:"):
            log = str(DATA / log)
            if log.endswith((".db3.gz", ".bag.gz")):
                plain = pathlib.Path(folder) / pathlib.Path(log).stem
                plain.write_bytes(gzip.decompress(pathlib.Path(log).read_bytes()))
                log = str(plain)
            elif log.endswith(".world"):
                log = f"sim:{log}"
        try:
            call(BIN / "slam_offline", log, *flags, "--seed", seed, "--out", out, environment={"CRSM_VARIED": varied})
            if how == RELATIONS:
                return json.loads(call(BIN / "slam_eval", "relations", out, DATA / reference, "--json"))["translation_m"]["mean"]
            if how == TRUTH:
                truth = []
                if reference:
                    truth = [out / "reference.tum"]
                    truth[0].write_bytes(gzip.decompress((DATA / reference).read_bytes()))
                return json.loads(call(BIN / "slam_eval", "trajectory", out / "trajectory.tum",
                                       *(truth or [out / "truth.tum"]), "--align", "--json"))["rmse_m"]
            summary = json.loads((out / "summary.json").read_text())
            if how == AGREEMENT:
                return 1.0 - summary["verdict"]["agreement"]
            poses = [list(map(float, line.split()))
                     for line in (out / "trajectory.tum").read_text().splitlines() if line[:1] not in ("#", "")]
            return abs(math.dist(poses[0][1:3], poses[-1][1:3]) - reference)
        except (Failed, KeyError, IndexError, OSError):
            return math.inf


def measure_all(cases, seeds, varied, title):
    found = map_all(title, {(case[0], seed): lambda case=case, seed=seed: measure(case, seed, varied)
                            for case in cases for seed in seeds})
    return {case[0]: [found[case[0], seed] for seed in seeds] for case in cases}


def compare(plain, other):
    """The log that is off most from its median error, in spreads of its seeds."""
    worst = (0.0, "")
    for name, before in plain.items():
        usual, now = statistics.median(before), statistics.median(other[name])
        off = (now - usual) / max(max(before) - min(before), 0.05 * usual, 0.002)
        if abs(off) > abs(worst[0]):
            worst = (off, f"{name} {usual:.3f} -> {now:.3f}")
    return worst


def ablate(only, seeds, cases, out):
    """A line for each constant: its name, its value, and by each of two others the log that is off most."""
    out.parent.mkdir(parents=True, exist_ok=True)
    known = {line.split("\t")[0] for line in out.read_text().splitlines()} if out.exists() else set()
    asked = [(name, value) for name, value in read_tunables() if only in name and name not in known]
    if not asked:
        return
    build()
    plain = measure_all(cases, PLAIN_SEEDS, "", "as it is")
    for name, errors in plain.items():
        progress(f"{name}: {' '.join(f'{error:.3f}' for error in errors)}")
    for name, value in asked:
        number = eval(value.replace("'", ""), {})  # noqa: S307: of our own source
        texts = [name, value]
        for factor in (0.5, 2.0):
            varied = (not number) if isinstance(number, bool) else type(number)(number * factor)
            if varied == number:
                varied = number + 1
            off, where = compare(plain, measure_all(cases, seeds, f"{name}={float(varied)}", f"{name} = {varied}"))
            texts.append(f"{varied:g}: {off:+.1f} {where}")
        with out.open("a") as file:
            file.write("\t".join(texts) + "\n")
        print("\t".join(texts), flush=True)


def tabulate(out):
    """The constants that there are, as the table of RESULTS.md."""
    found = {}
    for line in out.read_text().splitlines():
        name, value, *others = line.split("\t")
        found[name, value] = [other.replace(": ", "<br>", 1) for other in others]
    return table(["constant", "value", "half of it", "twice it"],
                 [[f"`{name}`", value, *found[name, value]] for name, value in read_tunables() if (name, value) in found])


def at_hand(logs):
    return [case for case in CASES + (MORE if logs == "all" else [])
            if case[1].startswith("sim:") or (DATA / case[1]).exists()]


def measure_section():
    ablate("", [1], at_hand("quick"), OUT)
    return tabulate(OUT)


SECTIONS = [
    Section("Ablation", 240, "What each constant of the matcher is worth: with half and with twice its value, the log or world "
            "whose error is off most from its median over five seeds: by how many spreads of these, and from how many "
            "metres to how many. A constant that is missing was not measured yet.", ["tests/ablation/ablate.py --seeds 1"], measure_section,
            tuple(case[1] for case in CASES if not case[1].startswith("sim:"))),
]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="")
    parser.add_argument("--seeds", default="1,2,3")
    parser.add_argument("--logs", choices=("quick", "all"), default="quick")
    parser.add_argument("--out", type=pathlib.Path, default=OUT)
    arguments = parser.parse_args()
    ablate(arguments.only, [int(seed) for seed in arguments.seeds.split(",")], at_hand(arguments.logs), arguments.out)


if __name__ == "__main__":
    main()
