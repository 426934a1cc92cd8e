"""How far off maps and paths are: real logs, simulated drives, long ones, and the worlds of the paper."""

import gzip
import pathlib
import re
import tempfile

from measure import (BIN, DATA, SICK, Section, call, call_tests, map_all, map_log, map_radish, median,
                     radish)
from page import table

LOGS = ("fr079", "intel", "aces", "killian")
# Mean translational error of the relations, as Hess et al. (2016) print it for Cartographer, Table II.
CARTOGRAPHER = {"fr079": "0.045", "intel": "0.023", "aces": "0.038", "killian": "0.040, with odometry"}
FRESH_SEEDS = range(201, 221)  # on which no setting was chosen
REAL_RELATIONS = tuple(f"radish/{name}.{kind}" for name in LOGS for kind in ("clf.gz", "relations"))
EVALUATE = "build/bin/slam_eval relations DIR LOG.relations      # fr079: --laser-x-m -0.04"


def errors(results, *begin):
    return [run.error_m for key, run in results.items() if key[:len(begin)] == begin]


def measure_logs():
    results = map_all("logs", {(name, loops, seed): lambda name=name, loops=loops, seed=seed: map_radish(
        name, ["--seed", seed, *([] if loops else ["--no-loops"])])
        for name in LOGS for loops in (True, False) for seed in FRESH_SEEDS})
    rows = []
    for name in LOGS:
        timed = [map_radish(name, ["--seed", seed]) for seed in FRESH_SEEDS[:5]]  # nothing of ours beside them
        summary = timed[0].summary
        loops, none = errors(results, name, True), errors(results, name, False)
        rows.append([name, f"{summary['path_length_m'] / 1000:.1f}", f"{summary['scans']:,}",
                     *(f"{pick(found):.4f}" for found in (loops, none) for pick in (median, max)), CARTOGRAPHER[name],
                     f"{median([run.timing_ms('p50_ms') for run in timed]):.2f}",
                     f"{median([run.timing_ms('p99_ms') for run in timed]):.1f}"])
    return table(["log", "path [km]", "scans", "error, median [m]", "error, worst [m]", "with `--no-loops`, median [m]",
                  "with `--no-loops`, worst [m]", "Cartographer [m]", "scan, median [ms]",
                  "scan, 99th percentile [ms]"], rows)


def measure_short_reach():
    ways = {"as the preset `sick` draws": [],
            "drawn every 0.1 m": ["--update-distance-m", 0.1, "--update-angle-rad", 0.1]}
    results = map_all("short-reach", {(name, way, seed): lambda name=name, flags=flags, seed=seed: map_radish(
        name, ["--range-max-m", 8.42, "--seed", seed, *flags])
        for name in ("intel", "aces") for way, flags in ways.items() for seed in range(1, 9)})
    rows = [[name, way, *(f"{pick(errors(results, name, way)):.3f}" for pick in (min, median, max))]
            for name in ("intel", "aces") for way in ways]
    return table(["log", "map", "error, least [m]", "median [m]", "worst [m]"], rows)


def keep_every_fifth(name, folder):
    """As awk '$1 != "FLASER" || n++ % 5 == 0' does."""
    path = pathlib.Path(folder) / f"{name}.clf"
    number = 0
    with gzip.open(DATA / radish(name), "rb") as log, open(path, "wb") as kept:
        for line in log:
            if line.startswith(b"FLASER "):
                number += 1
                if number % 5 != 1:
                    continue
            kept.write(line)
    return path


def measure_few_scans():
    with tempfile.TemporaryDirectory(prefix="crsm_results_") as folder:
        fifth = {name: keep_every_fifth(name, folder) for name in ("intel", "aces")}
        jobs = {(name, share, odometry, seed): lambda name=name, log=log, odometry=odometry, seed=seed: map_radish(
            name, ["--seed", seed], log, odometry)
            for share, logs, seeds in (("every scan", dict.fromkeys(LOGS), range(1, 6)),
                                       ("every fifth scan", fifth, range(1, 9)))
            for name, log in logs.items() for odometry in (False, True) for seed in seeds}
        results = map_all("few-scans", jobs)
    rows = []
    for name, share in dict.fromkeys(key[:2] for key in jobs):
        without, with_ = errors(results, name, share, False), errors(results, name, share, True)
        rows.append([f"{name}, {share}", len(with_), *(f"{pick(values):.4f}" for values in (without, with_)
                                                       for pick in (median, max))])
    return table(["log", "seeds", "without, median [m]", "without, worst [m]", "with odometry, median [m]",
                  "with odometry, worst [m]"], rows)


def measure_loops():
    rows = {}
    for line in call_tests("accuracy_tests", "[loops]").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 8 and cells[1] in ("yes", "no"):
            rows.setdefault(cells[0], {})[cells[1]] = cells
    return table(["drive", "seeds", "with loops, median [m]", "worst [m]", "without, median [m]", "worst [m]",
                  "loops closed, median", "wrong loops", "cost of a scan", "without loops"],
                 [[name, pair["yes"][2], *pair["yes"][3:5], *pair["no"][3:5], *pair["yes"][5:8], pair["no"][7]]
                  for name, pair in rows.items()])


def measure_campuses():
    results = map_all("campuses", {seed: lambda seed=seed: map_log(
        f"sim:campus:3000:{seed}", [*SICK, "--seed", seed], align_truth=True) for seed in FRESH_SEEDS})
    found = [run.error_m for run in results.values()]
    return table(["drive", "campuses", "error, least [m]", "median [m]", "worst [m]", "loops closed, median"],
                 [["campus, 3 km, unseen", len(found), *(f"{pick(found):.3f}" for pick in (min, median, max)),
                   f"{median([run.summary['loops']['closed'] for run in results.values()]):g}"]])


