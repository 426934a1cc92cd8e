"""What it costs: processor time, how long a scan waits, what the view takes, and what is installed."""

import json
import re

from measure import DATA, Failed, Section, call_script, call_tests, map_radish, median, progress, radish
from page import table

RUNS = 5


def measure_cost_of_loops():
    rows = []
    for name in ("intel", "killian"):
        pairs = [[map_radish(name, ["--seed", seed, *flags]) for flags in ([], ["--no-loops"])]
                 for seed in range(1, RUNS + 1)]
        progress(f"cost-of-loops: {name}")
        ratios = [loops.processor_s / none.processor_s for loops, none in pairs]
        scan_ms = [1000 * median([run.processor_s / run.summary["scans"] for run in runs]) for runs in zip(*pairs)]
        rows.append([name, *(f"{one_ms:.3f}" for one_ms in scan_ms),
                     *(f"{pick(ratios):.2f}" for pick in (median, min, max))])
    return table(["log", "a scan with loops [ms]", "with `--no-loops` [ms]", "ratio, median", "least", "most"], rows)


def measure_stack():
    rows = []
    for name, flags in (("intel", []), ("killian", []), ("intel", ["--no-loops"])):
        said = call_script("bench", "stack", DATA / radish(name), "--preset", "sick", *flags)
        progress(f"stack: {name} {' '.join(flags)}")
        together, offline = (re.search(rf"^{title} .*?([\d.]+)$", said, re.MULTILINE)[1]
                             for title in (r"the \w+ together", "slam_offline"))
        *ratios, pace = re.search(r"take ([\d.]+) times .*?\(([\d.]+) to ([\d.]+)\), and map (\d+) scans/s", said,
                                  re.DOTALL).groups()
        rows.append([f"{name}{', `--no-loops`' if flags else ''}", together, offline, *ratios, f"{int(pace):,}"])
    return table(["log", "the processes [ms]", "`slam_offline` [ms]", "ratio, median", "least", "most",
                  "scans a second, the processes"], rows)


def measure_steps():
    said = call_script("bench", "--benchmark_filter=match_10000|ScanByTilesExplored", "--benchmark_format=json",
                       "--benchmark_repetitions=5", "--benchmark_report_aggregates_only=true")
    per_ms = {"ns": 1e6, "us": 1e3, "ms": 1.0}
    times_ms = {one["run_name"]: one["cpu_time"] / per_ms[one["time_unit"]]
                for one in json.loads(said[said.index("{"):])["benchmarks"] if one["aggregate_name"] == "median"}
    rows = []
    for name, time_ms in times_ms.items():
        tiles = re.match(r"ScanByTilesExplored/(\d+)", name)
        rows.append([f"a scan on a map of {int(tiles[1]):,} tiles" if tiles else
                     "a match of 10,000 evaluations with 40 rays", f"{time_ms:.2f}"])
    return table(["step", "processor time, median of five [ms]"], rows)


def pages_in(said):
    """The rows of scripts/bench view: pages, processor [%], memory [MB], to a page and whole grids [MB/s]."""
    return [[*row[:3], f"{int(row[3]) / 1000:.2f}", f"{int(row[4]) / 1000:.1f}"]
            for row in re.findall(r"^ +(\d+) +([\d.]+) +(\d+) +(\d+) +(\d+)$", said, re.MULTILINE)]


def measure_view():
    fr079 = call_script("bench", "view", DATA / radish("fr079"), "--preset", "sick", "--rate", 40)
    progress("view: fr079 is done")
    killian = call_script("bench", "view", DATA / radish("killian"), "--preset", "sick", "--runs", 0, "--pages", 1,
                          "--chromium")
    pace = re.search(r"a page ([\d.]+) times the time without \(([\d.]+) to ([\d.]+), (\d+) runs\)", fr079)
    frames = re.search(r"(\d+) frames/s in Chromium, 99 in 100 of them within (\d+) ms; one takes (\d+) ms", killian)
    if not pace or not frames:
        raise Failed(f"scripts/bench view says something else:\n{fr079}{killian}")
    costs = ["processor of the viewer [%]", "its memory [MB]", "to each page [MB/s]", "whole grids instead [MB/s]"]
    return "\n\n".join([
        "fr079, at 40 times its pace:", table(["pages", *costs], pages_in(fr079)),
        "fr079 in lockstep, as fast as the machine can: how many times as long it takes with a viewer and a page:",
        table(["log", "ratio, median", "least", "most", "pairs of runs"], [["fr079", *pace.groups()]]),
        "killian, at ten times its pace, with a page that a Chromium without a graphics card draws besides:",
        table(["log", *costs, "frames a second", "99 of 100 frames within [ms]", "processor of a frame [ms]"],
              [["killian", *pages_in(killian)[0][1:], *frames.groups()]])])


