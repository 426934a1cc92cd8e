"""Emulated lasers of each kind in a live stack, without faults and with all of them: no scan is lost that reached us, the
map is the one of the same world's log, and a laser that comes back is heard within two seconds. scripts/fault lasers."""

import concurrent.futures
import contextlib
import json
import math
import os
import pathlib
import re
import signal
import struct
import subprocess
import sys
import tempfile
import time

from emulator import Scan
from hokuyo import Hokuyo
from laser_listener import LaserListener, Received
from lasers_test import await_condition, bus_url
from ports import PtyPort, TcpPort
from rplidar import Rplidar
from sick import Sick

PROJECT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("CRSM_BIN_DIR", PROJECT / "build/bin"))
EFFORT = os.environ.get("CRSM_FAULT_EFFORT")
LONGEST_RETURN_S = 2.0
# Two maps of the same scans, one in real time and in mm, the other as the simulator has them and at leisure, laid on each
# other as a whole: their first poses are those of a robot that drives, whose speed is not known yet. Less than half a cell
# in the median, a cell in the root mean square.
MEDIAN_M, RMSE_M = 0.02, 0.05
RATES_HZ = {"hokuyo": 10, "rplidar": 6.6, "sick": 10}
ANGLE_ERROR_RAD = {"hokuyo": 1e-5, "rplidar": 0.0023, "sick": 2e-4}
RANGE_ERROR_M = 0.0006
LCM_EVENT, LCM_SYNC, LASER = struct.Struct(">IqqII"), 0xEDA1DA01, b"LASER"


def read_log(path):
    """The messages on LASER."""
    data, at, messages = path.read_bytes(), 0, []
    while at < len(data):
        *_, channel_bytes, data_bytes = LCM_EVENT.unpack_from(data, at)
        begin = at + LCM_EVENT.size + channel_bytes
        if data[begin - channel_bytes:begin] == LASER:
            messages.append(data[begin:begin + data_bytes])
        at = begin + data_bytes
    return messages


def write_log(path, utimes, messages):
    with open(path, "wb") as log:
        for utime, message in zip(utimes, messages):
            log.write(LCM_EVENT.pack(LCM_SYNC, 0, utime, len(LASER), len(message)) + LASER)
            log.write(message[:8] + struct.pack(">q", utime) + message[16:])


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


def make_world(folder, name, seconds):
    """A log of what such a laser sees while its robot drives, the scans swept as it turns. Beams lie on whole steps of
    a Hokuyo with 768 for a turn, and on half degrees of a SICK."""
    laser = {"hokuyo": "laser 240 512 20 10 0.01 sweep_s 0.067", "rplidar": "laser 360 300 12 6.6 0.005 sweep_s 0.15",
             "sick": "laser 270 540 20 10 0.01 sweep_s 0.075"}[name]
    plan = (PROJECT / "common/worlds" / ("arena.world" if name == "rplidar" else "demo.world")).read_text()
    way = re.findall("(?m)^waypoint .*$", plan)
    ways = math.ceil(seconds / (50 if name == "rplidar" else 300))  # each takes a little longer
    world, log = folder / f"{name}.world", folder / f"{name}.lcm"
    world.write_text("\n".join([re.sub("(?m)^laser .*$", laser, plan)] +
                               [point for number in range(1, ways) for point in way[-2::-1] * (number % 2) +
                                way[1:] * (1 - number % 2)]) + "\n")
    subprocess.run([BIN / "laser_publisher", f"sim:{world}", "--lcm-url", f"file://{log}?mode=w"], check=True,
                   stderr=subprocess.DEVNULL)
    messages = read_log(log)
    return [mirrored(message) for message in messages] if name == "rplidar" else messages  # it starts turns elsewhere


def child(parent, name):
    """Process id of the child with this name."""
    for pid in pathlib.Path(f"/proc/{parent}/task/{parent}/children").read_text().split():
        if pathlib.Path(f"/proc/{pid}/comm").read_text().strip() == name[:15]:
            return int(pid)
    raise AssertionError(f"there is no {name}")


