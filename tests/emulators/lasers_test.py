"""laser_publisher with emulated lasers, each with all that can go wrong with it: every scan that the laser has sent,
and that was not damaged on the way, comes, with its ranges, and nothing that it has not sent.

usage: lasers_test.py BIN [PART]    BIN: the folder of the programs; PART: of the names of the tests that are to run
"""

import concurrent.futures
import itertools
import os
import pathlib
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from emulator import made_up_scans  # noqa: E402
from hokuyo import Hokuyo  # noqa: E402
from laser_listener import GROUP, LaserListener, compare  # noqa: E402
from ports import PtyPort, TcpPort  # noqa: E402
from rplidar import Rplidar  # noqa: E402
from sick import Sick  # noqa: E402

BIN = pathlib.Path("build/bin")
PATIENCE_S = 60  # many times what the slowest machine takes
bus_numbers = itertools.count()


def await_condition(condition, what):
    give_up = time.monotonic() + PATIENCE_S
    while not condition():
        if time.monotonic() > give_up:
            raise AssertionError(f"nothing came of it within {PATIENCE_S} s: {what}")
        time.sleep(0.005)


def bus_url():
    """A bus that no other test has, and its port, below those that the system gives to any program."""
    port = 8000 + (os.getpid() * 32 + next(bus_numbers)) % 12000
    return f"udpm://{GROUP}:{port}?ttl=0", port


def flip(at):
    """A byte of what is sent comes as another."""
    return lambda data: data[:at] + bytes([data[at] ^ 0x08]) + data[at + 1:]


def cut(at, count):
    """Some bytes are lost."""
    return lambda data: data[:at] + data[at + count:]


class Run:
    """An emulated laser and a laser_publisher that talks to it."""

    # At which angles and ranges a beam may come: half a beam of the driver's grid and the laser's own rounding.
    ERRORS = {"hokuyo": (1e-5, 0.0006), "rplidar": (0.0023, 0.0002), "sick": (2e-4, 0.0006)}

    def __init__(self, test, name, pty=False, plugged=True, baud="", starts=True, **settings):
        self.name = name
        self.folder = tempfile.TemporaryDirectory(prefix="crsm_lasers_")
        test.addCleanup(self.folder.cleanup)
        self.port = PtyPort(pathlib.Path(self.folder.name) / "tty") if pty else TcpPort()
        if name == "rplidar":
            self.emulator = Rplidar(self.port, made_up_scans(120, 360), 12)
        elif name == "hokuyo":
            self.emulator = Hokuyo(self.port, made_up_scans(241, 240), 30, next(made_up_scans(241, 240)))
        else:
            self.emulator = Sick(self.port, made_up_scans(271, 270), 30)
        test.addCleanup(self.emulator.end)
        for key, value in settings.items():
            setattr(self.emulator, key, value)
        if not plugged:
            self.emulator.unplug()
        self.url, bus_port = bus_url()
        self.listener = LaserListener(bus_port)
        test.addCleanup(self.listener.end)
        self.source = f"{name}:{self.port.address}{baud}"
        self.log = pathlib.Path(self.folder.name) / "publisher.log"
        self.publisher = None
        test.addCleanup(self.kill)
        if starts:
            self.start()

    def start(self):
        with open(self.log, "ab") as log:
            self.publisher = subprocess.Popen([BIN / "laser_publisher", self.source, "--lcm-url", self.url], stderr=log)

    def kill(self):
        if self.publisher:
            self.publisher.kill()
            self.publisher.wait()

    def said(self):
        return self.log.read_text()

    def await_said(self, *parts):
        for part in parts:
            await_condition(lambda part=part: part in self.said(), f"'{part}' in: {self.said()}")

    def await_scans(self, count=4):
        """As many more."""
        enough = len(self.listener.scans) + count
        await_condition(lambda: len(self.listener.scans) >= enough, f"scans; it said {self.said()}")

    def await_damaged(self):
        await_condition(lambda: not self.emulator.damages and not self.emulator.noise, "damage")

    def conclude(self, test, may_miss=0):
        """Ends the publisher; all that was sent has come. Returns what the publisher has said."""
        self.await_scans()
        self.emulator.hold()
        errors = self.ERRORS[self.name]
        if self.name == "rplidar":  # a turn ends with the first sample of the next
            self.emulator.forget(1)

        def missing():
            return compare(self.emulator.sent, self.emulator.maybe, list(self.listener.scans), *errors)[0]

        give_up = time.monotonic() + 20
        while missing() > may_miss and time.monotonic() < give_up:
            time.sleep(0.1)
        lost, made_up = compare(self.emulator.sent, self.emulator.maybe, list(self.listener.scans), *errors)
        test.assertLessEqual(lost, may_miss, f"of {len(self.emulator.sent)}: {self.said()}")
        test.assertEqual(made_up, 0, self.said())
        utimes = [scan.utime for scan in self.listener.scans]
        test.assertEqual(utimes, sorted(set(utimes)))
        self.publisher.send_signal(signal.SIGINT)
        test.assertEqual(self.publisher.wait(PATIENCE_S), 0)
        return self.said()


