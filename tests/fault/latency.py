"""A live laser of 10 Hz: how long a scan waits for its match, also while a loop is closed and the map drawn anew."""

import socket
import struct
import time

from faults import GROUP, PROJECT, Listener, Program, bus_url, check, percentile, port_of, read_log, run, run_stack
from faults import write_log

RATE_HZ = 10
P99_S = 0.005
SETTLED_S = 1.0        # before, the processes make sure whom to believe
AFTER_CLOSURE_S = 3.0  # in which the map is drawn anew and goes to all replicas


class MatchListener(Listener):
    """When each match came, by its utime; when loops were closed."""

    beginnings = [b"SCAN", b"POSE"]

    def __init__(self, port):
        self.matched_s = {}
        self.closed_s = []
        super().__init__(port)

    def hear(self, channel, data, at_s):
        if channel == b"SCAN_MATCH":
            self.matched_s.setdefault(struct.unpack_from(">q", data, 8)[0], at_s)
        elif channel == b"POSE_GRAPH" and data[32]:  # something has changed
            self.closed_s.append(at_s)


def drive(port, scans):
    """Publishes as a driver does. Returns when each scan went out, by its utime."""
    bus = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    bus.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
    sent_s = {}
    begin = time.monotonic()
    for number, scan in enumerate(scans):
        time.sleep(max(0.0, begin + number / RATE_HZ - time.monotonic()))
        sent_s[struct.unpack_from(">q", scan, 8)[0]] = time.time()
        bus.sendto(struct.pack(">II", 0x4C433032, number) + b"LASER\0" + scan, (GROUP, port))
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
    closing_s = [wait_s for utime, wait_s in waits_s.items()
                 if any(0.0 <= sent_s[utime] - closed_s < AFTER_CLOSURE_S for closed_s in listener.closed_s)]
    check(len(waits_s) >= 0.999 * len(sent_s), f"{name}: {len(sent_s) - len(waits_s)} of {len(sent_s)} scans have no match")
    check(closing_s, f"{name}: no loop was closed")
    for title, waits in (("all", list(waits_s.values())), (f"within {AFTER_CLOSURE_S:g} s of a closed loop", closing_s)):
        case.say(f"{name}, {title}: {len(waits)} scans, from LASER to SCAN_MATCH {1000 * percentile(waits, 0.5):.2f} ms in "
                 f"the median, {1000 * percentile(waits, 0.99):.2f} ms in 99 of 100, {1000 * max(waits):.2f} ms at most")
        check(percentile(waits, 0.99) < P99_S, f"{name}: {1000 * percentile(waits, 0.99):.1f} ms in 99 of 100 scans")


def test(case):
    for name, log, flags in case.logs_that_come_back():
        scans = read_log(log)
        measure(case, name.replace(":", "_"), scans, flags, 0, len(scans))
    killian = PROJECT.parent / "shared/data/radish/killian.clf.gz"
    if killian.exists():  # whose last loops are closed after scan 15,700, 1.7 km from its start
        measure(case, "killian", read_log(case.convert("killian", killian)), ["--preset", "sick"], 15600, 16200)
    else:
        case.say(f"without the real log: there is no {killian}")


run(test)
