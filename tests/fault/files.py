"""Disks that are full, cannot be written, or whose writer is killed: the path is named, older files stay whole, and
mapping goes on."""

import contextlib
import os
import random
import signal
import subprocess
import time

from faults import PROJECT, SERVICES, Program, Skipped, await_condition, bus_url, check, check_same_results, child
from faults import need_program, run, run_stack, start_stack, summary

REPLACED = ["map.png", "map.yaml", "overview.png", "summary.json"]  # trajectory.tum grows
REPLACED_WITHOUT_MAP = REPLACED[2:]
ROOM_BYTES = 40000  # map.png needs 16,000 bytes, the overview 120,000, the trajectory 65 for each new scan


@contextlib.contextmanager
def disk(path, size_kb):
    """A small disk of its own."""
    path.mkdir(parents=True, exist_ok=True)
    made = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size_kb}k", "tmpfs", path], capture_output=True,
                          text=True)
    if made.returncode != 0:
        raise Skipped(f"no disk can be mounted: {made.stderr.strip()}")
    try:
        yield path
    finally:
        subprocess.run(["umount", "--lazy", path], check=True)


def fill(folder, *others):
    """Takes all the room that is left, also behind the ends of `others`. Returns the file that does."""
    ballast = folder / "ballast"
    for path, size in [(ballast, 4096), *((other, 1) for other in others)]:
        with contextlib.suppress(OSError), open(path, "ab", buffering=0) as file:
            while True:
                file.write(b"." * size)
    return ballast


def check_whole(out):
    """Whether the results are readable files, as WriteResults makes them."""
    for name in ("map.png", "overview.png"):
        check((out / name).read_bytes().endswith(b"IEND\xaeB`\x82"), f"{name} is torn")
    text = (out / "trajectory.tum").read_text()
    check(text.endswith("\n") and all(len(line.split()) == 8 for line in text.splitlines()), "trajectory.tum is torn")
    check((out / "summary.json").read_text().rstrip().endswith("}"), "summary.json is torn")


def numbers_of_files(out):
    return {name: (out / name).stat().st_ino for name in REPLACED}


def check_written_together(out, before):
    """Whether all the results are other files than before, or none, or all but those of a map that is the same. Returns
    what they are now."""
    def changed():
        return [name for name, number in numbers_of_files(out).items() if number != before[name]]
    if changed() not in ([], REPLACED, REPLACED_WITHOUT_MAP):
        time.sleep(0.05)  # they were just being replaced: on a full disk that does not happen twice in a row
        check(changed() in ([], REPLACED, REPLACED_WITHOUT_MAP), f"of the results only {changed()} are new")
    return numbers_of_files(out)


def refused(case, command, path):
    """Runs a program that has to refuse a path, in one line."""
    log = case.folder("refused") / "log"
    program = Program([*command, "--lcm-url", bus_url()], log)
    check(program.wait(30) not in (0, -signal.SIGABRT), f"{command[0]} took {path}")
    errors = program.errors()
    check(errors.count("\n") == 1 and str(path) in errors, f"{command[0]} said: {errors}")
    case.say(errors.strip())


def read_only_and_missing(case):
    with disk(case.out / "read_only", 1000) as folder:
        subprocess.run(["mount", "-o", "remount,ro", folder], check=True)
        refused(case, ["map_exporter", "--out", folder], folder)
        refused(case, ["map_exporter", "--out", folder / "below"], folder / "below")
        refused(case, ["map_updater", "--journal", folder], folder)
        refused(case, ["map_updater", "--journal", folder / "below"], folder / "below")
        refused(case, [PROJECT / "scripts/run_stack", "sim:demo", "--out", folder / "below"], folder / "below")
    refused(case, ["map_updater", "--resume", "--journal", case.out / "nothing"], case.out / "nothing")
    missing = case.folder("missing") / "a/b"
    services = [Program(["map_updater", "--journal", missing / "journal", "--lcm-url", bus_url()], case.out / "1.log"),
                Program(["map_exporter", "--out", missing / "out", "--lcm-url", bus_url()], case.out / "2.log")]
    for service in services:
        service.await_ready()
        check(service.interrupt() == 0, service.errors())
    check((missing / "journal/journal.lcm").exists() and (missing / "out/map.png").exists(), "no folder was made")
    case.say("missing folders of --out and --journal are made")


