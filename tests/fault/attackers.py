"""Packets that make LCM 1.3.1 write outside of a message, from the same host and from another one, and scans that
another host sends to a bus of ttl=0: nothing dies, and the map is the one of an undisturbed run."""

import sys

from faults import PROJECT, Program, await_condition, bus_url, check, check_same_results, hosts, port_of, run
from faults import run_offline, summary

COUNT = 1000


def journal_bytes(out):
    path = out / "journal/journal.lcm"
    return path.stat().st_size if path.exists() else 0


def attack(case, host, url, ttl, log, fragments_only):
    command = [sys.executable, PROJECT / "tests/fault/attack.py", port_of(url), ttl, COUNT, log]
    return Program(command + (["fragments_only"] if fragments_only else []), case.out / f"attack_{ttl}.log", host)


def test(case):
    num_scans = 3000 if case.quick else 6000  # longer than all the packets take
    log, _ = case.convert_long("demo", num_scans)
    undisturbed = case.folder("undisturbed")
    run_offline(log, undisturbed, [])

    for name, bus_ttl, attacker, ttl, fragments_only in (
            ("the same host, ttl=0", 0, 0, 0, True), ("the same host, ttl=1", 0, 0, 1, True),
            ("another host, a bus of ttl=0", 0, 1, 1, False), ("another host, a bus of ttl=1", 1, 1, 1, True)):
        with hosts(2) as members:
            out = case.folder("attacked")
            url = bus_url(ttl=bus_ttl)
            stack = Program([PROJECT / "scripts/run_stack", log, "--out", out, "--lcm-url", url], out / "run_stack.log",
                            members[0])
            await_condition(lambda: journal_bytes(out) > 100000 or stack.popen.poll() is not None, 60)
            attackers = attack(case, members[attacker], url, ttl, log, fragments_only)
            check(stack.wait() == 0, f"{name}: run_stack failed: {stack.errors()[-1000:]}")
            sent = "attack: sent" in attackers.errors()
            attackers.popen.kill()
            attackers.popen.wait()
            check("ended unexpectedly" not in stack.errors(), f"{name}: a process died: {stack.errors()[-1000:]}")
            check_same_results(out, undisturbed)
            check(sent, f"{name}: the run ended before all packets were sent")
            num_heard = summary(out)["counts"]["ray_selector.handled"]
            check(num_heard == num_scans, f"{name}: {num_heard} scans were heard instead of {num_scans}")
            case.say(f"{name}: {COUNT} times 6 packets{'' if fragments_only else ', and scans'}: same map")


run(test)
