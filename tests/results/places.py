"""Where robots are found, what moves, what an mbot's own poses say, and when a map is called good."""

import gzip
import json
import math
import pathlib
import re
import struct
import tempfile

from measure import BIN, DATA, LCM_EVENT, Failed, Section, call, call_script, call_tests, map_all, median, radish
from page import table

MBOT = "lcm/mbot_convex.lcmlog.gz"
LCM_SYNC = 0xEDA1DA01


def measure_localise():
    said = call_script("fault", "localize")
    rows = []
    for name, right, places, wrong, missed, scans, most in re.findall(
            r"^ *(\S+): (\d+) of (\d+) right, (\d+) wrong, (\d+) not found .*? found after (\S+) scans \(median\), "
            r"(\d+) at most", said, re.MULTILINE):
        rows.append([name, places, right, wrong, missed, f"{float(scans):g}", most])
    if len(rows) != 2:
        raise Failed(f"scripts/fault localize says something else:\n{said}")
    carried = [[name, times, again, f"{float(lost):g}", most] for name, times, again, lost, most in re.findall(
        r"^ *(\S+): carried away (\d+) times, found again (\d+) times, after (\S+) lost scans \(median\), (\d+) at most",
        said, re.MULTILINE)]
    return "\n\n".join([
        "Switched on somewhere on the map, within 200 scans:",
        table(["building", "places", "found", "found elsewhere", "not found", "scans, median", "scans, most"], rows),
        "Carried to another place of the map:",
        table(["building", "times", "found again", "lost scans, median", "lost scans, most"], carried)])


def find_pairs(filter_, scans, starts):
    """Robot, building, scans, found and found wrongly. The bounds of the test are for fewer places: it may fail."""
    said = call_tests("accuracy_tests", filter_,
                      {"CRSM_LOCALIZE_SCANS": str(scans), "CRSM_LOCALIZE_STARTS": str(starts)}, may_fail=True)
    return re.findall(r"^robot in (\S+) on the map of (\S+) +scans +(\d+) +found +(\d+) +wrongly +(\d+)", said,
                      re.MULTILINE)


def measure_other_buildings():
    pairs = {}
    for filter_, scans, starts in (("*of no other: simulated*", 20, 2), ("*of no other: real*", 30, 3)):
        pairs[filter_] = find_pairs(filter_, scans, starts)
    rows = [[f"{robot} on the map of {building}", scans, found, wrong] for found_pairs in pairs.values()
            for robot, building, scans, found, wrong in found_pairs]
    for name, found_pairs in zip(("simulated, other buildings", "real, other buildings"), pairs.values()):
        foreign = [list(map(int, pair[2:])) for pair in found_pairs if pair[0] != pair[1]]
        rows.append([name, *(sum(pair[column] for pair in foreign) for column in range(3))])
    rows += [[f"{robot} on the map of {building}, ten places", scans, found, wrong]
             for robot, building, scans, found, wrong in find_pairs("*of no other: real*", 30, 10)
             if {robot, building} == {"fr079", "aces"}]
    return table(["robot", "scans", "found", "found wrongly"], rows)


def measure_moving():
    said = call_tests("accuracy_tests", "*door that closes*,people*")
    rows = [[what, scans, seconds] for what, scans, seconds in
            re.findall(r"^(.+): the map says so after (\d+) scans \(([\d.]+) s\)", said, re.MULTILINE)]
    return table(["what", "scans until the map says so", "seconds"], rows)


def read_slam_poses(log):
    """utime, x, y and yaw of the poses that the robot's own stack had, of an LCM log."""
    data = gzip.open(log).read()
    poses, at = [], 0
    while at + LCM_EVENT.size <= len(data):
        sync, _, _, channel_size, size = LCM_EVENT.unpack_from(data, at)
        if sync != LCM_SYNC:
            raise Failed(f"{log}: no event at byte {at}")
        begin = at + LCM_EVENT.size
        at = begin + channel_size + size
        if data[begin:begin + channel_size] == b"SLAM_POSE":
            poses.append(struct.unpack_from(">qfff", data, begin + channel_size + 8))  # behind the fingerprint
    return poses


