#!/usr/bin/env python3
"""lcm-spy's views: what they read, the map that they hold, what they draw.

usage: tests/spy/spy_test.py [--out DIR]
Skipped, with exit code 77, where Java, LCM's Java or Xvfb is not there: scripts/setup --spy --xvfb installs them.
"""

import contextlib
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import threading
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from programs import PROJECT, Program, Skipped, await_condition, bus_url, check, child, run, summary

LIBRARIES = [pathlib.Path("/usr/share/java") / name for name in ("lcm.jar", "jchart2d.jar")]
LOSS = 0.3  # of the messages that the replica hears and sends
MEMORY = "-Xmx128m"  # as upstream's lcm-spy


class Java:
    """The jar that lcm-spy loads, and the tests' own classes."""

    def __init__(self, folder):
        jar = subprocess.run([PROJECT / "scripts/spy", "--jar"], check=True, capture_output=True, text=True)
        self.jar = jar.stdout.strip()
        path = [*map(str, LIBRARIES), self.jar]
        subprocess.run(["javac", "--release", "11", "-encoding", "UTF-8", "-cp", ":".join(path), "-d", folder,
                        *HERE.glob("*.java")], check=True, capture_output=True, text=True)
        self.command = ["java", MEMORY, "-Djava.awt.headless=true", "-cp", ":".join([*path, str(folder)])]

    def run(self, name, *arguments):
        done = subprocess.run([*self.command, f"crsm.spy.{name}", *map(str, arguments)], capture_output=True, text=True)
        check(done.returncode == 0, f"{name} failed:\n{done.stdout}{done.stderr}")
        return done.stdout


class Answerer:
    """A program of ours in Java that answers lines, on a bus."""

    def __init__(self, java, url, name, *arguments, display=None):
        screen = {} if display is None else {"DISPLAY": display}
        command = [word for word in java.command if display is None or "headless" not in word]
        self.popen = subprocess.Popen([*command, f"crsm.spy.{name}", *arguments], stdin=subprocess.PIPE,
                                      stdout=subprocess.PIPE, text=True,
                                      env={**os.environ, **screen, "LCM_DEFAULT_URL": url})

    def ask(self, line):
        self.popen.stdin.write(line + "\n")
        self.popen.stdin.flush()
        patience = threading.Timer(60, self.popen.kill)
        patience.start()
        answer = self.popen.stdout.readline().split()
        patience.cancel()
        check(answer, f"nothing was answered to '{line}' within 60 s")
        return answer

    def end(self):
        self.popen.stdin.close()
        check(self.popen.wait(30) == 0, "it did not end well")


def start(source, out, url, flags, sign):
    """A stack that has said `sign`, a regular expression."""
    stack = Program([PROJECT / "scripts/run_stack", source, "--out", out, "--lcm-url", url, *flags], out / "stack.log")
    await_condition(lambda: re.search(sign, stack.errors()) or stack.popen.poll() is not None, 60)
    check(stack.popen.poll() is None, f"run_stack ended: {stack.errors()[-500:]}")
    return stack


def drive(out, url, world, rate, flags, kill=False):
    """A live stack that has heard a whole drive. With `kill`, its map's owner dies on the way."""
    stack = start("live", out, url, flags, "run_stack: listening")
    publisher = Program(["laser_publisher", world, "--rate", rate, "--lcm-url", url, *flags], out / "publisher.log")
    publisher.await_ready()
    if kill:
        time.sleep(4)
        owner = child(stack.pid, "map_updater")
        check(owner, "there is no map_updater to kill")
        os.kill(owner, signal.SIGKILL)
    check(publisher.wait(180) == 0, "the publisher failed")
    return stack


def test_replica(case, java):
    """Through loops, the death of the map's owner, and a second run on the same bus with another map."""
    url = bus_url()
    followed = Answerer(java, url, "FollowedMap", str(LOSS))
    epochs = set()
    for world, rate, flags, kill in [("sim:block", 8, ["--preset", "sick"], False), ("sim:corridor", 10, [], True)]:
        out = case.folder(world.replace(":", "_"))
        stack = drive(out, url, world, rate, flags, kill)
        epoch, version, malformed = followed.ask("settle")
        check(stack.interrupt() == 0, f"run_stack failed: {stack.errors()[-500:]}")
        num_other, _, num_explored, longer_m = followed.ask(f"compare {out}")
        loops = summary(out)["loops"]["closed"]
        case.say(f"{world}: version {version}, {loops} loops, {num_other} of {num_explored} explored cells differ from "
                 f"map.png, the path by {float(longer_m):.4f} m")
        check(kill or loops > 0, "no loop was closed: the test does not show that one is followed")
        check(int(num_explored) > 10000, "the map is too small to tell")
        check(num_other == "0", f"{num_other} cells are not those of map.png: {out / 'held.png'}")
        check(abs(float(longer_m)) < 0.01, f"the path differs by {longer_m} m")  # trajectory.tum is rounded
        check(malformed == "0", f"{malformed} malformed messages")
        epochs.add(epoch)
    check(len(epochs) == 2, "both maps have one epoch")
    followed.end()


