#!/usr/bin/env python3
"""The examples of scripts/examples at work: drivers and listeners around a live stack, a ray selector within one, and the
bus in pure Python against itself.

usage: PYTHONPATH=build/python tests/examples/examples_test.py [--out DIR]
"""

import os
import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from programs import BIN, PROJECT, Program, await_condition, bus_url, check, run, run_offline, summary

EXAMPLES = PROJECT / "scripts/examples"
sys.path.insert(0, str(EXAMPLES))
from lcm_bus import LcmBus

PATIENCE_S = 120
CORRIDOR = PROJECT / "logs/corridor.lcm"


def start(name, url, folder, *arguments):
    """An example: NAME.py, or the program of C++."""
    command = [sys.executable, EXAMPLES / name] if name.endswith(".py") else [BIN / f"example_{name}"]
    return Program([*command, *arguments], folder / f"{name}.log", environment={"LCM_DEFAULT_URL": url})


def poses(text):
    return [tuple(map(float, line.split())) for line in re.findall(r"^-?\d\S+ -?\d\S+ -?\d\S+$", text, re.MULTILINE)]


def check_live(case, driver, listener):
    """The laser turns on the spot to the left: so does the pose."""
    folder = case.folder(f"{driver}-{listener}")
    url = bus_url()
    stack = Program([BIN / "run_stack", "live", "--out", folder / "out", "--lcm-url", url], folder / "stack.log")
    await_condition(lambda: "listening" in stack.errors(), PATIENCE_S)
    hearing = start(listener, url, folder)
    laser = start(driver, url, folder)
    heard = folder / f"{listener}.log"
    await_condition(lambda: any(yaw > 0.5 for _, _, yaw in poses(heard.read_text())), PATIENCE_S, 0.1)
    seen = poses(heard.read_text())
    off_m = max(max(abs(x), abs(y)) for x, y, _ in seen)
    check(off_m < 0.05, f"{driver}, {listener}: it turns on the spot, and is {off_m} m off")  # a cell
    for program in (laser, hearing, stack):
        program.interrupt()
    case.say(f"{driver} and {listener}: {len(seen)} poses, at most {off_m:.3f} m off")


def check_help(case):
    """Each says what it does, and sends and listens to nothing; a wrong call is refused, with the usage."""
    environment = {**os.environ, "LCM_DEFAULT_URL": "no bus"}
    examples = [[BIN / "example_driver"], [BIN / "example_listener"],
                *([sys.executable, path] for path in sorted(EXAMPLES.rglob("*.py")) if path.name != "lcm_bus.py")]
    for example in examples:
        name = pathlib.Path(example[-1]).name
        asked = subprocess.run([*example, "--help"], env=environment, capture_output=True, text=True, timeout=20)
        check(asked.returncode == 0 and "usage: " in asked.stdout and not asked.stderr, f"{name} --help: {asked}")
        wrong = subprocess.run([*example, "--nonesuch"], env=environment, capture_output=True, text=True, timeout=20)
        check(wrong.returncode == 2 and "usage: " in wrong.stderr and not wrong.stdout, f"{name} --nonesuch: {wrong}")
    case.say(f"{len(examples)} examples have a help")


def read_path(folder):
    lines = [line.split() for line in (folder / "trajectory.tum").read_text().splitlines()]
    return {line[0]: (float(line[1]), float(line[2])) for line in lines}


def check_ray_selector(case):
    """Other rays give another map of the same corridor: no scan is lost, and the path is the same but for its noise."""
    folder = case.folder("ray_selector")
    url = bus_url()
    stack = Program([BIN / "run_stack", CORRIDOR, "--out", folder / "out", "--without", "ray_selector", "--lcm-url", url],
                    folder / "stack.log")
    selector = start("ray_selector.py", url, folder)
    check(stack.wait() == 0, f"the stack failed:\n{stack.errors()}")
    selector.interrupt()
    check("without ray_selector: another process must answer" in stack.errors(), "what is missing is not said")
    run_offline(CORRIDOR, folder / "offline", [])
    found, expected = read_path(folder / "out"), read_path(folder / "offline")
    check(found.keys() == expected.keys(), f"{len(found)} of {len(expected)} scans")
    check(summary(folder / "out")["lost"] == 0, "scans are lost")
    off_m = max(max(abs(a - b) for a, b in zip(found[t], expected[t])) for t in expected)
    check(off_m < 0.15, f"the path is {off_m} m from that with our ray selector")  # three cells, along 100 s of corridor
    check((folder / "out/map.png").read_bytes() != (folder / "offline/map.png").read_bytes(), "our own selector was there")
    case.say(f"ray_selector.py: {len(found)} scans, the path is {off_m:.3f} m from that with ours at most")


class Text:
    """A message of any size."""

    def __init__(self, content):
        self.content = content

    def encode(self):
        return self.content

    @classmethod
    def decode(cls, content):
        if content.startswith(b"bad"):
            raise ValueError("Decode error")
        return cls(content)


def check_bus(case):
    """Messages of all sizes come whole; what is none is passed over."""
    bus = LcmBus(bus_url())
    heard = []
    bus.subscribe("TEXT", Text, lambda message: heard.append(message.content))
    sizes = [0, 1, 1000, 64_995, 65_000, 65_001, 130_000, 300_000]
    for size in sizes:
        content = os.urandom(size)
        bus.publish("OTHER", Text(content))
        bus.publish("TEXT", Text(b"bad"))
        bus.publish("TEXT", Text(content))
        while bus.handle(0.2) and (not heard or heard[-1] != content):
            pass
        check(heard and heard[-1] == content, f"{size} bytes did not come")
    for garbage in (b"", b"LC", b"LC02", b"LC02aaaa", b"LC02aaaaTEXT", b"LC03" + bytes(20), b"LC03" + b"\xff" * 30):
        bus._out.sendto(garbage, bus._group)
        bus.handle(0.2)
    check(len(heard) == len(sizes), f"{len(heard)} messages, and {len(sizes)} were sent")
    case.say(f"the bus in Python: {len(sizes)} sizes up to {sizes[-1]} bytes")


def test(case):
    check_help(case)
    check_bus(case)
    check_live(case, "driver", "listener.py")
    check_live(case, "driver.py", "listener")
    check_ray_selector(case)


if __name__ == "__main__":
    run(test)
