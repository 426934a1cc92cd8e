"""The processor time of slam_offline and of the stack's processes in lockstep, in turns on the same log. See scripts/bench."""

import argparse
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

PROJECT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("CRSM_BIN_DIR", PROJECT / "build/bin"))
# As scripts/run_stack starts them: flags of each, in lockstep.
SERVICES = {"map_updater": ["--lockstep", "--journal", "{out}/journal"], "rrhc_matcher": ["--lockstep"],
            "loop_closer": [], "ray_selector": [], "map_exporter": ["--out", "{out}"]}
# Those that share a core in lockstep.
TAKE_TURNS = ["laser_publisher", "ray_selector", "rrhc_matcher", "map_updater"]


class Program:
    """A program of ours that runs, on one core where that is said, and dies with this process; its stderr goes to a file."""

    def __init__(self, name, arguments, out, core=None):
        self.name = name
        self.log = out / f"{name}.log"
        placed = [] if core is None else ["taskset", "--cpu-list", str(core)]
        with open(self.log, "wb") as log:
            self.popen = subprocess.Popen(
                [*placed, "setpriv", "--pdeathsig", "TERM", BIN / name, *map(str, arguments)],
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=log)

    def errors(self):
        return self.log.read_text(errors="replace")

    def await_ready(self):
        give_up = time.monotonic() + 30
        while f"{self.name}: ready" not in self.errors():
            if self.popen.poll() is not None or time.monotonic() > give_up:
                sys.exit(f"{self.name} did not get ready: {self.errors()[-500:]}")
            time.sleep(0.01)

    def processor_time(self):
        """Waits for its end. Returns the seconds that it took of the processor: its own, and the kernel's for it."""
        _, status, usage = os.wait4(self.popen.pid, 0)
        self.popen.returncode = os.waitstatus_to_exitcode(status)
        if self.popen.returncode != 0:
            sys.exit(f"{self.name} failed: {self.errors()[-500:]}")
        return usage.ru_utime, usage.ru_stime


def shared_core(name):
    """The core for a process in lockstep: None, for any, where it does not take turns with others."""
    return min(os.sched_getaffinity(0)) if name in TAKE_TURNS else None


def run_offline(log, flags, out):
    return {"slam_offline": Program("slam_offline", [log, "--out", out, *flags], out).processor_time()}


def run_stack(log, flags, out):
    """Returns the processor time of each process, and the seconds from the first scan to the last."""
    flags = [*flags, "--lcm-url", f"udpm://239.255.76.67:{21000 + os.getpid() % 11000}?ttl=0"]
    services = [Program(name, [part.format(out=out) for part in own] + flags, out, shared_core(name))
                for name, own in SERVICES.items()]
    for service in services:
        service.await_ready()
    publisher = Program("laser_publisher", [log, "--rate", "max", *flags], out, shared_core("laser_publisher"))
    begin = time.monotonic()
    times = {"laser_publisher": publisher.processor_time()}
    elapsed_s = time.monotonic() - begin
    for service in sorted(services, key=lambda service: service.name != "map_exporter"):  # it goes first: it asks others
        service.popen.terminate()
        times[service.name] = service.processor_time()
    return times, elapsed_s


def convert(source, path):
    """An LCM log, so that neither side has to simulate, or to read text."""
    subprocess.run([BIN / "laser_publisher", source, "--lcm-url", f"file://{path}?mode=w"], check=True,
                   stderr=subprocess.DEVNULL)


def num_scans(out):
    return sum(1 for line in (out / "trajectory.tum").read_text().splitlines() if not line.startswith("#"))


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench stack")
    parser.add_argument("log", nargs="?", default="sim:demo")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--no-loops", action="store_true")
    arguments, flags = parser.parse_known_args()

    runs = []
    with tempfile.TemporaryDirectory(prefix="crsm_bench_") as folder:
        if arguments.no_loops:
            config = pathlib.Path(folder) / "no_loops.toml"
            config.write_text("loops = false\n")
            flags += ["--config", config]
            del SERVICES["loop_closer"]
        log = pathlib.Path(folder) / "scans.lcm"
        convert(arguments.log, log)
        for number in range(arguments.runs):
            out = pathlib.Path(folder) / str(number)
            offline, stack = out / "offline", out / "stack"
            offline.mkdir(parents=True)
            stack.mkdir()
            times = run_offline(log, flags, offline)
            stack_times, elapsed_s = run_stack(log, flags, stack)
            times.update(stack_times)
            scans = num_scans(offline)
            if num_scans(stack) != scans:
                sys.exit(f"the processes mapped {num_scans(stack)} scans, slam_offline {scans}")
            runs.append((scans, times, elapsed_s))

    scans = runs[0][0]
    print(f"{arguments.log}: {scans} scans, {len(runs)} runs; medians")
    print("processor time of a scan [ms]    user  system     sum")

    def row(name, programs):
        columns = [[1e3 * sum(times[program][part] for program in programs) / scans for _, times, _ in runs]
                   for part in (0, 1)]
        columns.append([user + system for user, system in zip(*columns)])
        print(f"{name:<28}" + "".join(f"{statistics.median(column):8.3f}" for column in columns))
        return columns[-1]

    stack = ["laser_publisher", *reversed(SERVICES)]
    number = {5: "five", 6: "six"}[len(stack)]
    for program in stack:
        row(program, [program])
    ratios = [together / offline for together, offline in zip(row(f"the {number} together", stack),
                                                        row("slam_offline", ["slam_offline"]))]
    print(f"the {number} take {statistics.median(ratios):.2f} times what slam_offline takes "
          f"({min(ratios):.2f} to {max(ratios):.2f}), and map "
          f"{statistics.median(scans / elapsed_s for _, _, elapsed_s in runs):.0f} scans/s")


if __name__ == "__main__":
    main()
