"""A log mapped in three sessions, and a map_updater that is killed while a robot is localised: the files of one run."""

import os
import random
import signal

from faults import await_condition, check, check_same_results, child, read_log, run, run_offline, run_stack, start_stack
from faults import write_log


def three_sessions(case, name, log, flags, whole, randomness):
    """Each session by one process or by the stack; a later one goes on in a folder of its own, or in the same."""
    scans = read_log(log)
    first, second = sorted(randomness.sample(range(1, len(scans)), 2))
    parts = []
    for number, part in enumerate((scans[:first], scans[first:second], scans[second:])):
        parts.append(case.out / f"part_{number}.lcm")
        write_log(parts[-1], part)
    for how in ("offline, stack, offline", "stack, offline, stack", "stack, stack, stack"):
        for same_folder in (False, True):
            out = None
            for number, program in enumerate(how.split(", ")):
                earlier = out
                out = earlier if same_folder and earlier else case.folder(f"session_{number}")
                resume = ["--resume", earlier] if earlier else []
                (run_offline if program == "offline" else run_stack)(parts[number], out, [*flags, *resume])
            check_same_results(out, whole)
    case.say(f"{name}: cut behind scans {first} and {second} of {len(scans)}; each session in one process or in the stack, "
             "in folders of their own or in one: same map")


def kill_updater(case, name, log, flags, whole, num_kills, randomness):
    """The run that is localised is the one that made the map: there is no harder one to tell from mapping."""
    expected = case.folder("localized")
    run_offline(log, expected, [*flags, "--localize", whole])
    out = case.folder("killed")
    stack = start_stack(log, out, [*flags, "--localize", whole])
    journal = out / "journal/journal.lcm"
    end_bytes = (expected / "journal/journal.lcm").stat().st_size
    pid = None
    for share in sorted(0.95 * randomness.random() for _ in range(num_kills)):
        killed = pid

        def is_due():
            nonlocal pid
            pid = child(stack.pid, "map_updater")
            grown = journal.exists() and journal.stat().st_size >= share * end_bytes
            return stack.popen.poll() is not None or (grown and pid and pid != killed)

        await_condition(is_due, 120, 0.001)
        check(stack.popen.poll() is None, f"run_stack ended early: {stack.errors()[-1000:]}")
        os.kill(pid, signal.SIGKILL)
    check(stack.wait() == 0, f"run_stack failed: {stack.errors()[-1000:]}")
    check_same_results(out, expected)
    check((out / "map.png").read_bytes() == (whole / "map.png").read_bytes(), "the finished map changed")
    case.say(f"{name}: map_updater killed {num_kills} times while the robot was localised: same poses, same map")


def test(case):
    randomness = random.Random(1)
    for name, log, flags in [*case.logs(), *case.logs_that_come_back()]:
        whole = case.folder("whole")
        run_offline(log, whole, flags)
        for _ in range(1 if case.quick else 3):
            three_sessions(case, name, log, flags, whole, randomness)
        kill_updater(case, name, log, flags, whole, 3 if case.quick else 10, randomness)


run(test)