def full_disk(case):
    """The disk of --out and --journal fills in the middle of a run, then there is room again."""
    with disk(case.out / "full", 200000) as folder:
        out = folder / "out"
        out.mkdir()
        stack = start_stack(case.long_log, out, case.often)
        await_condition(lambda: (out / "summary.json").exists(), 30)
        services = {name: child(stack.pid, name) for name in SERVICES}
        ballast = fill(folder, *(out / "log").glob("*.log"))
        time.sleep(0.2)  # the journal has ended: the room that follows is for some of the results, but not for all
        os.truncate(ballast, ballast.stat().st_size - ROOM_BYTES)
        results = numbers_of_files(out)
        for _ in range(10):
            time.sleep(0.1)
            check_whole(out)
            results = check_written_together(out, results)
        for name, pid in services.items():
            check(child(stack.pid, name) == pid, f"{name} did not live through a full disk")
        ballast.unlink()
        check(stack.wait() == 0, f"run_stack failed: {stack.errors()[-800:]}")
        check_same_results(out, case.long_map)
        counts = summary(out)["counts"]
        check(counts.get("map_exporter.write_failed", 0) > 0, "no write of the results failed")
        check(counts.get("map_updater.journal_failed", 0) == 1, "the journal did not fail")
        case.say("a disk of results, journal and logs that is full for 1 s: every service lives, counts its failed "
                 f"writes ({counts['map_exporter.write_failed']} of the results), older results stay together, "
                 "same map in the end")


def full_disk_of_one(case):
    """Only the results, or only the journal, are on the full disk: the log says so."""
    undisturbed = case.folder("undisturbed")
    run_stack(case.log, undisturbed, [])
    for service, flag in (("map_exporter", "--out"), ("map_updater", "--journal")):
        with disk(case.out / "small", 400) as folder:
            out = folder if flag == "--out" else case.folder("results")
            journal = folder if flag == "--journal" else case.folder("journal")
            log = case.folder("log")
            url = ["--lcm-url", bus_url()]
            if flag == "--out":
                fill(folder)
            programs = {
                "map_updater": ["--lockstep", "--journal", journal],
                "loop_closer": [],
                "rrhc_matcher": ["--lockstep"],
                "ray_selector": [],
                "map_exporter": ["--out", out, "--export-period-s", "0.1"],
            }
            services = {name: Program([name, *flags, *url], log / name) for name, flags in programs.items()}
            for program in services.values():
                program.await_ready()
            check(Program(["laser_publisher", case.log, "--rate", "max", *url], log / "publisher").wait() == 0,
                  "the publisher failed")
            if flag == "--out":
                (folder / "ballast").unlink()
                subprocess.run(["mount", "-o", "remount,size=4000k", folder], check=True)
            for name in reversed(SERVICES):
                check(services[name].interrupt() == 0, f"{name} failed: {services[name].errors()}")
            check_same_results(out, undisturbed)
            said = [line for line in services[service].errors().splitlines() if str(folder) in line]
            check(said and "No space left" in said[0], f"{service} said: {services[service].errors()}")
            case.say(said[0])


def interrupted_write(case):
    """The exporter is killed at random moments while it writes all the time."""
    randomness = random.Random(2)
    out = case.folder("interrupted")
    stack = start_stack(case.long_log, out, case.often)
    await_condition(lambda: (out / "summary.json").exists(), 30)
    publisher = child(stack.pid, "laser_publisher")
    num_kills = 0
    num_torn = 0  # kills that left a half-written file, which the next exporter removes
    while num_kills < (6 if case.quick else 20):
        await_condition(lambda: child(stack.pid, "map_exporter"), 10)
        pid = child(stack.pid, "map_exporter")
        check(child(stack.pid, "laser_publisher") == publisher, f"the run ended after {num_kills} kills already")
        if num_kills % 2:
            await_condition(lambda: any(name.endswith(f".{pid}.tmp") for name in os.listdir(out)), 10, 0.0)
        else:
            time.sleep(0.3 * randomness.random())
        os.kill(pid, signal.SIGKILL)
        num_kills += 1
        await_condition(lambda: child(stack.pid, "map_exporter") != pid, 10)
        num_torn += any(name.endswith(f".{pid}.tmp") for name in os.listdir(out))
        check_whole(out)
    check(stack.wait() == 0, f"run_stack failed: {stack.errors()[-800:]}")
    check_same_results(out, case.long_map)
    check(not list(out.glob(".*.tmp")), "half a file is left")
    case.say(f"exporter killed {num_kills} times while it wrote, {num_torn} of them in the middle of a file: "
             "files always whole, same map in the end, nothing left behind")


def test(case):
    if os.geteuid() != 0:
        raise Skipped("needs root, to mount small disks")
    need_program("mount", "umount")
    case.log = case.convert("demo", "sim:demo")
    case.long_log, _ = case.convert_long("demo", 30000 if case.quick else 120000)
    case.long_map = case.folder("undisturbed_long")
    run_stack(case.long_log, case.long_map, [])
    (case.out / "often.toml").write_text("export_period_s = 0.1\n")
    case.often = ["--config", case.out / "often.toml"]
    full_disk(case)
    full_disk_of_one(case)
    interrupted_write(case)
    read_only_and_missing(case)


run(test)
