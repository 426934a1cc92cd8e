#!/usr/bin/env python3
"""The Python package at work: the same map as slam_offline's, arrays in and out, saved and loaded, wrong calls.

usage: PYTHONPATH=build/python CRSM_BIN_DIR=build/bin tests/python/python_test.py
Skipped (exit code 77) where the package was not built, or numpy is not there.
"""
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import time
import unittest

try:
    import numpy as np

    import crsm_slam
except ImportError as error:
    print(f"skipped: {error}: scripts/setup --python, and build again")
    sys.exit(77)

PROJECT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("CRSM_BIN_DIR", PROJECT / "build/bin"))
CORRIDOR = str(PROJECT / "logs/corridor.lcm")


def run_offline(*words):
    subprocess.run([str(BIN / "slam_offline"), *map(str, words)], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)


def read_pgm(path):
    head, size, _, cells = pathlib.Path(path).read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    return np.frombuffer(cells, np.uint8).reshape(height, width)[::-1]


class Python(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="crsm_python_")
        cls.work = pathlib.Path(cls.temporary.name)
        run_offline(CORRIDOR, "--out", cls.work / "offline")
        log = crsm_slam.Log(CORRIDOR)
        cls.settings = log.settings
        cls.slam = crsm_slam.Slam(**cls.settings)
        cls.scans = list(log)
        cls.steps = [cls.slam.process(scan) for scan in cls.scans]
        cls.slam.save(str(cls.work / "saved"))

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def test_the_map_and_the_path_are_those_of_slam_offline_byte_for_byte(self):
        for name in ("map.pgm", "map.yaml", "trajectory.tum", "graph.g2o"):
            self.assertEqual((self.work / "saved" / name).read_bytes(), (self.work / "offline" / name).read_bytes(), name)
        module = subprocess.run([sys.executable, "-m", "crsm_slam", CORRIDOR, "--out", self.work / "module"],
                                env={**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}"}, stdout=subprocess.PIPE)
        self.assertEqual(module.returncode, 0)
        self.assertEqual((self.work / "module/map.png").read_bytes(), (self.work / "offline/map.png").read_bytes())

    def test_arrays_come_and_go(self):
        slam = crsm_slam.Slam(**self.settings)
        for scan in self.scans[:40]:
            step = slam.process(np.asarray(scan.ranges_m, np.float64), angle_min_rad=scan.angle_min_rad,
                                angle_step_rad=scan.angle_step_rad, utime=scan.utime)
        self.assertEqual(step.state, crsm_slam.State.OK)
        self.assertTrue(np.array_equal(step.T_map_laser, self.steps[39].T_map_laser))
        self.assertEqual(step.covariance.shape, (3, 3))
        self.assertTrue(np.array_equal(step.covariance, step.covariance.T))
        built = slam.make_map()
        left, right, bottom, top = built.extent_m
        self.assertEqual(built.cells.dtype, np.uint8)
        self.assertAlmostEqual((right - left) / built.cell_size_m, built.cells.shape[1])
        self.assertAlmostEqual((top - bottom) / built.cell_size_m, built.cells.shape[0])
        self.assertTrue(np.array_equal(built.origin_m, [left, bottom]))
        self.assertTrue(np.array_equal(self.slam.make_map().cells, read_pgm(self.work / "offline/map.pgm")))
        path = self.slam.trajectory()
        self.assertEqual(path.shape, (len(self.scans),))
        self.assertEqual(list(path["utime"]), [scan.utime for scan in self.scans])
        self.assertEqual(set(path.dtype.names), {"utime", "x_m", "y_m", "yaw_rad", "state", "piece"})
        self.assertEqual(self.slam.loops().dtype.names[0], "older_utime")

    def test_ranges_that_are_none(self):
        slam = crsm_slam.Slam(**self.settings)
        for scan in self.scans[:10]:
            ranges_m = scan.ranges_m.copy()
            ranges_m[3:6] = np.nan, np.inf, -1.0
            step = slam.process(ranges_m, angle_min_rad=scan.angle_min_rad, angle_step_rad=scan.angle_step_rad,
                                utime=scan.utime)
        self.assertNotEqual(step.state, crsm_slam.State.LOST)

    def test_the_verdict_and_the_changes(self):
        verdict = self.slam.judge()
        self.assertEqual(verdict.trust, crsm_slam.Trust.GOOD)
        self.assertIn("scans mapped", str(verdict))
        changes = self.slam.changes_since()
        self.assertGreater(len(changes.tiles), 3)
        self.assertEqual(changes.tiles[0].cells.shape, (64, 64))
        self.assertEqual(len(self.slam.changes_since(changes.version).tiles), 0)

    def test_saved_maps_go_both_ways(self):
        for folder in ("saved", "offline"):
            loaded = crsm_slam.Slam.load(str(self.work / folder))
            self.assertTrue(np.array_equal(loaded.make_map().cells, self.slam.make_map().cells), folder)
            loaded.finish_map()
            poses = [loaded.process(scan) for scan in self.scans[200:260]]
            self.assertEqual(sum(step.state == crsm_slam.State.LOST for step in poses[10:]), 0)
            path = self.slam.trajectory()
            wanted = np.array([path["x_m"][259], path["y_m"][259]])
            self.assertLess(np.linalg.norm(poses[-1].T_map_laser[:2] - wanted), 0.2)
            self.assertRaises(Exception, loaded.save, str(self.work / "never"))
        run_offline(CORRIDOR, "--localize", self.work / "saved", "--out", self.work / "localised")

    def test_a_second_drive(self):
        slam = crsm_slam.Slam(**self.settings)
        for scan in self.scans:
            slam.process(scan)
        slam.begin_drive()
        for scan in self.scans:
            slam.process(crsm_slam.Scan(scan.ranges_m, angle_min_rad=scan.angle_min_rad,
                                        angle_step_rad=scan.angle_step_rad, utime=scan.utime + 10**10))
        self.assertEqual(slam.trajectory()["piece"][-1], 1)

    def test_other_threads_run_meanwhile(self):
        slam = crsm_slam.Slam(**self.settings)
        for scan in self.scans:
            slam.process(scan)
        longest_s, ended = [0.0], threading.Event()

        def watch():
            last = time.monotonic()
            while not ended.is_set():
                now = time.monotonic()
                longest_s[0] = max(longest_s[0], now - last)
                last = now

        watcher = threading.Thread(target=watch)
        begin = time.monotonic()
        watcher.start()
        makers = [threading.Thread(target=lambda: [slam.make_map() for _ in range(5)]) for _ in range(2)]
        for maker in makers:
            maker.start()
        for maker in makers:
            maker.join()
        ended.set()
        watcher.join()
        self.assertLess(longest_s[0], 0.5 * (time.monotonic() - begin))

    def test_wrong_calls_say_what_would_be_right(self):
        scan = self.scans[0]
        good = dict(angle_min_rad=scan.angle_min_rad, angle_step_rad=scan.angle_step_rad, utime=1)
        wrong = [
            (lambda: crsm_slam.Slam(preset="sikc"), ValueError, "preset: 'sikc' is not one of"),
            (lambda: crsm_slam.Slam(range_max=4), ValueError, "range_max: no such key"),
            (lambda: crsm_slam.Slam(cell_size_m=5), ValueError, "cell_size_m: '5' is not a number from 0.005 to 1"),
            (lambda: crsm_slam.Slam(loops="yes"), ValueError, "loops: 'yes' is not true or false"),
            (lambda: crsm_slam.Slam().process(np.ones((2, 2)), **good), ValueError, "ranges_m: must have one dimension"),
            (lambda: crsm_slam.Slam().process(np.ones(1), **good), ValueError, "1 ranges, must be 2 to 4096"),
            (lambda: crsm_slam.Slam().process(np.ones(9), odometry=[1, 2], **good), ValueError, "odometry: must be x"),
            (lambda: crsm_slam.Slam().process(np.ones(9), times_s=[1, 2], **good), ValueError, "2 times_s, must be"),
            (lambda: crsm_slam.Slam().process(np.ones(9)), TypeError, "angle_min_rad"),
            (lambda: crsm_slam.Slam.load("/nowhere"), RuntimeError, "/nowhere"),
            (lambda: crsm_slam.Slam.load(str(self.work / "saved"), cell_size_m=0.2), ValueError, "was made with 0.05"),
            (lambda: crsm_slam.Log("/nowhere"), RuntimeError, "/nowhere"),
            (lambda: crsm_slam.Log(CORRIDOR, laser_channel="LASR"), RuntimeError, "LASR"),
            (lambda: self.slam.save("/proc/nowhere"), RuntimeError, "/proc/nowhere"),
        ]
        for call, kind, text in wrong:
            with self.assertRaises(kind) as raised:
                call()
            self.assertIn(text, str(raised.exception))

    def test_what_the_stubs_promise_is_there(self):
        stubs = (pathlib.Path(crsm_slam.__file__).parent / "__init__.pyi").read_text()
        kind = None
        for line in stubs.splitlines():
            if line.startswith("class "):
                kind = getattr(crsm_slam, line.split()[1].split("(")[0].rstrip(":"))
            elif line.startswith("    def ") and not line.startswith("    def __init__"):
                self.assertTrue(hasattr(kind, line.split()[1].split("(")[0]), line)
        for name in crsm_slam.__all__:
            self.assertIn(name, stubs)
            self.assertTrue(getattr(crsm_slam, name).__doc__, name)


if __name__ == "__main__":
    unittest.main()