def measure_mbot():
    with tempfile.TemporaryDirectory(prefix="crsm_results_") as name:
        folder = pathlib.Path(name)
        truth = folder / "poses.tum"
        truth.write_text("".join(
            f"{utime // 10**6}.{utime % 10**6:06d} {x} {y} 0 0 0 {math.sin(yaw / 2)} {math.cos(yaw / 2)}\n"
            for utime, x, y, yaw in read_slam_poses(DATA / MBOT)))

        def compare(seed):
            out = folder / str(seed)
            call(BIN / "slam_offline", DATA / MBOT, "--preset", "rplidar-a1", "--seed", seed, "--out", out)
            return json.loads(call(BIN / "slam_eval", "trajectory", out, truth, "--align", "--json"))

        found = list(map_all("mbot", {seed: lambda seed=seed: compare(seed) for seed in range(1, 6)}).values())
    away_mm = [1000 * one["rmse_m"] for one in found]
    return table(["log", "poses", "seeds", "distance, median [mm]", "worst [mm]"],
                 [["mbot", found[0]["poses"], len(found), f"{median(away_mm):.1f}", f"{max(away_mm):.1f}"]])


def measure_verdict():
    said = call_tests("accuracy_tests", "maps of*")
    rows = [[run, verdict, f"{100 * int(lost) / int(scans):.1f}", fitness, agreement]
            for run, verdict, scans, lost, fitness, agreement in re.findall(
                r"^(\S.*?) +(good|doubtful|bad) +scans +(\d+) +lost +(\d+) .*?fitness ([\d.]+) +agreement ([\d.]+)", said,
                re.MULTILINE)]
    if not rows:
        raise Failed(f"the tests of the verdict print something else:\n{said}")
    return table(["run", "verdict", "lost [%]", "mean fitness", "agreement"], rows)


THREE = tuple(radish(name) for name in ("fr079", "intel", "aces"))
SECTIONS = [
    Section("Localise", 2, "A robot on a finished map, which does not know where it is. `sim:demo` has other noise than when "
            "it was mapped; of intel the first 60 % made the map, and the robot comes to known places later. Found means "
            "within 0.3 m and 10 degrees.", ["scripts/fault localize"], measure_localise, (radish("intel"),)),
    Section("Other buildings", 3, "Scans of one building on the finished map of another one: found there, they are wrong. "
            "Robots are switched on at two places for 20 scans (simulated), or at three for 30 (real).",
            ["build/bin/accuracy_tests \"*of no other: simulated*\"",
             "CRSM_LOCALIZE_SCANS=30 CRSM_LOCALIZE_STARTS=3 build/bin/accuracy_tests \"*of no other: real*\"",
             "CRSM_LOCALIZE_SCANS=30 CRSM_LOCALIZE_STARTS=10 build/bin/accuracy_tests \"*of no other: real*\""],
            measure_other_buildings, THREE),
    Section("Moving things", 1, "How long until the map says that something has changed. The robot passes at 0.5 m/s with 10 "
            "scans a second, and the figure is the most of five seeds.",
            ["build/bin/accuracy_tests \"*door*,*people*\""], measure_moving),
    Section("Mbot", 1, "The distance, root mean square, from the poses that a student's robot recorded of itself in 2015, with "
            "the whole path aligned with them.",
            ["build/bin/slam_offline LOG.lcmlog.gz --preset rplidar-a1 --seed N --out DIR",
             "build/bin/slam_eval trajectory DIR POSES.tum --align      # POSES.tum: the log's SLAM_POSE"], measure_mbot,
            (MBOT,)),
    Section("Verdict", 2, "What the verdict says of maps that are right, and of maps of spoilt scans. Agreement is the share of "
            "rays that pass where the map is free and end at its walls.",
            ["build/bin/accuracy_tests \"maps of*\""], measure_verdict,
            (*THREE, "urg04lx/exp1.clf.gz", "urg04lx/exp3.clf.gz")),
]
