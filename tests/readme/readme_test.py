#!/usr/bin/env python3
"""Runs every command of the README, in its order, in a clean clone, as somebody would who has just come.

usage: tests/readme/readme_test.py
A command that is to be interrupted (its comment says Ctrl-C, or it maps live) is, after some seconds, and has to end as
well as the others. What cannot be run in a test is named in UNRUN, with the reason. CRSM_DATA names the folder of the
benchmark logs; where there is none, what is said of them is left out, and that is said.
"""

import contextlib
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from blocks import commands_of

PROJECT = pathlib.Path(__file__).resolve().parents[2]
DATA = pathlib.Path(os.environ.get("CRSM_DATA", PROJECT.parent / "shared" / "data"))
PORT = 7000 + os.getpid() % 600  # of a bus of our own
TIME_LIMIT_S = 900  # the first command builds
BEFORE_INTERRUPT_S = 1.0
LIVE_S = 8.0

UNRUN = {  # by how a command begins
    "scripts/test": "it is what runs this",
    "scripts/spy": "needs a screen",
    "sudo systemctl": "needs systemd as the first process; tests/service/systemd_test.cpp reads the units",
    "ip route add 224.0.0.0/4 dev eth0": "needs another host; scripts/fault hosts has three",
    "sysctl": "is of the whole machine",
}


class Failed(Exception):
    pass


class Tour:
    def __init__(self, clone, installed):
        self.clone = clone
        self.installed = installed
        self.background = []  # names and processes
        self.environment = {**os.environ, "LCM_DEFAULT_URL": f"udpm://239.255.76.67:{PORT}?ttl=0",
                            "DESTDIR": str(installed)}

    def start(self, text):
        return subprocess.Popen(["bash", "-c", f"exec {text}"], cwd=self.clone, env=self.environment,
                                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                start_new_session=True)

    def run(self, command):
        text = command.text.replace(":7667", f":{PORT}").removeprefix("sudo ")
        if "LOG" in text.split():
            text = text.replace("LOG", str(DATA / "radish" / "fr079.clf.gz"), 1).replace(
                "LOG.relations", str(DATA / "radish" / "fr079.relations"))
        if text.startswith("export "):
            name, value = text.removeprefix("export ").split("=", 1)
            self.environment[name] = value.strip('"')
        elif self.environment["LCM_DEFAULT_URL"].endswith("ttl=1") and "build/bin/" in text and command.on_hosts:
            self.background += [(part.strip(), self.start(part.strip())) for part in text.split(" & ")]
        else:
            self.finish(text, self.start(text), command)

    def finish(self, text, process, command):
        feed = None
        if command.ends_by_interrupt:
            time.sleep(BEFORE_INTERRUPT_S)
            if " live " in text:
                feed = self.start("build/bin/laser_publisher sim:demo --rate 20")
                time.sleep(LIVE_S)
            process.send_signal(signal.SIGINT)
        self.check_end(text, process)
        if feed:
            feed.send_signal(signal.SIGINT)
            self.check_end("laser_publisher", feed)

    def check_end(self, text, process):
        try:
            said, _ = process.communicate(timeout=TIME_LIMIT_S)
        except subprocess.TimeoutExpired:
            raise Failed(f"'{text}' did not end within {TIME_LIMIT_S} s") from None
        if process.returncode != 0:
            raise Failed(f"'{text}' ended with exit code {process.returncode}:\n{said}")
        folder = out_folder(text)
        for name in ("map.png", "trajectory.tum", "overview.png", "summary.json") if folder else ():
            path = self.clone / folder / name
            if not path.is_file() or path.stat().st_size == 0:
                raise Failed(f"'{text}' left no {folder}/{name}:\n{said}")

    def close(self):
        for _, process in self.background:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
