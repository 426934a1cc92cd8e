"""What a robot costs that drives through one building for a week."""

import json
import os
import pathlib
import re
import struct
import subprocess
import tempfile
import time

from measure import BIN, LCM_EVENT, PROJECT, SICK, Failed, Section, call, progress, run_measured
from page import table

DAYS = 7
DAY_US = 24 * 3600 * 1_000_000
ROUNDS_A_DAY = 190  # through all rooms of sim:rooms, and back to where it began
PICTURE = PROJECT / "tests/results/week.svg"


def write_world(path):
    """sim:rooms with ten scans a second, driven round and round."""
    lines = (PROJECT / "common/worlds/rooms.world").read_text().splitlines()
    way = [line for line in lines if line.startswith("waypoint")]
    walls = [re.sub(r"^(laser 180 180 30) 5 ", r"\1 10 ", line) for line in lines if not line.startswith("waypoint")]
    path.write_text("\n".join(walls + ROUNDS_A_DAY * way) + "\n")


def write_day(world, day, log):
    """The scans of a day, with noise of its own, each at its own time of the week."""
    simulated = log.with_suffix(".simulated")
    call(BIN / "laser_publisher", world, "--rate", "max", "--seed", day + 1, "--lcm-url", f"file://{simulated}?mode=w")
    with open(simulated, "rb") as events, open(log, "wb") as shifted:
        while head := events.read(LCM_EVENT.size):
            sync, number, utime, channel_bytes, message_bytes = LCM_EVENT.unpack(head)
            channel, message = events.read(channel_bytes), events.read(message_bytes)
            if channel != b"LASER":
                continue
            (of_scan,) = struct.unpack_from(">q", message, 8)  # behind the fingerprint
            shifted.write(LCM_EVENT.pack(sync, number, utime + day * DAY_US, channel_bytes, message_bytes))
            shifted.write(channel + message[:8] + struct.pack(">q", of_scan + day * DAY_US) + message[16:])
    simulated.unlink()


def map_day(log, out, day):
    """Peak memory [MB] and processor time [s] of the process that maps a day. The map goes on."""
    usage = run_measured([BIN / "slam_offline", log, "--out", out, *SICK, *(["--resume", out] if day else [])])
    return usage.ru_maxrss / 1000, usage.ru_utime + usage.ru_stime


def start_owner(out, folder):
    """Seconds until the owner of the map has it back from its journal, and the memory that it then has [MB]."""
    begin = time.monotonic()
    with open(folder / "map_updater.log", "w+") as said:
        owner = subprocess.Popen([BIN / "map_updater", "--journal", out / "journal", "--resume", *SICK, "--lcm-url",
                                  "udpm://239.255.76.67:7899?ttl=0"], stdin=subprocess.DEVNULL, stderr=said)
        try:
            while "map_updater: ready" not in pathlib.Path(said.name).read_text():
                if owner.poll() is not None:
                    raise Failed(f"map_updater ended: {pathlib.Path(said.name).read_text()}")
                time.sleep(0.02)
            ready_s = time.monotonic() - begin
            status = pathlib.Path(f"/proc/{owner.pid}/status").read_text()
            return ready_s, int(re.search(r"VmRSS:\s+(\d+)", status)[1]) / 1000
        finally:
            owner.kill()
            owner.wait()


def draw(curves, path):
    """A picture with one small plot for each curve: title, and a value for each day. All begin at 0."""
    width, height, margin = 300, 180, 40
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{len(curves) * width}" height="{height}" '
             f'font-family="sans-serif" font-size="11"><rect width="100%" height="100%" fill="white"/>']
    for number, (title, values) in enumerate(curves):
        most = max(values) * 1.1

        def place(day, value, left=number * width, most=most):
            return (left + margin + day * (width - 1.5 * margin) / len(values),
                    height - margin - value * (height - 2 * margin) / most)

        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in (place(day + 1, value) for day, value in enumerate(values)))
        (left, bottom), (right, top) = place(0, 0), place(len(values), most)
        parts.append(f'<text x="{left:.0f}" y="{margin - 18}">{title}</text>'
                     f'<path d="M{left:.1f},{top:.1f} V{bottom:.1f} H{right:.1f}" fill="none" stroke="black"/>'
                     f'<polyline points="{points}" fill="none" stroke="#c02020" stroke-width="2"/>'
                     f'<text x="{left - 4:.0f}" y="{bottom:.0f}" text-anchor="end">0</text>'
                     f'<text x="{left - 4:.0f}" y="{place(0, max(values))[1]:.0f}" text-anchor="end">{max(values):,.0f}</text>'
                     f'<text x="{right:.0f}" y="{bottom + 16:.0f}" text-anchor="end">day {len(values)}</text>')
    path.write_text("\n".join([*parts, "</svg>"]) + "\n")


def measure_week():
    rows, curves = [], {"mapping: peak memory [MB]": [], "owner after a start: memory [MB]": [], "journal [MB]": [],
                        "start of the owner [s]": []}
    with tempfile.TemporaryDirectory(prefix="crsm_week_", dir=os.environ.get("TMPDIR", "/var/tmp")) as name:
        folder = pathlib.Path(name)
        world, log, out = folder / "week.world", folder / "day.lcm", folder / "out"
        write_world(world)
        for day in range(DAYS):
            write_day(f"sim:{world}", day, log)
            peak_mb, processor_s = map_day(log, out, day)
            ready_s, owner_mb = start_owner(out, folder)
            journal_mb = (out / "journal/journal.lcm").stat().st_size / 1e6
            summary = json.loads((out / "summary.json").read_text())
            for values, value in zip(curves.values(), (peak_mb, owner_mb, journal_mb, ready_s)):
                values.append(value)
            rows.append([day + 1, f"{summary['scans']:,}", f"{summary['path_length_m'] / 1000:.0f}",
                         f"{summary['loops']['keyframes']:,}", f"{processor_s:.0f}", f"{peak_mb:.0f}", f"{owner_mb:.0f}",
                         f"{journal_mb:.0f}", f"{ready_s:.1f}", summary["verdict"]["trust"]])
            progress(f"week: day {day + 1}: {rows[-1]}")
    draw(list(curves.items()), PICTURE)
    return "\n\n".join([table(["day", "scans", "driven [km]", "keyframes", "processor time of the day [s]",
                               "peak memory [MB]", "memory of `map_updater` after a start [MB]", "journal [MB]",
                               "start of `map_updater` [s]", "verdict"], rows),
                        f"![memory, journal and start over the days]({PICTURE.relative_to(PROJECT / 'tests')})"])


SECTIONS = [
    Section("Week", 50, "A robot that drives through the rooms of `sim:rooms` for a week, at ten scans a second, without a "
            "pause, and is started anew each day. One process maps each day as fast as it can and goes on with the map of "
            "the day before. Then `map_updater` is started on the journal of all days.",
            ["build/bin/slam_offline DAY.lcm --preset sick --resume DIR --out DIR",
             "build/bin/map_updater --journal DIR/journal --resume --preset sick"], measure_week, is_timed=True),
]
