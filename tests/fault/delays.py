"""A network that delays packets by up to half a second, and so reorders them, and loses and doubles some: the map is the
one of a network that does not, in run after run, and nothing stands still."""

import concurrent.futures
import os
import queue
import re
import sys

from faults import GROUP, PROJECT, Failure, Program, check, check_same_results, await_condition, percentile
from faults import publisher_seconds, read_log, run, run_offline, write_log

AT_ONCE = 20
SERVICES = {"map_updater": ["--lockstep"], "loop_closer": [], "rrhc_matcher": ["--lockstep"], "ray_selector": [],
            "map_exporter": []}
NAMES = [*SERVICES, "laser_publisher"]  # each has a port of its own


def map_through_relay(begin, seed, first_port, log, out):
    """Each process on a bus of its own, with a relay between them. begin: starts a program. Returns the seconds that the
    publisher took, and what the relay says that it did."""
    urls = {name: f"udpm://{GROUP}:{first_port + i}?ttl=0" for i, name in enumerate(NAMES)}
    relay = begin([sys.executable, PROJECT / "tests/fault/relay.py", seed, *(first_port + i for i in range(len(NAMES)))],
                  out / "relay.log")
    await_condition(lambda: "relay: ready" in relay.errors(), 30)
    services = [begin([name, *flags, *(["--out", out] if name == "map_exporter" else []), "--lcm-url", urls[name]],
                      out / f"{name}.log") for name, flags in SERVICES.items()]
    for service in services:
        service.await_ready()
    publisher = begin(["laser_publisher", log, "--rate", "max", "--lcm-url", urls["laser_publisher"]],
                      out / "laser_publisher.log")
    check(publisher.wait(600) == 0, f"seed {seed}: the publisher failed: {publisher.errors()[-500:]}")
    check("has waited" not in publisher.errors(), f"seed {seed}: stood still: {publisher.errors()[-500:]}")
    for service in reversed(services):
        check(service.interrupt() == 0, f"seed {seed}: {service.name} failed: {service.errors()[-500:]}")
    relay.popen.terminate()
    relay.wait()
    counts = {name: int(count) for name, count in re.findall(r"(\w+) (\d+)", relay.errors())}
    return publisher_seconds(publisher.errors()), counts


def test(case):
    num_runs, num_scans = (8, 40) if case.quick else (200, 60)
    log = case.out / "beginning.lcm"
    write_log(log, read_log(case.convert("demo", "sim:demo"))[:num_scans])
    undisturbed = case.folder("undisturbed")
    run_offline(log, undisturbed, [])
    free_ports = queue.SimpleQueue()  # the first of those that no other run uses at the moment
    for number in range(AT_ONCE):
        free_ports.put(10000 + (os.getpid() % 80 * AT_ONCE + number) * len(NAMES))

    def one_run(seed):
        out = case.folder(f"run_{seed}")
        first_port = free_ports.get()
        programs = []

        def begin(command, output):
            programs.append(Program(command, output))
            return programs[-1]

        try:
            result = map_through_relay(begin, seed, first_port, log, out)
        finally:
            for program in programs:
                program.popen.kill()
                program.popen.wait()
            free_ports.put(first_port)
        check_same_results(out, undisturbed)
        return result

    with concurrent.futures.ThreadPoolExecutor(AT_ONCE) as pool:
        runs = [pool.submit(one_run, seed) for seed in range(num_runs)]
        failures = [str(one.exception()) for one in concurrent.futures.as_completed(runs) if one.exception()]
    if failures:
        raise Failure(f"{len(failures)} of {num_runs} runs: " + "; ".join(failures[:5]))
    times_s = [one.result()[0] for one in runs]
    counts = {name: sum(one.result()[1][name] for one in runs) for name in ("sent", "lost", "late", "twice")}
    check(all(counts.values()), f"the relay did nothing: {counts}")
    case.say(f"{num_runs} runs of {num_scans} scans: same map; {percentile(times_s, 0.5):.0f} s (median) to "
             f"{max(times_s):.0f} s; of {counts['sent']} packets {counts['lost']} lost, {counts['late']} late, "
             f"{counts['twice']} twice")


run(test)
