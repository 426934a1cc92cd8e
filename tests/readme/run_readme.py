#!/usr/bin/env python3
"""Runs every command of the README, in its order, in a clean clone, as somebody would who has just come.

usage: tests/readme/run_readme.py
A command that is to be interrupted (its comment says Ctrl-C, or it maps live) is, after a while, and has to end as well as
the others. What cannot be run in a test is named in UNRUN, with the reason. CRSM_DATA names the folder of the benchmark
logs; where there is none, the commands about them are left out, and that is said.
"""

import contextlib
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

from blocks import blocks_of

PROJECT = pathlib.Path(__file__).resolve().parents[2]
DATA = pathlib.Path(os.environ.get("CRSM_DATA", PROJECT.parent / "shared" / "data"))
BENCHMARK = DATA / "radish" / "fr079"  # .clf.gz and .relations
PORT = str(7000 + os.getpid() % 600)  # of a bus of our own
TIME_LIMIT_S = 1200  # the first command builds
BEFORE_INTERRUPT_S = 1.0
LIVE_S = 8.0
RESULTS = ("map.png", "map.yaml", "overview.png", "trajectory.tum", "summary.json")

UNRUN = {  # by how a command begins
    "scripts/test": "it is what runs this",
    "scripts/packages": "scripts/packages --chroot does all of it, in clean Debians",
    "sudo apt": "as scripts/packages",
    "scripts/spy": "needs a screen",
    "sudo systemctl": "needs a running systemd; tests/service/systemd_test.cpp reads the units",
    "scripts/run_stack hokuyo": "needs the laser; tests/emulators has one",
    "scripts/run_stack rplidar": "needs the laser; tests/emulators has one",
    "scripts/run_stack sick": "needs the laser; tests/emulators has one",
    "ip route": "needs another host; scripts/fault hosts has three",
    "sysctl": "is for the whole machine",
}


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

    def start(self, text):
        output = tempfile.TemporaryFile("w+")
        process = subprocess.Popen(["bash", "-c", f"exec {text}"], cwd=self.folder, env=self.environment,
                                   stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
                                   start_new_session=True)
        process.text, process.output = text, output
        self.started.append(process)
        return process

    def finish(self, process, interrupt_after_s=None):
        """Fails unless it ends with success, and with the results in its --out."""
        if interrupt_after_s is not None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(interrupt_after_s)
            process.send_signal(signal.SIGINT)
        try:
            code = process.wait(TIME_LIMIT_S)
        except subprocess.TimeoutExpired:
            code = f"none within {TIME_LIMIT_S} s"
        process.output.seek(0)
        said = process.output.read()
        if code != 0:
            raise Failed(f"exit code {code}: {process.text}\n{said}")
        out = re.search(r"--out (\S+)", process.text)
        if out and "." not in out[1]:
            missing = [name for name in RESULTS if not (self.folder / out[1] / name).is_file()]
            if missing:
                raise Failed(f"no {', '.join(missing)} in {out[1]}: {process.text}\n{said}")

    def close(self):
        for process in self.started:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)


def prepare(command):
    """What is typed here: on a bus of our own, as who we are, with a log where the README leaves the choice."""
    text = command.text.replace(":7667", f":{PORT}").removeprefix("sudo ")
    return re.sub(r"\bLOG\b", str(BENCHMARK), text)


def reason_not_to_run(command):
    for begin, reason in UNRUN.items():
        if command.text.startswith(begin):
            return reason
    if command.text.startswith("parallel ") and not shutil.which("parallel"):
        return "there is no GNU parallel"
    if re.search(r"\bLOG\b", command.text) and not BENCHMARK.with_suffix(".relations").exists():
        return f"there is no {BENCHMARK}.clf.gz: CRSM_DATA says where the benchmark logs are"
    return None


def run_one_by_one(shell, block):
    for command in block:
        process = shell.start(prepare(command))
        if " live " not in command.text:
            shell.finish(process, BEFORE_INTERRUPT_S if command.is_interrupted else None)
            continue
        time.sleep(BEFORE_INTERRUPT_S)
        laser = shell.start("build/bin/laser_publisher sim:demo --rate 10")
        shell.finish(process, LIVE_S)
        shell.finish(laser, 0)


def run_together(shell, block):
    """Commands of several shells: all are started; the publisher ends by itself, and then the others are ended."""
    texts = [part.strip() for command in block for part in prepare(command).split(" & ")]
    publisher, *others = [shell.start(text) for text in texts]
    shell.finish(publisher)
    for process in reversed(others):  # the exporter first: it asks the owner of the map
        shell.finish(process, 0)


def run(shell, block):
    for command in block:
        print(f"README.md:{command.line}: {command.text}", flush=True)
    runnable = [command for command in block if not reason_not_to_run(command)]
    for command in block:
        if command not in runnable:
            print(f"  skipped: {reason_not_to_run(command)}")
    if runnable and runnable[0].text.startswith("export "):
        shell.export(prepare(runnable[0]))
        run_together(shell, runnable[1:])
    else:
        run_one_by_one(shell, runnable)


def make_clone(folder):
    """The files as they are here, also what is not committed yet; nothing that was built."""
    subprocess.run(["git", "clone", "--quiet", PROJECT, folder], check=True)
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=PROJECT,
                            check=True, stdout=subprocess.PIPE, text=True).stdout
    for name in listed.split("\0")[:-1]:
        here, there = PROJECT / name, folder / name
        if here.exists():
            there.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(here, there)
        else:
            there.unlink(missing_ok=True)


def main():
    if len(sys.argv) > 1:
        print(__doc__.strip())
        return 0 if sys.argv[1] == "--help" else 2
    with tempfile.TemporaryDirectory(prefix="crsm_readme_") as folder:
        clone = pathlib.Path(folder) / "clone"
        make_clone(clone)
        shell = Shell(clone)
        try:
            for block in blocks_of((clone / "README.md").read_text()):
                run(shell, block)
        except Failed as failure:
            print(failure)
            return 1
        finally:
            shell.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