class LasersTest(unittest.TestCase):
    def test_every_scan_of_a_laser_comes_over_tcp_and_a_serial_port_also_when_its_clock_wraps(self):
        for name, pty, what in (("hokuyo", False, ": URG-04LX"),
                                ("hokuyo", True, "241 beams over 240 deg, 0.02 to 30.00 m, 30 scans a second"),
                                ("rplidar", True, "series 2, firmware 1.29: 360 deg, 1969 beams a second"),
                                ("sick", False, ": LMS10x_FieldEval")):
            with self.subTest(name, pty=pty):
                run = Run(self, name, pty)
                run.await_scans(60 if name != "rplidar" else 12)  # two seconds: clocks wrap after 1.5 s
                said = run.conclude(self)
                self.assertIn(what, said)
                self.assertNotIn("bad_", said)
                await_condition(lambda run=run: not run.emulator.streaming, "the laser's rest")

    def test_damaged_scans_are_left_out_and_counted_and_no_other(self):
        damages = {"hokuyo": [flip(40), cut(100, 3), flip(5), cut(-2, 1), lambda data: b"", flip(300), cut(20, 700),
                               lambda data: b"\0" * len(data)],
                   "rplidar": [cut(100, 3), lambda data: data[:200] + b"\0" + data[201:], cut(50, 7),
                               cut(301, 1)],
                   "sick": [cut(150, 300), lambda data: data[:150] + b"x" + data[151:],
                            lambda data: data[:200], lambda data: data[1:]]}
        counted = {"hokuyo": ["bad_checksum"], "rplidar": ["bad_turn"], "sick": ["bad_scan", "skipped"]}
        for name, several in damages.items():
            with self.subTest(name):
                run = Run(self, name, pty=name == "rplidar")
                run.await_scans()
                for damage in several:
                    run.emulator.damage_next(damage)
                    run.await_damaged()
                    run.await_scans(2)
                said = run.conclude(self)
                for count in counted[name]:
                    self.assertIn(count, said)

    def test_noise_between_scans_costs_none_of_them(self):
        for name, noise in (("hokuyo", b"\xff\x00garbage\n\nMD\n\n"), ("sick", b"\xff\x00garbage")):
            with self.subTest(name):
                run = Run(self, name, noise=noise)
                run.await_scans()
                run.emulator.noise = noise
                run.await_damaged()
                self.assertIn("garbage", run.conclude(self))

    def test_a_laser_that_a_killed_process_has_left_scanning_is_taken_over(self):
        for name, pty in (("hokuyo", False), ("hokuyo", True), ("rplidar", True), ("sick", False)):
            with self.subTest(name, pty=pty):
                run = Run(self, name, pty)
                run.await_scans()
                with run.emulator.lock:
                    run.kill()
                    run.emulator.forget(8)
                self.assertTrue(run.emulator.streaming)
                time.sleep(0.3)
                run.start()
                # Ready and a first scan, twice: what was sent before went out while nobody was there, maybe.
                await_condition(lambda run=run: run.said().count("\n") >= 4, run.said())
                run.emulator.forget(len(run.emulator.sent))
                # A terminal keeps what nobody has read: now and then a scan that is written meanwhile does not get through.
                run.conclude(self, may_miss=1 if pty else 0)

    def test_unplugged_and_plugged_in_again_it_is_said_and_goes_on(self):
        for name, pty, said in (("hokuyo", False, "refuses port"), ("hokuyo", True, "there is no /"),
                                ("rplidar", True, "there is no /"), ("sick", False, "refuses port")):
            with self.subTest(name, pty=pty):
                run = Run(self, name, pty)
                run.await_scans()
                run.emulator.unplug()
                run.await_said(said)
                run.emulator.plug()
                run.await_scans()
                self.assertIn("connection_lost: 1", run.conclude(self))

    def test_a_laser_that_is_not_there_yet_is_waited_for(self):
        for name, pty in (("hokuyo", True), ("sick", False)):
            with self.subTest(name):
                run = Run(self, name, pty, plugged=False)
                run.await_said("trying again until it answers")
                run.emulator.plug()
                run.conclude(self)

    def test_a_laser_that_falls_silent_is_said_and_goes_on(self):
        for name, pty in (("hokuyo", False), ("rplidar", True), ("sick", False)):
            with self.subTest(name):
                run = Run(self, name, pty)
                run.await_scans()
                run.emulator.fall_silent()
                run.await_said("has become silent", "is silent")
                run.emulator.silent = False
                self.assertIn("connection_lost: 1", run.conclude(self))

    def test_baud_rates_are_found_or_what_is_wrong_with_the_given_one_is_said(self):
        for name, baud in (("rplidar", 256000), ("hokuyo", 19200)):
            with self.subTest(name):
                run = Run(self, name, pty=True, plugged=False)
                run.emulator.baud = baud
                run.emulator.plug()
                run.conclude(self)
        run = Run(self, "rplidar", pty=True, baud=":9600")
        run.await_said("sends bytes that no RPLidar sends: is its baud rate right")
        run = Run(self, "hokuyo", pty=True, baud=":9600")
        run.await_said("sends bytes that no Hokuyo sends: is its baud rate right")

    def test_faults_that_a_laser_reports_are_said_with_their_mend(self):
        run = Run(self, "hokuyo", status="01")
        run.await_said("cannot switch its beam on", "switch its power off")
        run.emulator.status = "00"
        run.await_scans()
        run.emulator.scan_status = "21"
        run.await_said("pauses to check itself for a fault, status 21")
        run.await_scans()
        run.emulator.scan_status = "71"
        run.await_said("reports a hardware fault, status 71")
        self.assertIn("error_status: 2", run.conclude(self))

        run = Run(self, "rplidar", pty=True, health=(2, 0x8001))
        run.await_said("has stopped after a fault, error code 32769")
        run.emulator.health = (1, 7)
        run.await_said("warns of a coming fault, error code 7")
        run.conclude(self)
        run = Run(self, "rplidar", pty=True, motor_turns=False)
        run.await_said("its motor does not turn: is the motor's power plugged in")

        run = Run(self, "sick", contamination=1)
        run.await_said("its window gets dirty: clean it")
        run.conclude(self)
        run = Run(self, "sick", state=2)
        run.await_said("reports an internal error")
        run.emulator.state = 1
        run.await_scans()
        run.emulator.status = 2
        run.await_said("its window gets dirty: clean it")
        run.await_scans()
        with run.emulator.lock:
            before = len(run.emulator.sent)
            run.emulator.status = 4
        run.await_said("its window is so dirty that its scans are left out")
        with run.emulator.lock:
            run.emulator.status = 0
            del run.emulator.sent[before:]  # which were not to be trusted
        self.assertIn("error_status: ", run.conclude(self))

    def test_run_stack_maps_what_a_laser_sees_and_deskews_it_by_what_the_laser_says_of_its_turns(self):
        run = Run(self, "hokuyo", starts=False)
        out = pathlib.Path(run.folder.name) / "map"
        with open(run.log, "ab") as log:
            run.publisher = subprocess.Popen([BIN / "run_stack", run.source, "--out", out, "--lcm-url", run.url],
                                             stdout=log, stderr=log)
        run.await_scans()
        run.await_said("run_stack: mapping; Ctrl-C ends")
        run.publisher.send_signal(signal.SIGINT)
        self.assertEqual(run.publisher.wait(PATIENCE_S), 0, run.said())
        self.assertTrue((out / "map.png").exists())
        # 240 deg of a turn of 1/30 s
        self.assertIn('"sweep_s": 0.022', (out / "summary.json").read_text())
        done = subprocess.run([BIN / "run_stack", run.source, "--out", out, "--rate", "2"], capture_output=True,
                              text=True, timeout=PATIENCE_S)
        self.assertEqual(done.returncode, 2)
        self.assertIn("--rate: applies to logs only", done.stderr)

    def test_what_is_no_laser_is_refused_in_a_line(self):
        for source, said in (("hokuyo:ttyACM0", "is neither hokuyo:/dev/NAME nor hokuyo:tcp://HOST:PORT"),
                             ("sick:/dev/ttyUSB0", "a serial port of this laser is not supported"),
                             ("sick:tcp://:2111", "is not sick:tcp://HOST:PORT"),
                             ("hokuyo:tcp://somewhere:x", "is not hokuyo:tcp://HOST:PORT"),
                             ("rplidar:/dev/ttyUSB0:7", "its baud rate is not from 50 to 4000000")):
            done = subprocess.run([BIN / "laser_publisher", source], capture_output=True, text=True, timeout=PATIENCE_S)
            self.assertEqual(done.returncode, 2)
            self.assertEqual(done.stderr.count("\n"), 1)
            self.assertIn(said, done.stderr)
        done = subprocess.run([BIN / "laser_publisher", "sick:tcp://127.0.0.1", "--rate", "max"], capture_output=True,
                              text=True, timeout=PATIENCE_S)
        self.assertEqual(done.returncode, 2)
        self.assertIn("--rate: applies to logs only", done.stderr)

    def test_a_port_that_is_taken_or_not_permitted_is_said(self):
        run = Run(self, "hokuyo", pty=True)
        run.await_scans()

        def line_of(*command):
            other = subprocess.Popen([*command, BIN / "laser_publisher", run.source, "--lcm-url", run.url,
                                      "--channel-prefix", "other/"], stderr=subprocess.PIPE, text=True)
            said = "".join(other.stderr.readline() for _ in range(2))
            other.kill()
            other.communicate()
            return said

        self.assertIn("is in use by another program", line_of())
        if os.geteuid() == 0 and shutil.which("setpriv"):
            os.chmod(run.port.path, 0)
            self.assertIn("sudo usermod -aG", line_of("setpriv", "--bounding-set=-dac_override,-dac_read_search"))
        run.conclude(self)

    def test_a_host_that_takes_the_connection_and_ends_it_ends_no_process(self):
        server = socket.create_server(("127.0.0.1", 0))
        server.settimeout(PATIENCE_S)
        self.addCleanup(server.close)
        for name in ("hokuyo", "sick"):
            with self.subTest(name):
                address = f"{name}:tcp://127.0.0.1:{server.getsockname()[1]}"
                publisher = subprocess.Popen([BIN / "laser_publisher", address,
                                              "--lcm-url", bus_url()[0]], stderr=subprocess.PIPE, text=True)
                self.addCleanup(publisher.kill)
                for _ in range(3):
                    client = server.accept()[0]
                    client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # at once
                    client.close()
                publisher.send_signal(signal.SIGINT)
                said = publisher.communicate(timeout=PATIENCE_S)[1]
                self.assertEqual(publisher.returncode, 0)
                # By when the end comes: while the publisher still connects, or after.
                self.assertRegex(said, "has ended the connection|Connection reset by peer")

    def test_ports_that_cannot_be_used_are_said_with_their_mend(self):
        for source, said in (("hokuyo:/dev/null", "/dev/null cannot be set to 115200 baud: is it a serial port?"),
                             ("hokuyo:tcp://no-such-host.invalid", "there is no host no-such-host.invalid")):
            publisher = subprocess.Popen([BIN / "laser_publisher", source], stderr=subprocess.PIPE, text=True)
            self.addCleanup(publisher.kill)
            lines = [publisher.stderr.readline() for _ in range(2)]
            self.assertIn(said, "".join(lines))
            publisher.send_signal(signal.SIGINT)
            publisher.communicate(timeout=PATIENCE_S)
            self.assertEqual(publisher.returncode, 0)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        BIN = pathlib.Path(sys.argv.pop(1))
    wanted = sys.argv[1] if len(sys.argv) > 1 else ""
    tests = [test for test in unittest.defaultTestLoader.loadTestsFromTestCase(LasersTest) if wanted in test.id()]

    def run(test):
        result = unittest.TestResult()
        test.run(result)
        return result

    # All at once: most of what they take is waiting.
    with concurrent.futures.ThreadPoolExecutor(max_workers=max(1, len(tests))) as pool:
        results = list(pool.map(run, tests))
    failures = [failure for result in results for failure in result.failures + result.errors]
    for test, trace in failures:
        print(f"FAILED {test}\n{trace}")
    print(f"{len(tests)} tests, {len(failures)} failures")
    sys.exit(1 if failures or not tests else 0)