class LiveRun:
    """A laser, a stack that maps what it sees, and who listens to both."""

    def __init__(self, folder, name, title, messages, seconds):
        self.name, self.title = name, f"{name}_{title}"
        self.out = folder / self.title
        self.out.mkdir()
        self.port = PtyPort(self.out / "tty") if name == "rplidar" else TcpPort()
        self.flags = ["--range-max-m", "20", *(["--preset", "rplidar-a1"] if name == "rplidar" else [])]
        self.scans = [WorldScan(message) for message in messages[:int(RATES_HZ[name] * seconds)]]
        feed = iter(self.scans)
        if name == "hokuyo":
            self.laser = Hokuyo(self.port, feed, RATES_HZ[name], self.scans[0])
        else:
            self.laser = (Rplidar if name == "rplidar" else Sick)(self.port, feed, RATES_HZ[name])
        url, port = bus_url()
        self.listener = LaserListener(port)
        with open(self.out / "run_stack.log", "wb") as log:
            self.stack = subprocess.Popen(
                ["setpriv", "--pdeathsig", "TERM", BIN / "run_stack", f"{name}:{self.port.address}", "--out",
                 self.out / "map", "--lcm-url", url, *self.flags], stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                env={**os.environ, "CRSM_BIN_DIR": str(BIN)})
        self.await_scans(1)

    def said(self):
        return (self.out / "run_stack.log").read_text()

    def await_said(self, text):
        await_condition(lambda: text in self.said(), text)

    def await_scans(self, count):
        enough = len(self.listener.scans) + count
        await_condition(lambda: len(self.listener.scans) >= enough or self.laser.at_end, f"scans; {self.said()[-800:]}")

    def end(self):
        """When all that the laser sent was mapped."""
        while not self.laser.at_end:
            time.sleep(0.1)
        time.sleep(3)  # for what is under way
        self.stack.send_signal(signal.SIGINT)
        assert self.stack.wait(60) == 0, f"run_stack failed: {self.said()[-1000:]}"
        self.laser.end()
        self.listener.end()

    def check(self):
        """That nothing is lost or made up, and the map."""
        indices, at = [], 0
        for received in self.listener.scans:
            found = next((i for i in range(at, len(self.scans)) if received.shows(
                self.scans[i], ANGLE_ERROR_RAD[self.name], RANGE_ERROR_M)), None)
            assert found is not None, f"{self.title}: a scan came that was not sent, number {len(indices)}"
            indices.append(found)
            at = found + 1
        came, sent = set(indices), {id(scan) for scan in self.laser.sent}
        lost = [i for i in range(indices[0], len(self.scans)) if id(self.scans[i]) in sent and i not in came]
        assert not lost, f"{self.title}: {len(lost)} scans that were sent are lost, the first is number {lost[0]}"
        self.check_map(indices)

    def check_map(self, indices):
        """How far the poses lie from those of the world's log, that of the same scans."""
        write_log(self.out / "world.lcm", [received.utime for received in self.listener.scans],
                  [self.scans[index].message for index in indices])
        sweep_s = re.search(r'"sweep_s": ([0-9.]+)', (self.out / "map/summary.json").read_text()).group(1)
        subprocess.run([BIN / "slam_offline", self.out / "world.lcm", "--out", self.out / "offline", *self.flags,
                        "--sweep-s", sweep_s], check=True, capture_output=True)
        errors = json.loads(subprocess.run(
            [BIN / "slam_eval", "trajectory", self.out / "map", self.out / "offline/trajectory.tum", "--align", "--json"],
            check=True, capture_output=True).stdout)
        print(f"  {self.title}: {len(indices)} scans came, {errors['poses']} mapped, deskewed by {sweep_s} s; from the "
              f"world's log {errors['median_m']:.3f} m in the median, {errors['rmse_m']:.3f} m root mean square", flush=True)
        assert errors["poses"] >= 0.98 * len(indices), f"{self.title}: only {errors['poses']} scans were mapped"
        assert errors["median_m"] <= MEDIAN_M and errors["rmse_m"] <= RMSE_M, f"{self.title}: another map"


def break_all(live):
    """One fault after the other. While a laser is not heard, its robot stands."""
    laser = live.laser

    def gone(begin, end, said):
        laser.hold()
        time.sleep(0.3)
        begin()
        live.await_said(said)
        end()
        laser.held = False
        back_s = time.monotonic()
        live.await_scans(1)
        return_s = time.monotonic() - back_s
        print(f"  {live.name}: scans again {return_s:.2f} s after the laser was back", flush=True)
        assert return_s <= LONGEST_RETURN_S, f"{live.name}: {return_s:.2f} s until scans came again"
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


def run(folder, name, messages, seconds, disturbed):
    live = LiveRun(folder, name, "disturbed" if disturbed else "undisturbed", messages, seconds)
    if disturbed:
        live.await_scans(20)
        break_all(live)
        while EFFORT == "long" and not live.laser.at_end:
            time.sleep(20)
            break_all(live)
    live.end()
    if disturbed or name == "rplidar":
        live.laser.forget(1)  # no other turn has ended the last
    live.check()


def main():
    seconds = {"quick": 40, "long": 600}.get(EFFORT, 90)
    keep = os.environ.get("CRSM_KEEP_IN")
    with tempfile.TemporaryDirectory(prefix="crsm_fault_") if not keep else contextlib.nullcontext(keep) as out:
        folder = pathlib.Path(out)
        worlds = {name: make_world(folder, name, seconds) for name in RATES_HZ}
        # Two at a time: what is live needs its share of a processor.
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            for done in [pool.submit(run, folder, name, messages, seconds, disturbed)
                         for name, messages in worlds.items() for disturbed in (False, True)]:
                done.result()


if __name__ == "__main__":
    sys.exit(main())
