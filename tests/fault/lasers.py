"""Emulated lasers of each kind in a live stack, without faults and with all of them: no scan is lost that reached us, the
map is the one of the same world's log, and a laser that comes back is heard within two seconds."""

import concurrent.futures
import json
import math
import os
import re
import signal
import struct
import subprocess
import sys
import time

from faults import BIN, PROJECT, Program, await_condition, bus_url, check, child, port_of, read_log, run
from faults import run_offline, write_log

sys.path.insert(0, str(PROJECT / "tests/emulators"))
from emulator import Scan  # noqa: E402
from hokuyo import Hokuyo  # noqa: E402
from laser_listener import LaserListener, Received  # noqa: E402
from ports import PtyPort, TcpPort  # noqa: E402
from rplidar import Rplidar  # noqa: E402
from sick import Sick  # noqa: E402

LONGEST_RETURN_S = 2.0
# Two maps of the same scans, one in real time and in mm, the other as the simulator has them and at leisure, laid on each
# other as a whole: their first poses are those of a robot that drives, whose speed is not known yet. Less than half a cell
# in the median, a cell in the root mean square.
MEDIAN_M, RMSE_M = 0.02, 0.05
RATES_HZ = {"hokuyo": 10, "rplidar": 6.6, "sick": 10}
ANGLE_ERROR_RAD = {"hokuyo": 1e-5, "rplidar": 0.0023, "sick": 2e-4}
RANGE_ERROR_M = 0.0006


class WorldScan(Scan):
    """A scan of a log. message: as it is there."""

    def __init__(self, message):
        scan = Received(message)
        super().__init__(scan.angle_min_rad, scan.angle_step_rad, scan.ranges_m)
        self.message = message


def mirrored(message):
    """The scan in a mirror, with which a laser turns clockwise."""
    first_rad, step_rad = struct.unpack(">ff", message[-8:])
    return message[:-8] + struct.pack(">ff", -first_rad, -step_rad)


def make_world(case, name, seconds):
    """A log of what such a laser sees while its robot drives, the scans swept as it turns. Beams lie on whole steps of
    a Hokuyo with 768 for a turn, and on half degrees of a SICK."""
    laser = {"hokuyo": "laser 240 512 20 10 0.01 sweep_s 0.067", "rplidar": "laser 360 300 12 6.6 0.005 sweep_s 0.15",
             "sick": "laser 270 540 20 10 0.01 sweep_s 0.075"}[name]
    plan = (PROJECT / "common/worlds" / ("arena.world" if name == "rplidar" else "demo.world")).read_text()
    way = re.findall("(?m)^waypoint .*$", plan)
    ways = math.ceil(seconds / (50 if name == "rplidar" else 300))  # each takes a little longer
    world = case.out / f"{name}.world"
    world.write_text("\n".join([re.sub("(?m)^laser .*$", laser, plan)] +
                               [point for number in range(1, ways) for point in way[-2::-1] * (number % 2) +
                                way[1:] * (1 - number % 2)]) + "\n")
    messages = read_log(case.convert(name, f"sim:{world}"))
    if name == "rplidar":  # which starts its turns elsewhere
        messages = [mirrored(message) for message in messages]
    return messages


class LiveRun:
    """A laser, a stack that maps what it sees, and who listens to both."""

    def __init__(self, case, name, title, messages, seconds):
        self.name = name
        self.out = case.folder(f"{name}_{title}")
        self.port = PtyPort(self.out / "tty") if name == "rplidar" else TcpPort()
        self.scans = [WorldScan(message) for message in messages[:int(RATES_HZ[name] * seconds)]]
        feed = iter(self.scans)
        if name == "hokuyo":
            self.laser = Hokuyo(self.port, feed, RATES_HZ[name], self.scans[0])
        else:
            self.laser = (Rplidar if name == "rplidar" else Sick)(self.port, feed, RATES_HZ[name])
        url = bus_url()
        self.listener = LaserListener(port_of(url))
        self.stack = Program([PROJECT / "scripts/run_stack", f"{name}:{self.port.address}", "--out", self.out / "map",
                              "--lcm-url", url, "--range-max-m", "20",
                              *(["--preset", "rplidar-a1"] if name == "rplidar" else [])], self.out / "run_stack.log")
        await_condition(lambda: self.listener.scans or self.stack.popen.poll() is not None, 60)
        check(self.stack.popen.poll() is None, f"run_stack ended: {self.stack.errors()[-800:]}")

    def said(self):
        return self.stack.errors()

    def await_said(self, text):
        await_condition(lambda: text in self.said(), 30)

    def await_scans(self, count):
        enough = len(self.listener.scans) + count
        await_condition(lambda: len(self.listener.scans) >= enough or self.laser.at_end, 30)

    def seconds_to_next_scan(self):
        begin, count = time.monotonic(), len(self.listener.scans)
        await_condition(lambda: len(self.listener.scans) > count, 30)
        return time.monotonic() - begin

    def end(self):
        """When all that the laser sent was mapped."""
        await_condition(lambda: self.laser.at_end, 3600, 0.1)
        time.sleep(3)  # for what is under way
        check(self.stack.interrupt() == 0, f"run_stack failed: {self.said()[-1000:]}")
        self.laser.end()
        self.listener.end()

    def find_received(self):
        """Index in self.scans of each scan that came."""
        indices, at = [], 0
        for received in self.listener.scans:
            found = next((i for i in range(at, len(self.scans)) if received.shows(
                self.scans[i], ANGLE_ERROR_RAD[self.name], RANGE_ERROR_M)), None)
            check(found is not None, f"{self.name}: a scan came that was not sent, number {len(indices)}")
            indices.append(found)
            at = found + 1
        return indices