def measure_alike():
    said = call_tests("accuracy_tests", "in buildings that are alike*", {"CRSM_ACCURACY_SEEDS": "50"})
    drives = {}
    for world, loops, off_m in re.findall(r"^sim:(\w+) .*?loops +(\d+),.*? off by ([\d.]+) m", said, re.MULTILINE):
        drives.setdefault(world, []).append((int(loops), float(off_m)))
    rows = [[f"`sim:{world}`", len(found), sum(loops > 0 for loops, _ in found), sum(off_m >= 1.0 for _, off_m in found),
             f"{max(off_m for _, off_m in found):.2f}"] for world, found in drives.items()]
    total = [drive for found in drives.values() for drive in found]
    rows.append(["all", len(total), sum(loops > 0 for loops, _ in total), sum(off_m >= 1.0 for _, off_m in total),
                 f"{max(off_m for _, off_m in total):.2f}"])
    return table(["world", "drives", "drives that close a loop", "drives that close a wrong one", "worst loop [m]"],
                 rows)


def measure_simulated():
    said = call_tests("accuracy_tests", "simulated drives*")
    rows = []
    for line in said.splitlines():
        found = re.fullmatch(r"(.{11}) *(\d+)((?: +[\d.]+ \( *[\d.]+\)){5})", line)
        if found:
            rows.append([found[1].strip(), found[2], *re.findall(r"([\d.]+) \(", found[3])])
    return table(["drive", "seeds", "worst error [m]", "median of the worst errors [m]", "mean error [m]",
                  "lost scans, share", "mean fitness, least"], rows)


def measure_paper_worlds():
    with tempfile.TemporaryDirectory(prefix="crsm_results_") as folder:
        call(BIN / "experiments", "--out", folder)
        text = (pathlib.Path(folder) / "results.md").read_text()
    return text.partition("\n\n")[2].replace("## ", "### ").replace("#### ", "### ")  # parts of a section


SECTIONS = [
    Section("Logs", 5, "The mean translational error of the relations of Kuemmerle et al. (2009), on logs of the Radish "
            "repository, without odometry, with one preset for all. The seeds are 201 to 220; no setting was chosen on "
            "them. The time is that of one scan in one process, which searches loops on a second thread: the median of "
            "five runs. Cartographer's errors are those that Hess et al. (2016) print.",
            ["build/bin/slam_offline LOG.clf.gz --preset sick --no-odometry --seed N --out DIR", EVALUATE], measure_logs, REAL_RELATIONS,
            is_timed=True),
    Section("Short reach", 2, "The same errors where the laser reaches 8 m, as a small laser does, for the seeds 1 to 8.",
            ["build/bin/slam_offline LOG.clf.gz --preset sick --no-odometry --range-max-m 8.42 --seed N --out DIR",
             "build/bin/slam_offline LOG.clf.gz --preset sick --no-odometry --range-max-m 8.42 --update-distance-m 0.1 "
             "--update-angle-rad 0.1 --seed N --out DIR", EVALUATE], measure_short_reach,
            tuple(log for log in REAL_RELATIONS if "intel" in log or "aces" in log)),
    Section("Few scans", 3, "The same errors with the odometry that the logs have and without it. Every scan: five a "
            "second, the seeds 1 to 5. Every fifth scan: one a second, the seeds 1 to 8.",
            ["build/bin/slam_offline LOG.clf.gz --preset sick --seed N --out DIR             # and with --no-odometry", EVALUATE,
             "zcat LOG.clf.gz | awk '$1 != \"FLASER\" || n++ % 5 == 0' > FIFTH.clf"], measure_few_scans, REAL_RELATIONS),
    Section("Loops", 6, "The root mean square of the distance from the true path, with the whole path aligned with it. Each "
            "seed of a campus is another campus. A loop is wrong if it is off by 1 m. The cost of a scan is the time to "
            "match and draw it in the last kilometre of a campus (the last fifth of another drive), as a multiple of that "
            "in the first. Settings were chosen on some of these drives.",
            ["scripts/experiments loops"], measure_loops, is_timed=True),
    Section("Campuses", 3, "The same error on twenty campuses on which no setting was chosen, 201 to 220.",
            ["build/bin/slam_offline sim:campus:3000:N --preset sick --seed N --out DIR",
             "build/bin/slam_eval trajectory DIR/trajectory.tum DIR/truth.tum --align"], measure_campuses),
    Section("Alike", 2, "Drives through buildings that are alike to themselves: half of them with angles that are 1 % too "
            "large, so that what is alike comes to lie nearer. A loop is wrong if it is off by 1 m.",
            ["CRSM_ACCURACY_SEEDS=50 build/bin/accuracy_tests \"in buildings*\""], measure_alike),
    Section("Simulated drives", 1, "The distance from the true pose, over some seeds of each simulated world with the preset "
            "of its laser. `scripts/test` fails where a figure passes its bound.",
            ["build/bin/accuracy_tests \"simulated drives*\""], measure_simulated),
    Section("Paper worlds", 25, "The worlds, metrics and methods of the paper. OMSE and CMSE are in cells of 0.02 m, squared.",
            ["scripts/experiments"], measure_paper_worlds, is_timed=True),
]