def test_picture(case, java, name, picture, command, environment):
    """A screenshot with the views open: no message is undecodable, and what a map view draws is there."""
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, **environment}, timeout=120)
    check(done.returncode == 0, f"{name} failed:\n{done.stdout}{done.stderr}")
    # lcm-spy's own table, which another thread fills while it is drawn, throws now and then. The next drawing mends it.
    thrown = re.findall(r"^\S*(?: in thread .*|Exception\b.*)\n(?:[ \t]+at .*\n?|Caused by.*\n?)+", done.stderr, re.M)
    ours = [trace for trace in thrown if "at crsm." in trace]
    check(not ours, f"{name}: {ours}")
    counts = dict(line.split() for line in java.run("CountColours", picture).splitlines())
    case.say(f"{name}: pixels of each colour: {counts}")
    for colour, least in [("path", 100), ("start", 50), ("ray_on_wall", 200), ("laser", 100), ("unexplored", 50000),
                          ("free", 20000), ("occupied", 500)]:
        check(int(counts[colour]) >= least, f"{name}: {counts[colour]} pixels of the colour of {colour}: {picture}")


@contextlib.contextmanager
def screen():
    """A screen without a screen: its DISPLAY."""
    with subprocess.Popen(["Xvfb", "-displayfd", "1", "-screen", "0", "1280x1024x24", "-nolisten", "tcp"],
                          stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as xvfb:
        try:
            yield ":" + xvfb.stdout.readline().strip()
        finally:
            xvfb.terminate()


def test_views(case, java):
    """lcm-spy with its views opened by double-clicks: as scripts/spy starts it, and as upstream's script, which has
    nothing but CLASSPATH to find the jar by."""
    url = bus_url()
    out = case.folder("views")
    stack = start("sim:demo", out, url, ["--rate", "4"], r"laser_publisher: +[1-9]\d %")
    picture = out / "spy.png"
    test_picture(case, java, "scripts/spy", picture,
                 [PROJECT / "scripts/spy", "--lcm-url", url, "--screenshot", picture], {})
    alone = case.folder("alone")  # what takes the picture, without types and views
    subprocess.run(["jar", "xf", java.jar, "crsm/spy/SpyScreenshot.class"], cwd=alone, check=True)
    picture = out / "classpath.png"
    with screen() as display:
        test_picture(case, java, "CLASSPATH", picture,
                     ["java", "-Djava.net.preferIPv4Stack=true", MEMORY, "-cp",
                      ":".join([*map(str, LIBRARIES), str(alone)]), "crsm.spy.SpyScreenshot", picture, "5"],
                     {"CLASSPATH": java.jar, "DISPLAY": display, "LCM_DEFAULT_URL": url})
    stack.interrupt()


def test_robots(case, java):
    """Two robots on one bus: a double-click on a channel of each opens the view of that one."""
    url = bus_url()
    worlds = {"robot1/": "sim:demo", "robot2/": "sim:corridor"}
    stacks = {}
    with screen() as display:
        spy = Answerer(java, url, "OpenedViews", display=display)
        for prefix, world in worlds.items():
            out = case.folder(prefix.strip("/"))
            stacks[prefix] = out, drive(out, url, world, 20, ["--channel-prefix", prefix])
            title = " ".join(spy.ask(f"open {prefix}MAP_DELTA"))
            check(title == f"Map view of {prefix}", f"the view of {prefix} is called '{title}'")
        for prefix in worlds:
            spy.ask(f"settle {prefix}MAP_DELTA")
        for prefix, (out, stack) in stacks.items():
            check(stack.interrupt() == 0, f"run_stack failed: {stack.errors()[-500:]}")
            num_other, _, num_explored, longer_m = spy.ask(f"compare {prefix}MAP_DELTA {out}")
            case.say(f"{prefix}: {num_other} of {num_explored} explored cells differ from map.png, the path by "
                     f"{float(longer_m):.4f} m")
            check(int(num_explored) > 10000, "the map is too small to tell")
            check(num_other == "0", f"{num_other} cells are not those of map.png: {out / 'held.png'}")
            check(abs(float(longer_m)) < 0.01, f"the path differs by {longer_m} m")  # trajectory.tum is rounded
        spy.end()


def test(case):
    missing = [name for name in ("java", "javac", "jar", "lcm-gen", "Xvfb") if not shutil.which(name)]
    missing += [str(library) for library in LIBRARIES if not library.exists()]
    if missing:
        raise Skipped(f"there is no {', '.join(missing)}: scripts/setup --spy --xvfb installs them")
    java = Java(case.folder("classes"))
    sentences = java.run("Tests")
    case.say(f"{sentences.count('ok')} tests of what is read, held and painted")
    test_replica(case, java)
    test_views(case, java)
    test_robots(case, java)


run(test)