def compare_maps(live, indices, case):
    """How far the poses lie from those of the world's log, that of the same scans."""
    log = live.out / "world.lcm"
    write_log(log, (live.scans[index].message[:8] + struct.pack(">q", received.utime) + live.scans[index].message[16:]
                    for index, received in zip(indices, live.listener.scans)))
    sweep_s = re.search(r'"sweep_s": ([0-9.]+)', (live.out / "map/summary.json").read_text()).group(1)
    run_offline(log, live.out / "offline", ["--range-max-m", "20", "--sweep-s", sweep_s,
                                            *(["--preset", "rplidar-a1"] if live.name == "rplidar" else [])])
    errors = json.loads(subprocess.run(
        [BIN / "slam_eval", "trajectory", live.out / "map", live.out / "offline/trajectory.tum", "--align", "--json"],
        check=True, capture_output=True, text=True).stdout)
    case.say(f"{live.out.name}: {len(live.listener.scans)} scans came, {errors['poses']} mapped, deskewed by {sweep_s} s; "
             f"from the world's log {errors['median_m']:.3f} m in the median, {errors['rmse_m']:.3f} m root mean square")
    check(errors["poses"] >= 0.98 * len(live.listener.scans), f"{live.name}: only {errors['poses']} scans were mapped")
    check(errors["median_m"] <= MEDIAN_M and errors["rmse_m"] <= RMSE_M, f"{live.name}: another map")


def check_none_is_lost(live, indices):
    came = set(indices)
    sent = {id(scan) for scan in live.laser.sent}
    lost = [i for i, scan in enumerate(live.scans) if id(scan) in sent and i not in came and i >= indices[0]]
    check(not lost, f"{live.name}: {len(lost)} scans that were sent are lost, the first is number {lost[:1]}")


def undisturbed(case, name, messages, seconds):
    live = LiveRun(case, name, "undisturbed", messages, seconds)
    live.end()
    if name == "rplidar":
        live.laser.forget(1)  # no other turn has ended the last
    indices = live.find_received()
    check_none_is_lost(live, indices)
    compare_maps(live, indices, case)


def break_all(case, live):
    """One fault after the other. While a laser is not heard, its robot stands."""
    laser = live.laser
    returns_s = []

    def gone(begin, end, said):
        laser.hold()
        time.sleep(0.3)
        begin()
        live.await_said(said)
        end()
        laser.held = False
        returns_s.append(live.seconds_to_next_scan())
        live.await_scans(5)

    gone(laser.unplug, laser.plug, "there is no /" if live.name == "rplidar" else "refuses port")
    gone(laser.fall_silent, lambda: setattr(laser, "silent", False), "has become silent")
    for damage in (lambda data: data[:60] + data[61:], lambda data: data[:len(data) // 2], lambda data: b"\0" * len(data)):
        laser.damage_next(damage)
        live.await_scans(5)
    if live.name != "rplidar":
        laser.noise = b"\xff\0noise"
        live.await_scans(5)
    if live.name == "hokuyo":
        laser.scan_status = "71"
        live.await_said("hardware fault, status 71")
        live.await_scans(5)
    publisher = child(live.stack.pid, "laser_publisher")
    with laser.lock:
        laser.held = True
    time.sleep(0.3)
    laser.forget(1)
    os.kill(publisher, signal.SIGKILL)
    live.await_said("laser_publisher ended unexpectedly")
    num_before = len(laser.sent)
    laser.held = False
    live.await_scans(5)
    laser.forget(len(laser.sent) - num_before)  # the first went out before the new process had asked for any
    live.await_scans(5)
    case.say(f"{live.name}: scans again {', '.join(f'{s:.2f}' for s in returns_s)} s after the laser was back")
    check(max(returns_s) <= LONGEST_RETURN_S, f"{live.name}: {max(returns_s):.2f} s until scans came again")


def disturbed(case, name, messages, seconds):
    live = LiveRun(case, name, "disturbed", messages, seconds)
    live.await_scans(20)
    while not live.laser.at_end:
        break_all(case, live)
        if not case.long:
            break
        time.sleep(20)
    live.end()
    live.laser.forget(1)
    indices = live.find_received()
    check_none_is_lost(live, indices)
    compare_maps(live, indices, case)


def test(case):
    seconds = 40 if case.quick else 600 if case.long else 90
    worlds = {name: make_world(case, name, seconds) for name in RATES_HZ}
    tasks = [(body, name) for name in worlds for body in (undisturbed, disturbed)]
    # Two at a time: what is live needs its share of a processor.
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for done in [pool.submit(body, case, name, worlds[name], seconds) for body, name in tasks]:
            done.result()


run(test)
