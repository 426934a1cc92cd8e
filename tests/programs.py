"""What tests in Python share: programs that run, and what becomes of a test."""

import argparse
import contextlib
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time

PROJECT = pathlib.Path(__file__).resolve().parents[1]
BIN = pathlib.Path(os.environ.get("CRSM_BIN_DIR", PROJECT / "build/bin"))
GROUP = "239.255.76.67"
SKIPPED = 77  # exit code


class Failure(Exception):
    """What is wrong, with the numbers."""


class Skipped(Exception):
    """Why the test cannot run here."""


def check(condition, text):
    if not condition:
        raise Failure(text)


class Case:
    """One run of a test: where its files go."""

    def __init__(self, out):
        self.out = out

    def say(self, text):
        print(f"  {text}", flush=True)

    def folder(self, name):
        folder = self.out / name
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        return folder


def run(test):
    """The main function of a test."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--out", type=pathlib.Path)
    arguments = parser.parse_args()
    with contextlib.ExitStack() as stack:
        out = arguments.out or pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="crsm_test_")))
        out.mkdir(parents=True, exist_ok=True)
        name = pathlib.Path(sys.argv[0]).stem
        begin = time.monotonic()
        try:
            test(Case(out.resolve()))
            print(f"PASS {name}, {time.monotonic() - begin:.0f} s")
        except Skipped as reason:
            print(f"skipped: {reason}")
            sys.exit(SKIPPED)
        except Failure as reason:
            print(f"FAIL {name}: {reason}")
            sys.exit(1)
        except subprocess.CalledProcessError as error:
            print(f"FAIL {name}: {error} {error.stderr or ''}")
            sys.exit(1)


class Program:
    """A program that runs, and dies with this process. Its stderr goes to a file."""

    def __init__(self, command, log, environment=None):
        command = [str(part) for part in command]
        if "/" not in command[0]:
            command[0] = str(BIN / command[0])
        self.name = pathlib.Path(command[0]).name
        self.log = log
        with open(log, "wb") as stderr:
            self.popen = subprocess.Popen(
                ["setpriv", "--pdeathsig", "TERM", *command], stdin=subprocess.DEVNULL,
                stdout=stderr, stderr=stderr, env={**os.environ, "CRSM_BIN_DIR": str(BIN), **(environment or {})})
        self.pid = self.popen.pid

    def errors(self):
        return self.log.read_text(errors="replace")

    def await_ready(self):
        await_condition(lambda: f"{self.name}: ready" in self.errors() or self.popen.poll() is not None, 30)
        check(self.popen.poll() is None, f"{self.name} ended: {self.errors()[-500:]}")

    def interrupt(self):
        self.popen.send_signal(signal.SIGINT)
        return self.wait()

    def wait(self, timeout_s=1800):
        try:
            return self.popen.wait(timeout_s)
        except subprocess.TimeoutExpired:
            self.popen.kill()
            raise Failure(f"{self.name} did not end within {timeout_s} s") from None


def await_condition(condition, timeout_s, period_s=0.005):
    give_up = time.monotonic() + timeout_s
    while not condition():
        check(time.monotonic() < give_up, f"nothing came of it within {timeout_s} s")
        time.sleep(period_s)


def child(parent, name):
    """Process id of the living child with this name; None if there is none."""
    with contextlib.suppress(OSError):
        for pid in pathlib.Path(f"/proc/{parent}/task/{parent}/children").read_text().split():
            with contextlib.suppress(OSError):
                comm, rest = pathlib.Path(f"/proc/{pid}/stat").read_text().partition("(")[2].rsplit(") ", 1)
                if comm == name[:15] and not rest.startswith("Z"):
                    return int(pid)
    return None


def bus_url(ttl=0):
    """A bus of this process's own: LCM tells them apart by their port."""
    bus_url.number += 1
    return f"udpm://{GROUP}:{21000 + (os.getpid() * 16 + bus_url.number) % 11000}?ttl={ttl}"


bus_url.number = 0


def run_offline(log, out, flags):
    """Maps a log in one process."""
    subprocess.run([BIN / "slam_offline", log, "--out", out, *flags], check=True, capture_output=True, text=True)


def summary(out):
    return json.loads((out / "summary.json").read_text())
