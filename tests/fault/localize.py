"""A robot that is switched on somewhere on a finished map, or carried away, finds where it is."""

import math
import random
import struct

from faults import PROJECT, check, percentile, read_log, run, run_offline, summary, write_log

MOST_OFF_M = 0.3
MOST_OFF_RAD = math.radians(10)
LOST = 2


def read_poses(path):
    """x [m], y [m] and yaw [rad] of each line of a .tum file."""
    lines = [[float(word) for word in line.split()] for line in path.read_text().splitlines()]
    return [(line[1], line[2], 2.0 * math.atan2(line[6], line[7])) for line in lines]


def read_matches(out):
    """Pose and state of each SCAN_MATCH in the journal of a run."""
    return [(struct.unpack_from(">3d", message, 16), message[132])
            for message in read_log(out / "journal/journal.lcm", "SCAN_MATCH")]


def is_same_place(pose, truth):
    turn = math.remainder(pose[2] - truth[2], 2.0 * math.pi)
    return math.dist(pose[:2], truth[:2]) <= MOST_OFF_M and abs(turn) <= MOST_OFF_RAD


def localize(case, scans, finished, flags):
    """Localises scans on a finished map. Returns poses and states, and the longest time of a scan [ms]."""
    log = case.out / "start.lcm"
    write_log(log, scans)
    out = case.folder("found")
    run_offline(log, out, [*flags, "--localize", finished])
    check((out / "map.png").read_bytes() == (finished / "map.png").read_bytes(), "the finished map changed")
    return read_matches(out), summary(out)["timings"]["slam_offline"]["max_ms"]


def switched_on(case, name, scans, truth, starts, finished, flags):
    """Each start: the first scan that is not lost is the answer, and has to be the right one."""
    num_right, waits, times_ms, wrong = 0, [], [], []
    for start in starts:
        matches, longest_ms = localize(case, scans[start:start + 200], finished, flags)
        found = next((number for number, (_, state) in enumerate(matches) if state != LOST), None)
        times_ms.append(longest_ms)
        if found is None:
            continue
        waits.append(found + 1)
        if is_same_place(matches[found][0], truth[start + found]):
            num_right += 1
        else:
            wrong.append(start)
    case.say(f"{name}: {num_right} of {len(starts)} right, {len(wrong)} wrong, {len(starts) - len(waits)} not found within "
             f"200 scans; found after {percentile(waits, 0.5)} scans (median), {max(waits)} at most; the search takes "
             f"{percentile(times_ms, 0.5):.0f} ms (median), {max(times_ms):.0f} ms at most")
    check(num_right >= 28 / 30 * len(starts), f"{name}: only {num_right} of {len(starts)} are right; wrong: {wrong}")


def carried_away(case, name, scans, truth, pairs, finished, flags):
    """A robot that knows where it is and the next moment is elsewhere: at the end of 200 scans it knows that."""
    num_right, lost = 0, []
    for before, after in pairs:
        matches, _ = localize(case, scans[before:before + 50] + scans[after:after + 200], finished, flags)
        num_right += is_same_place(matches[-1][0], truth[after + len(matches) - 51])
        lost.append(sum(state == LOST for _, state in matches[50:]))
    case.say(f"{name}: carried away {len(pairs)} times, found again {num_right} times, after {percentile(lost, 0.5)} lost "
             f"scans (median), {max(lost)} at most")
    check(num_right >= 0.8 * len(pairs), f"{name}: found again only {num_right} times")


def test(case):
    randomness = random.Random(1)
    num_starts, num_carried = (10, 3) if case.quick else (30, 10)

    # A simulated building on another day: other noise.
    finished = case.folder("finished")
    run_offline("sim:demo", finished, [])
    other_day = case.folder("other_day")
    run_offline("sim:demo", other_day, ["--seed", "2"])
    truth = read_poses(other_day / "truth.tum")
    scans = read_log(case.convert("other_day", "sim:demo", 2))
    places = range(len(scans) - 200)
    switched_on(case, "sim:demo", scans, truth, randomness.sample(places, num_starts), finished, [])
    pairs = [randomness.sample(places, 2) for _ in range(num_carried)]
    carried_away(case, "sim:demo", scans, truth, pairs, finished, [])

    # A real one: the map is made of the first 60 % of the log, and the robot is switched on in the rest, where it has
    # been before. The poses of the whole log, mapped in one run, tell where that is.
    real = PROJECT.parent / "shared/data/radish/intel.clf.gz"
    if not real.exists():
        return case.say(f"without the real log: there is no {real}")
    flags = ["--preset", "sick"]
    scans = read_log(case.convert("intel", real))
    whole = case.folder("whole")
    run_offline(real, whole, flags)
    truth = read_poses(whole / "trajectory.tum")
    end = len(scans) * 6 // 10
    write_log(case.out / "first_part.lcm", scans[:end])
    finished = case.folder("finished")
    run_offline(case.out / "first_part.lcm", finished, flags)

    def was_there(pose):
        return any(math.dist(pose[:2], other[:2]) < 0.5 and abs(math.remainder(pose[2] - other[2], 2 * math.pi)) < 0.5
                   for other in truth[:end:10])

    places = [number for number in range(end, len(scans) - 200) if was_there(truth[number])]
    switched_on(case, "intel", scans, truth, randomness.sample(places, num_starts), finished, flags)


run(test)
