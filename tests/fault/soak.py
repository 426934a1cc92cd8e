"""Many scans in lockstep, of a robot that drives to and fro and of one that stands still: no process grows."""

from faults import SERVICES, await_condition, check, child, may_grow_bytes, num_descriptors, resident_bytes, run
from faults import start_stack, summary

RATE_HZ = 10  # of the simulated laser


def test(case):
    num_scans = RATE_HZ * 60 * (10 if case.quick else 120)
    log, one_way = case.convert_long("demo", num_scans, RATE_HZ)
    out = case.folder("soak")
    stack = start_stack(log, out, [])
    programs = [*SERVICES, "laser_publisher"]
    journal = out / "journal/journal.lcm"

    def mapped():
        return journal.stat().st_size / log.stat().st_size * num_scans if journal.exists() else 0

    def measure():
        found = {program: child(stack.pid, program) for program in programs}
        return {program: (resident_bytes(pid), num_descriptors(pid)) for program, pid in found.items()}

    complete = 2 * one_way if num_scans > 3 * one_way else one_way  # there and back, or only there
    samples = []
    for share in (0.0, 0.25, 0.5, 0.75, 0.97):
        at = complete + share * (num_scans - complete)
        await_condition(lambda: mapped() >= at or stack.popen.poll() is not None, 1800, 0.05)
        check(stack.popen.poll() is None, f"run_stack ended early: {stack.errors()[-500:]}")
        samples.append((mapped(), measure()))
    check(stack.wait() == 0, f"run_stack failed: {stack.errors()[-500:]}")
    counts = summary(out)
    check(counts["scans"] == num_scans, f"{counts['scans']} scans of {num_scans} were mapped")

    case.say(f"{num_scans} scans, {num_scans / RATE_HZ / 60:.0f} min of a laser at {RATE_HZ} Hz; memory when the map "
             f"is complete ({complete} scans), and at 25, 50, 75, 97 % of the rest")
    num_since = samples[-1][0] - samples[0][0]
    for program in programs:
        sizes = [sample[program][0] for _, sample in samples]
        files = [sample[program][1] for _, sample in samples]
        per_scan = (sizes[-1] - sizes[0]) / num_since
        case.say(f"  {program}: {', '.join(f'{size / 1e6:.2f}' for size in sizes)} MB: {per_scan:.0f} bytes a scan; "
                 f"{files[0]} to {files[-1]} files open")
        check(sizes[-1] - sizes[0] <= may_grow_bytes(program, sizes[0], num_since),
              f"{program} grows by {per_scan:.0f} bytes a scan")
        check(files[-1] <= files[0] + 1, f"{program} opened more files: {files}")  # one while it writes


run(test)
