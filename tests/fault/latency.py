"""A live laser of 10 Hz: how long a scan waits for its match, also while a loop is closed and the map drawn anew."""

import math
import struct
import time

from faults import PROJECT, Driver, Listener, Program, bus_url, check, percentile, port_of, read_log, run, run_stack
from faults import utime_of, write_log

RATE_HZ = 10
P99_S = 0.005
SETTLED_S = 1.0       # before, the processes make sure whom to believe
DRAWING_ANEW_S = 3.0  # after a loop has moved the poses, in which the new map goes to all replicas
MOVED_M = 1e-4        # how far the local frame goes, beyond rounding, where the map frame is put right


def planar_pose(data):
    """x, y, yaw of a bot_core.pose_t."""
    values = struct.unpack_from(">10d", data, 16)
    return values[0], values[1], 2.0 * math.atan2(values[9], values[6])


def local_origin(pose, pose_local):
    """Where the origin of the local frame lies in the map."""
    yaw = pose[2] - pose_local[2]
    cos, sin = math.cos(yaw), math.sin(yaw)
    return (pose[0] - cos * pose_local[0] + sin * pose_local[1], pose[1] - sin * pose_local[0] - cos * pose_local[1])


def closes_loop(pose_graph):
    """Not each finding does."""
    findings_at, finding_bytes, ties_bytes = 45, 42, 8
    (num_findings,) = struct.unpack_from(">i", pose_graph, findings_at - 4)
    (num_closed,) = struct.unpack_from(">i", pose_graph, findings_at + num_findings * finding_bytes + ties_bytes)
    return num_closed > 0


class MatchListener(Listener):
    """When each match came, by its utime; when loops were found, and when they moved the poses."""

    beginnings = [b"SCAN", b"POSE"]

    def __init__(self, port):
        self.matched_s = {}
        self.found_s = []
        self.moved_s = []
        self.poses = {}
        self.origin = None
        super().__init__(port)

    def hear(self, channel, data, at_s):
        if channel == b"SCAN_MATCH":
            self.matched_s.setdefault(utime_of(data), at_s)
        elif channel == b"POSE_GRAPH" and closes_loop(data):
            self.found_s.append(at_s)
        elif channel in (b"POSE", b"POSE_LOCAL"):
            poses = self.poses.setdefault(utime_of(data), {})
            poses[channel] = planar_pose(data)
            if len(poses) == 2:
                self.hear_origin(local_origin(poses[b"POSE"], poses[b"POSE_LOCAL"]), at_s)
                del self.poses[utime_of(data)]

    def hear_origin(self, origin, at_s):
        if self.origin and math.dist(origin, self.origin) > MOVED_M:
            self.moved_s.append(at_s)
        self.origin = origin


def drive(port, scans):
    """Publishes as a driver does. Returns when each scan went out, by its utime."""
    driver = Driver(port)
    sent_s = {}
    begin = time.monotonic()
    for number, scan in enumerate(scans):
        time.sleep(max(0.0, begin + number / RATE_HZ - time.monotonic()))
        sent_s[utime_of(scan)] = time.time()
        driver.publish(scan)
    return sent_s


def measure(case, name, scans, flags, first, last):
    """Scans before `first` are mapped at leisure, the others live."""
    out = case.folder(name)
    if first > 0:
        before = case.out / f"{name}_before.lcm"
        write_log(before, scans[:first])
        run_stack(before, out, flags)
    url = bus_url()
    listener = MatchListener(port_of(url))
    stack = Program([PROJECT / "scripts/run_stack", "live", "--out", out / "map" if first == 0 else out, "--lcm-url", url,
                     *(["--resume", out] if first > 0 else []), *flags], case.out / f"{name}.log")
    time.sleep(3)  # the journal is read, all listen
    check(stack.popen.poll() is None, f"run_stack ended: {stack.errors()[-800:]}")
    sent_s = drive(port_of(url), scans[first:last])
    time.sleep(1)
    check(stack.interrupt() == 0, f"run_stack failed: {stack.errors()[-800:]}")

    settled_s = min(sent_s.values()) + SETTLED_S
    sent_s = {utime: at_s for utime, at_s in sent_s.items() if at_s >= settled_s}
    waits_s = {utime: listener.matched_s[utime] - at_s for utime, at_s in sent_s.items() if utime in listener.matched_s}
    # The scan whose poses told that the map had moved was matched in the new map, so it went out before.
    moving_s = [wait_s for utime, wait_s in waits_s.items()
                if any(-1.0 / RATE_HZ < sent_s[utime] - moved_s < DRAWING_ANEW_S for moved_s in listener.moved_s)]
    check(len(waits_s) >= 0.999 * len(sent_s), f"{name}: {len(sent_s) - len(waits_s)} of {len(sent_s)} scans have no match")
    check(moving_s, f"{name}: no loop has moved the poses; {len(listener.found_s)} changes of the graph")
    case.say(f"{name}: {len(listener.found_s)} changes of the graph, the poses moved {len(listener.moved_s)} times")
    for title, waits in (("all", list(waits_s.values())), ("while the map is drawn anew", moving_s)):
        case.say(f"{name}, {title}: {len(waits)} scans, from LASER to SCAN_MATCH {1000 * percentile(waits, 0.5):.2f} ms in "
                 f"the median, {1000 * percentile(waits, 0.99):.2f} ms in 99 of 100, {1000 * max(waits):.2f} ms at most")
        check(percentile(waits, 0.99) < P99_S, f"{name}: {1000 * percentile(waits, 0.99):.1f} ms in 99 of 100 scans")


def test(case):
    for name, log, flags in case.logs_that_come_back():
        scans = read_log(log)
        measure(case, name.replace(":", "_"), scans, flags, 0, len(scans))
    if case.quick:
        return
    killian = PROJECT.parent / "shared/data/radish/killian.clf.gz"
    if killian.exists():  # whose last loops are closed after scan 15,700, 1.7 km from its start
        measure(case, "killian", read_log(case.convert("killian", killian)), ["--preset", "sick"], 15600, 16200)
    else:
        case.say(f"without the real log: there is no {killian}")


run(test)
