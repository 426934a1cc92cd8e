"""Journals that a disk or a power cut has damaged: what is said of each, and the map that is made of it, are right."""

import collections
import filecmp
import random
import re
import struct
import subprocess

from faults import BIN, check, read_log, run, run_offline, summary, write_log

NUM_SCANS = 60
KINDS = ["a flipped bit", "cut short", "zeros", "a repeated block instead of another",
         "a repeated block between others", "zeros at the end", "garbage at the end"]


def damage(whole, kind, randomness):
    at = randomness.randrange(len(whole))
    size = min(randomness.randint(1, 4096), len(whole) - at)
    other = randomness.randrange(len(whole) - size + 1)
    block = whole[other:other + size]
    if kind == "a flipped bit":
        return whole[:at] + bytes([whole[at] ^ 1 << randomness.randrange(8)]) + whole[at + 1:]
    if kind == "cut short":
        return whole[:at]
    if kind == "zeros":
        return whole[:at] + bytes(size) + whole[at + size:]
    if kind == "a repeated block instead of another":
        return whole[:at] + block + whole[at + size:]
    if kind == "a repeated block between others":
        return whole[:at] + block + whole[at:]
    tail = bytes(size) if kind == "zeros at the end" else randomness.randbytes(size)
    return whole[:at] + tail if randomness.random() < 0.5 else whole + tail


def ends_of_scans(whole):
    """Where in a journal each scan is whole: behind its check."""
    at, ends, matched = 0, [], False
    while at < len(whole):
        channel_bytes, data_bytes = struct.unpack_from(">II", whole, at + 20)
        channel = whole[at + 28:at + 28 + channel_bytes]
        at += 28 + channel_bytes + data_bytes
        if channel == b"JOURNAL_CHECK" and matched:
            ends.append(at)
        matched = channel == b"SCAN_MATCH"
    return ends


class Sessions:
    """Goes on with journals, with a log of one scan that is in all maps but the empty one."""

    def __init__(self, case):
        self.case = case
        scans = read_log(case.convert("demo", "sim:demo"))[:4 * NUM_SCANS:4]
        self.log, self.one = case.out / "all.lcm", case.out / "one.lcm"
        write_log(self.log, scans)
        write_log(self.one, scans[:1])
        self.first = case.folder("first")
        run_offline(self.log, self.first, [])
        self.whole = (self.first / "journal/journal.lcm").read_bytes()
        self.ends = ends_of_scans(self.whole)
        check(len(self.ends) == NUM_SCANS, f"{len(self.ends)} scans are in the journal")
        self.maps = {}

    def go_on(self, journal, name, flags=()):
        """Exit code, what was said, and the folder."""
        out = self.case.folder(name)
        (out / "journal").mkdir()
        (out / "journal/journal.lcm").write_bytes(journal)
        done = subprocess.run([BIN / "slam_offline", self.one, "--out", out, "--resume", out, *flags],
                              capture_output=True, text=True, timeout=60)
        return done.returncode, done.stderr, out

    def map_of(self, num_scans):
        """The results of the first scans, from a journal that was never longer."""
        if num_scans not in self.maps:
            code, said, out = self.go_on(self.whole[:self.ends[num_scans - 1] if num_scans else 0], f"map_{num_scans}")
            check(code == 0, said)
            check(summary(out)["scans"] == max(1, num_scans), f"not a map of {num_scans} scans")
            self.maps[num_scans] = out
        return self.maps[num_scans]

    def check_map(self, out, num_scans, what):
        for name in ("map.png", "trajectory.tum"):
            check(filecmp.cmp(out / name, self.map_of(num_scans) / name, shallow=False),
                  f"{what}: {name} is not that of the first {num_scans} scans")


def outcome(sessions, journal, what):
    code, said, out = sessions.go_on(journal, "damaged")
    check(code in (0, 1), f"{what}: exit code {code}: {said}")
    if code == 1:
        check(said.count("\n") == 1 and "journal.lcm" in said, f"{what}: said {said}")
        check((out / "journal/journal.lcm").read_bytes() == journal, f"{what}: refused, but changed")
        if "--until-damage" in said:
            num_scans = int(re.search(r"first (\d+) scans", said)[1])
            code, said, out = sessions.go_on(journal, "damaged", ["--until-damage"])
            check(code == 0, f"{what}: {said}")
            sessions.check_map(out, num_scans, what)
            check(any(path.read_bytes() == journal for path in (out / "journal").glob("*.damaged")),
                  f"{what}: the damaged journal is not kept")
        return "refused"
    left = re.search(r"(\d+) scans (remain|are complete)", said)
    num_scans = int(left[1]) if left else NUM_SCANS
    sessions.check_map(out, num_scans, what)
    return "same" if num_scans == NUM_SCANS else "cut"


def test(case):
    randomness = random.Random(14)
    sessions = Sessions(case)
    counts = collections.Counter()
    by_kind = collections.defaultdict(collections.Counter)
    num_damages = 140 if case.quick else 1000
    for number in range(num_damages):
        kind = KINDS[number % len(KINDS)]
        journal = damage(sessions.whole, kind, randomness)
        found = outcome(sessions, journal, f"damage {number}, {kind}")
        counts[found] += 1
        by_kind[kind][found] += 1
    for kind, found in by_kind.items():
        case.say(f"{kind}: " + ", ".join(f"{num} {name}" for name, num in sorted(found.items())))
    case.say(f"{num_damages} damages: {counts['cut']} cut off, {counts['refused']} refused, {counts['same']} the same "
             "map; none silently another, none crashed")


run(test)
