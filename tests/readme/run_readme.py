#!/usr/bin/env python3
"""Runs every command of the READMEs, in their order, in a clean clone, as somebody would who has just come.

usage: tests/readme/run_readme.py [--built] [README...]
README: of these files only, and of README.md before, which builds. --built: nothing is built; the programs are those of
build/bin here, and README.md is left out, which is quick where only one other file is looked at.
A README is read in a new shell, in the clone's root folder. A command that is to be interrupted (its comment says
Ctrl-C, or it maps live) is, after a while, and has to end as well as the others. A block that begins with an export of
the bus is typed in several shells, a line in each. What cannot be run in a test is named in UNRUN, with the reason; the
program that it names has to be there. CRSM_DATA names the folder of the benchmark logs; where there is none, the
commands about them are left out, and that is said.
"""

import contextlib
import importlib.util
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from blocks import SKIPPED, WithoutGit, blocks_of, files_of, in_order

PROJECT = pathlib.Path(__file__).resolve().parents[2]
DATA = pathlib.Path(os.environ.get("CRSM_DATA", PROJECT.parent / "shared" / "data"))
BENCHMARK = DATA / "radish" / "fr079"  # .clf.gz and .relations
PORT = str(7000 + os.getpid() % 600)  # of a bus of our own
TIME_LIMIT_S = 1200  # the first command builds
BEFORE_INTERRUPT_S = 1.0
LIVE_S = 8.0
RESULTS = ("map.png", "map.yaml", "overview.png", "trajectory.tum", "summary.json")

UNRUN = {  # by how a command begins, behind sudo and variables
    "scripts/test": "it is what runs this",
    "scripts/packages": "scripts/packages --chroot does all of it, in clean Debians",
    "scripts/build": "README.md builds the programs, and scripts/test the rest",
    "scripts/setup": "README.md installs what building takes; the rest is for other tests",
    "scripts/docs": "the test docs runs it",
    "scripts/spy": "needs a screen",
    "scripts/film": "needs a browser",
    "scripts/experiments": "takes 10 minutes and more",
    "scripts/results": "takes an hour and more",
    "scripts/bench": "measures, and tests nothing",
    "scripts/fault": "takes 10 minutes and more",
    "scripts/fuzz": "takes 10 minutes and more",
    "scripts/mutants": "takes hours",
    "scripts/examples/": "tests/examples runs it",
    "build/bin/example_": "tests/examples runs it",
    "build/bin/accuracy_tests": "scripts/test runs it",
    "build/bin/process_tests": "scripts/test runs it",
    "build/bin/unit_tests": "scripts/test runs it",
    "build/bin/experiments": "scripts/experiments runs it",
    "apt": "as scripts/packages",
    "out/venv/": "builds once more; the test python uses the package as it is built here",
    "dpkg": "as scripts/packages",
    "systemctl": "needs a running systemd; tests/process/systemd_test.cpp reads the units",
    "usermod": "is for the whole machine",
    "ip": "needs another host; scripts/fault hosts has three",
    "sysctl": "is for the whole machine",
}
NEEDS_LASER = re.compile(r"\b(?:hokuyo|rplidar|sick):")
STAYS = "run_stack: the map stays at "  # with --view, until it is interrupted once more
SEVERAL_SHELLS = "export LCM_DEFAULT_URL="


class Failed(Exception):
    pass


class Shell:
    """What somebody types, in a folder."""

    def __init__(self, folder):
        self.folder = folder
        self.started = []
        self.environment = {**os.environ, "LCM_DEFAULT_URL": f"udpm://239.255.76.67:{PORT}?ttl=0",
                            "DESTDIR": str(folder / "out" / "installed")}

    def export(self, text):
        name, value = shlex.split(text)[1].split("=", 1)
        self.environment[name] = value

    def start(self, text, place="the test itself"):
        output = tempfile.TemporaryFile("w+")
        process = subprocess.Popen(["bash", "-c", f"exec env {text}"], cwd=self.folder, env=self.environment,
                                   stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
                                   start_new_session=True)
        process.text, process.place, process.output = text, place, output
        self.started.append(process)
        return process

    def finish(self, process, interrupt_after_s=None):
        """Fails unless it ends with success, and with the results in its --out."""
        if interrupt_after_s is not None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(interrupt_after_s)
            process.send_signal(signal.SIGINT)
        try:
            code = self.await_exit(process)
        except subprocess.TimeoutExpired:
            code = f"none within {TIME_LIMIT_S} s"
        process.output.seek(0)
        said = process.output.read()
        if code != 0:
            raise Failed(f"{process.place}: exit code {code}: {process.text}\n{said}")
        out = re.search(r"--out (\S+)", process.text)
        if out and "." not in out[1]:
            missing = [name for name in RESULTS if not (self.folder / out[1] / name).is_file()]
            if missing:
                raise Failed(f"{process.place}: no {', '.join(missing)} in {out[1]}: {process.text}\n{said}")

    def await_exit(self, process):
        """The exit code of a process, which is interrupted when it only shows its finished map."""
        give_up = time.monotonic() + TIME_LIMIT_S
        shows_map = False
        while True:
            try:
                return process.wait(1.0)
            except subprocess.TimeoutExpired:
                if time.monotonic() > give_up:
                    raise
            said = os.pread(process.output.fileno(), 1 << 20, 0)  # a seek would move the place where it writes
            if not shows_map and STAYS.encode() in said:
                shows_map = True
                process.send_signal(signal.SIGINT)

    def close(self):
        for process in self.started:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)


def prepare(command):
    """What is typed here: on a bus of our own, as who we are, with a log where the README leaves the choice."""
    text = command.text.replace(":7667", f":{PORT}").removeprefix("sudo ")
    return re.sub(r"\bLOG\b(?=\.clf|\.relations)", str(BENCHMARK), text)