def measure_viewer_latency():
    said = call_tests("process_tests", "[.viewer_latency]")
    rows = [[f"{share} %", within] for share, within in
            re.findall(r"^ *(\d+) % of \d+ matches: within ([\d.]+) ms", said, re.MULTILINE)]
    return table(["matches", "on the page within [ms]"], rows)


def measure_live_latency():
    said = call_script("fault", "latency")
    rows = [[log.replace("_", ":"), what, scans, *waits] for log, what, scans, *waits in re.findall(
        r"^ *(\S+), (all|while the map is drawn anew): (\d+) scans, from LASER to SCAN_MATCH ([\d.]+) ms in the median, "
        r"([\d.]+) ms in 99 of 100, ([\d.]+) ms at most", said, re.MULTILINE)]
    if not rows:
        raise Failed(f"scripts/fault latency says something else:\n{said}")
    return table(["log", "scans", "number", "median [ms]", "99 of 100 [ms]", "most [ms]"], rows)


def measure_packages():
    said = call_script("packages", "--chroot", "bookworm")
    before = re.search(r"the Debian that builds: (\d+) MB, (\d+) MB before", said)
    installed = re.search(r"installed crsm-slam in \d+ s: (\d+) packages, (\d+) MB", said)
    if not before or not installed:
        raise Failed(f"scripts/packages --chroot says something else:\n{said}")
    return table(["what", "packages", "size [MB]"], [
        ["to build, and to make packages", "", int(before[1]) - int(before[2])], ["to run", *installed.groups()]])


SECTIONS = [
    Section("Cost of loops", 2, "The processor time of a scan with loops and without them, in one process; the seeds 1 to 5.",
            ["build/bin/slam_offline LOG.clf.gz --preset sick --no-odometry --seed N --out DIR",
             "build/bin/slam_offline LOG.clf.gz --preset sick --no-odometry --seed N --no-loops --out DIR"], measure_cost_of_loops,
            (radish("intel"), radish("killian")), is_timed=True),
    Section("Stack", 4, "The processor time of a scan in the processes, in lockstep, and in one process that does it all; "
            "medians of five runs.",
            ["scripts/bench stack LOG.clf.gz --preset sick", "scripts/bench stack LOG.clf.gz --preset sick --no-loops"],
            measure_stack, (radish("intel"), radish("killian")), is_timed=True),
    Section("Steps", 3, "The processor time of single steps on a made-up map.",
            ["scripts/bench '--benchmark_filter=match_10000|ScanByTilesExplored' --benchmark_repetitions=5"], measure_steps,
            is_timed=True),
    Section("Live latency", 4, "How long a scan waits for its match, from `LASER` to `SCAN_MATCH`, live at 10 Hz. While the "
            "map is drawn anew: in the three seconds after a loop has moved the poses. Killian's loop is closed 1.7 km from "
            "its start.", ["scripts/fault latency"], measure_live_latency, is_timed=True),
    Section("Viewer latency", 2, "How long after it was sent a match is on a page of `map_viewer`.",
            ["build/bin/process_tests \"[.viewer_latency]\""], measure_viewer_latency, is_timed=True, is_of_algorithm=False),
    Section("View", 22, "What `map_viewer` takes, and what it sends to each page that is open. Whole grids instead: what it "
            "would send if each change of the map sent all of it.",
            ["scripts/bench view fr079.clf.gz --preset sick --rate 40",
             "scripts/bench view killian.clf.gz --preset sick --runs 0 --pages 1 --chromium"], measure_view,
            (radish("fr079"), radish("killian")), is_timed=True),
    Section("Packages", 20, "What the Debian packages bring along on a bare Debian 12.",
            ["scripts/packages --chroot bookworm"], measure_packages, is_of_algorithm=False),
]
