"""Many scans in lockstep, of a robot that drives to and fro and of one that stands still: no process grows."""

import json

from faults import SERVICES, await_condition, check, child, may_grow_bytes, num_descriptors, resident_bytes, run
from faults import start_stack, summary

RATE_HZ = 10  # of the simulated laser
EXPORTER_WRITES_BYTES = 1_000_000  # what the exporter's writing thread keeps of a picture, or not
# Rooms that a laser of few beams tells apart: what is counted is scans, not beams.
WORLD = """box 0 0 6 4
box 2 1 0.4 1.5
box 4.2 2.2 0.5 0.5
laser 360 90 10 10 0.01
speed 0.5 1
waypoint 1 0.7
waypoint 3.3 0.7
waypoint 3.3 3.3
waypoint 1 3.3
waypoint 1 0.8
"""


def soak(case, what, stands, num_scans):
    world = case.out / "soak.world"
    world.write_text(WORLD)
    log, one_way = case.convert_long("soak", num_scans, RATE_HZ, stands, f"sim:{world}")
    out = case.folder("soak")
    config = case.out / "soak.toml"
    # With loops memory grows with the path: keyframes are kept, each of some kilobytes.
    config.write_text(f"export_period_s = 0.5\nloops = {str(stands).lower()}\n")
    stack = start_stack(log, out, ["--config", config])
    programs = [program for program in [*SERVICES, "laser_publisher"] if stands or program != "loop_closer"]

    def mapped():
        try:
            return summary(out)["scans"]
        except (OSError, json.JSONDecodeError):
            return 0

    def measure():
        found = {program: child(stack.pid, program) for program in programs}
        return {program: (resident_bytes(pid), num_descriptors(pid)) for program, pid in found.items()}

    # The map is complete, and what gathers while results are written has gathered.
    settled = max(0.4 * num_scans, 2 * one_way)
    samples = []
    for share in (0.0, 0.2, 0.4, 0.6, 0.8):
        at = settled + share * (num_scans - settled)
        await_condition(lambda: mapped() >= at or stack.popen.poll() is not None, 3600, 0.05)
        check(stack.popen.poll() is None, f"run_stack ended early: {stack.errors()[-500:]}")
        samples.append((mapped(), measure()))
    check(stack.wait() == 0, f"run_stack failed: {stack.errors()[-500:]}")
    counts = summary(out)
    check(counts["scans"] == num_scans, f"{counts['scans']} scans of {num_scans} were mapped")

    case.say(f"{what}: {num_scans} scans, {num_scans / RATE_HZ / 3600:.1f} h of a laser at {RATE_HZ} Hz; memory [MB] "
             f"after {', '.join(str(num) for num, _ in samples)} scans")
    for program in programs:
        sizes = [sample[program][0] for _, sample in samples]
        files = [sample[program][1] for _, sample in samples]
        sizes_mb = ", ".join(f"{size / 1e6:.2f}" for size in sizes)
        case.say(f"  {program}: {sizes_mb}; {files[0]} to {files[-1]} files open")
        most = may_grow_bytes(sizes[0]) + (EXPORTER_WRITES_BYTES if program == "map_exporter" else 0)
        check(sizes[-1] - sizes[0] <= most, f"{program} grows by {sizes[-1] - sizes[0]} bytes")
        check(files[-1] <= files[0] + 6, f"{program} opened more files: {files}")  # while it writes


def test(case):
    num_scans = 40000 if case.quick else 1000000 if case.long else 100000
    soak(case, "a robot that drives to and fro in a finished map", False, num_scans)
    soak(case, "a robot that stands still", True, num_scans)


run(test)
