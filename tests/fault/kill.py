"""Processes are killed (SIGKILL) at random moments of a run in lockstep: the map is the one of an undisturbed run."""

import contextlib
import os
import random
import signal

from faults import SERVICES, await_condition, check, check_same_results, child, run, run_stack, start_stack
from faults import publisher_seconds


def journal_bytes(out):
    path = out / "journal/journal.lcm"
    return path.stat().st_size if path.exists() else 0


def hold_log(stack, held):
    """Stops the publisher, or lets it go on."""
    publisher = child(stack.pid, "laser_publisher")
    if publisher:
        os.kill(publisher, signal.SIGSTOP if held else signal.SIGCONT)


PROCESSES = [*SERVICES, "laser_publisher"]


def map_and_kill(log, out, flags, moments, end_bytes):
    """Kills processes as the journal grows: moments are (share of the journal's bytes at the end, process). None is
    killed twice while no scan is mapped: run_stack gives up one that dies five times so. The log waits for a service that
    is to be killed and is not there again, or it would end before the last are killed."""
    stack = start_stack(log, out, flags)
    killed_at_bytes = {}
    for share, service in sorted(moments):
        def kill_if_due():
            mapped_bytes = journal_bytes(out)
            due = mapped_bytes >= share * end_bytes and mapped_bytes != killed_at_bytes.get(service)
            pid = child(stack.pid, service)  # none while it is started again
            with contextlib.suppress(ProcessLookupError):  # it was dying from the last time
                hold_log(stack, held=due and not pid)
                if due and pid:
                    os.kill(pid, signal.SIGKILL)
                    killed_at_bytes[service] = mapped_bytes
                    return True
            return stack.popen.poll() is not None

        await_condition(kill_if_due, 120, 0.001)
        check(stack.popen.poll() is None, f"run_stack ended early: {stack.errors()[-1000:]}")
    check(stack.wait() == 0, f"run_stack failed: {stack.errors()[-1000:]}")
    return publisher_seconds(stack.errors())


def test(case):
    randomness = random.Random(1)
    num_runs, num_kills_in_storm = (3, 5) if case.quick else (20, 20)
    for name, log, flags in [*case.logs(), *case.logs_that_come_back(), *case.logs_that_break()]:
        undisturbed = case.folder("undisturbed")
        alone_s = run_stack(log, undisturbed, flags)
        end_bytes = journal_bytes(undisturbed)

        def disturb(what, kills_each):
            out = case.folder("disturbed")
            moments = [(0.98 * randomness.random(), service) for service in PROCESSES for _ in range(kills_each)]
            took_s = map_and_kill(log, out, flags, moments, end_bytes)
            check_same_results(out, undisturbed)
            left = [path.name for path in out.glob(".*.tmp")]
            check(not left, f"{name}, {what}: left behind in the results: {left}")
            return took_s

        times_s = [disturb(f"run {number + 1}", 1) for number in range(num_runs)]
        case.say(f"{name}: {alone_s:.1f} s undisturbed; {num_runs} runs in which each of the {len(PROCESSES)} processes is "
                 f"killed once: same map, {min(times_s):.1f} to {max(times_s):.1f} s")
        storm_s = disturb("storm", num_kills_in_storm)
        case.say(f"{name}: each of the {len(PROCESSES)} processes killed {num_kills_in_storm} times in one run: same map, "
                 f"{storm_s:.1f} s")


run(test)
