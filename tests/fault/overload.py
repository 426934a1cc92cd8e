"""A laser ten times as fast as the scans are mapped, live: no memory grows, poses stay fresh, each loss is counted."""

import itertools
import multiprocessing
import pathlib
import time

from faults import SERVICES, Driver, Listener, Program, bus_url, check, may_grow_bytes, num_descriptors, peak_bytes
from faults import percentile, port_of, publisher_seconds, read_log, run, run_stack, to_and_fro, with_utime

OVERLOAD = 10
MOST_AGE_S = 2.0  # of a pose: when the laser stops, 20 scans still wait, here for a match of 0.03 s each
KEYFRAME_BYTES = 3000  # range and angle of 270 beams, and what the graph knows of it
LCM_BYTES = 14e6  # LCM's own buffer grows until it has held its longest queue once: 10,000 scans of 1.4 KB


def drive_laser(port, scans, rate_hz, duration_s, num_sent):
    """Publishes as a driver does: each scan with the wall clock as its utime."""
    driver = Driver(port)
    # The robot drives as fast as in the log, so that each of its scans is taken OVERLOAD times.
    course = itertools.chain.from_iterable(itertools.repeat(scan, OVERLOAD) for scan in to_and_fro(scans))
    begin = time.monotonic()
    last_utime = 0
    while (elapsed_s := time.monotonic() - begin) < duration_s:
        while driver.num_sent < elapsed_s * rate_hz:
            last_utime = max(last_utime + 1, int(1e6 * time.time()))
            driver.publish(with_utime(next(course), last_utime))
        time.sleep(0.001)
    num_sent.value = driver.num_sent


def kernel_drops():
    """Datagrams that found a receive buffer full, on this machine since it was started. Not those that a filter kept
    away, which the kernel counts as drops of their socket."""
    names, values = (line.split() for line in pathlib.Path("/proc/net/snmp").read_text().splitlines()
                     if line.startswith("Udp:"))
    return int(dict(zip(names, values))["RcvbufErrors"])


def overload(case, name, scans, flags, rate_hz, matcher_flags=()):
    out = case.folder(name)
    url = bus_url()
    common = ["--lcm-url", url, *flags]
    own_flags = {"rrhc_matcher": matcher_flags, "map_exporter": ["--out", out, "--export-period-s", "1"]}
    services = {program: Program([program, *own_flags.get(program, []), *common], out / f"{program}.log")
                for program in SERVICES}
    for service in services.values():
        service.await_ready()
    listener = Listener(port_of(url))
    drops_before = kernel_drops()

    duration_s = 10 if case.quick else 60
    num_sent = multiprocessing.Value("q", 0)
    laser = multiprocessing.Process(target=drive_laser, args=(port_of(url), scans, rate_hz, duration_s, num_sent))
    laser.start()
    time.sleep(duration_s / 2)
    settled = {program: (peak_bytes(service.pid), num_descriptors(service.pid), listener.statuses[program])
               for program, service in services.items()}
    laser.join()
    grown = {program: peak_bytes(service.pid) - settled[program][0] for program, service in services.items()}
    drops = kernel_drops() - drops_before
    time.sleep(3)  # what is under way is finished, and counted in a last status
    counts = dict(listener.statuses)
    for program, service in services.items():
        check(num_descriptors(service.pid) == settled[program][1], f"{program} opened more files")
    for program in reversed(SERVICES):
        check(services[program].interrupt() == 0, f"{program} failed: {services[program].errors()[-500:]}")

    def of(program, counter):
        return counts[program].get(counter, 0)

    sent = num_sent.value
    case.say(f"{name}: {sent} scans sent in {duration_s} s, {sent / duration_s:.0f} scans/s; "
             f"{of('map_updater', 'handled')} mapped; {drops} packets lost by receive buffers of the kernel")
    flow = {"ray_selector": sent, "rrhc_matcher": of("ray_selector", "handled"),
            "map_updater": of("rrhc_matcher", "handled")}
    for program, sent_to_it in flow.items():
        received, handled, dropped = (of(program, counter) for counter in ("received", "handled", "dropped_overload"))
        lost = sent_to_it - received
        case.say(f"  {program}: {sent_to_it} sent to it = {received} received + {lost} lost on the way; received = "
                 f"{handled} handled + {dropped} dropped")
        check(received == handled + dropped, f"{program}: {received} received, {handled} handled, {dropped} dropped")
        check(0 <= lost <= drops, f"{program}: {lost} lost on the way, but the kernel lost {drops} packets")
    undrawn = of("map_updater", "scan_missing")
    case.say(f"  poses without a scan to draw: {undrawn}; lost poses: {of('rrhc_matcher', 'lost')}; "
             f"late maps: {of('rrhc_matcher', 'map_late')}")
    check(undrawn <= 0.01 * of("map_updater", "handled"), f"{undrawn} poses came without their scan")
    ages_ms = [1000 * age_s for age_s in listener.ages_s]
    case.say(f"  age of the pose: median {percentile(ages_ms, 0.5):.1f} ms, 99 % {percentile(ages_ms, 0.99):.1f} ms, "
             f"oldest {max(ages_ms):.1f} ms")
    num_since = of("map_updater", "handled") - settled["map_updater"][2]["handled"]
    keyframes = of("loop_closer", "keyframes") - settled["loop_closer"][2]["keyframes"]
    case.say(f"  {num_since} scans and {keyframes} keyframes were mapped in the second half")
    for program, (bytes_then, _, _) in settled.items():
        case.say(f"  {program}: {bytes_then / 1e6:.1f} MB at most in half the time, {grown[program] / 1e6:+.2f} MB since")
        kept = keyframes * KEYFRAME_BYTES if program in ("map_updater", "loop_closer") else 0
        check(grown[program] <= may_grow_bytes(bytes_then) + LCM_BYTES + kept,
              f"{program} grew by {grown[program]} bytes over {num_since} scans and {keyframes} keyframes")
    check(max(ages_ms) <= 1000 * MOST_AGE_S, f"a pose was {max(ages_ms):.0f} ms old")


def test(case):
    log = case.convert("demo", "sim:demo")
    scans = read_log(log)
    heavy = ["--good-ratio", "100", "--num-evaluations", "60000"]
    out = case.folder("sustained")
    run_stack(log, out, [])
    rate_hz = len(scans) / publisher_seconds((out / "run_stack.log").read_text())
    case.say(f"sustained in lockstep: {rate_hz:.0f} scans/s")
    overload(case, "fast_laser", scans, [], OVERLOAD * rate_hz)
    overload(case, "slow_matcher", scans, [], 400.0, heavy)


run(test)