def program_of(command):
    """What a command begins with, behind sudo and variables, and the whole from there on."""
    text = re.sub(r"^(?:sudo |[A-Z_]+=\S+ )+", "", command.text)
    return text.split()[0], text


def reason_not_to_run(command):
    program, text = program_of(command)
    for begin, reason in UNRUN.items():
        if text.startswith(begin) if "/" in begin else program == begin:
            return reason
    if NEEDS_LASER.search(text):
        return "needs the laser; tests/emulators has one"
    if " --without " in text:
        return "waits for another process; tests/examples has one"
    if " -m venv " in text and not importlib.util.find_spec("ensurepip"):
        return "there is no python3-venv"
    if program == "parallel" and not shutil.which("parallel"):
        return "there is no GNU parallel"
    if re.search(r"\bLOG\b", prepare(command)):
        return "a log of the reader's"
    if str(BENCHMARK) in prepare(command) and not BENCHMARK.with_suffix(".relations").exists():
        return f"there is no {BENCHMARK}.clf.gz: CRSM_DATA says where the benchmark logs are"
    return None


def check_is_there(command, folder):
    """For what is not run: the script, or the program's target."""
    program, _ = program_of(command)
    targets = (folder / "CMakeLists.txt").read_text() + (folder / "tests/CMakeLists.txt").read_text()
    if program.startswith("scripts/") and not (folder / program).is_file():
        raise Failed(f"{command.place}: there is no {program}")
    target = program.removeprefix("build/bin/").removesuffix("_tests").removeprefix("example_")
    if program.startswith("build/bin/") and not re.search(rf"\b{target}\b", targets):
        raise Failed(f"{command.place}: no target of CMakeLists.txt makes {program}")


def run_one_by_one(shell, block):
    for command in block:
        if command.text.startswith("export "):
            shell.export(prepare(command))
            continue
        process = shell.start(prepare(command), command.place)
        if " live " not in command.text:
            shell.finish(process, BEFORE_INTERRUPT_S if command.is_interrupted else None)
            continue
        time.sleep(BEFORE_INTERRUPT_S)
        laser = shell.start("build/bin/laser_publisher sim:demo --rate 10")
        shell.finish(process, LIVE_S)
        shell.finish(laser, 0)


def run_together(shell, block):
    """Commands of several shells: all are started; the publisher ends by itself, and then the others are ended."""
    publisher, *others = [shell.start(part.strip(), command.place)
                          for command in block for part in prepare(command).split(" & ")]
    shell.finish(publisher)
    for process in reversed(others):  # the exporter first: it asks the owner of the map
        shell.finish(process, 0)


def run(shell, block):
    runnable = []
    for command in block:
        print(f"{command.place}: {command.text}", flush=True)
        if reason := reason_not_to_run(command):
            print(f"  not run: {reason}")
            check_is_there(command, shell.folder)
        else:
            runnable.append(command)
    if block[0].text.startswith(SEVERAL_SHELLS):
        shell.export(prepare(block[0]))
        run_together(shell, runnable[1:])
    else:
        run_one_by_one(shell, runnable)


def run_readme(folder, file):
    """Returns what failed; after a failure it goes on with the next block."""
    shell = Shell(folder)
    failures = []
    try:
        for block in blocks_of(file, (folder / file).read_text()):
            begin = time.monotonic()
            try:
                run(shell, block)
            except Failed as failure:
                print(failure, flush=True)
                failures.append(str(failure).splitlines()[0])
            if (seconds := time.monotonic() - begin) > 5.0:
                print(f"  {seconds:.0f} s")
    except ValueError as error:
        failures.append(str(error))
    finally:
        shell.close()
    return failures


def make_clone(folder):
    """The files as they are here, also what is not committed yet; nothing that was built."""
    subprocess.run(["git", "clone", "--quiet", PROJECT, folder], check=True)
    for name in files_of(PROJECT):
        here, there = PROJECT / name, folder / name
        if here.exists():
            there.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(here, there)
        else:
            there.unlink(missing_ok=True)


def take_what_is_built(clone):
    """In place of README.md: the programs, and what scripts/demo leaves."""
    UNRUN.update({"cmake": "needs what README.md builds", "scripts/demo": "it builds"})
    for name in ("bin", "python"):
        shutil.copytree(PROJECT / "build" / name, clone / "build" / name)
    (clone / "out/demo").mkdir(parents=True)
    subprocess.run(["build/bin/slam_offline", "sim:demo", "--out", "out/demo"], cwd=clone, check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def main(arguments):
    readmes = [file for file in in_order(files_of(PROJECT)) if (PROJECT / file).exists()]
    built = "--built" in arguments
    wanted = [argument for argument in arguments if argument != "--built"] or readmes
    if unknown := [file for file in wanted if file not in readmes]:
        print(__doc__.strip() if unknown == ["--help"] else f"no README of the project: {', '.join(unknown)}")
        return 0 if unknown == ["--help"] else 2
    with tempfile.TemporaryDirectory(prefix="crsm_readme_") as folder:
        clone = pathlib.Path(folder) / "clone"
        make_clone(clone)
        if built:
            take_what_is_built(clone)
        failures = [] if built else run_readme(clone, "README.md")  # without what it builds nothing works
        for file in readmes if not failures else []:
            if file in wanted and file != "README.md":
                failures += run_readme(clone, file)
    print("\n".join(["", *failures]) if failures else "all is well")
    return 1 if failures else 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except WithoutGit as error:
        print(f"skipped: {error}")
        sys.exit(SKIPPED)
