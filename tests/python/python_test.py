#!/usr/bin/env python3
"""The Python package at work: the same map as slam_offline's, arrays in and out, saved and loaded, wrong calls.

usage: PYTHONPATH=build/python CRSM_BIN_DIR=build/bin tests/python/python_test.py
Skipped (exit code 77) where the package was not built, or numpy is not there.
"""
import copy
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import warnings

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

    def test_the_module_is_the_program_of_its_build_where_the_path_has_none(self):
        wanted = subprocess.run([BIN / "slam_offline", "--help"], stdout=subprocess.PIPE, check=True)
        module = subprocess.run([sys.executable, "-m", "crsm_slam", "--help"], env={**os.environ, "PATH": "/nowhere"},
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual((module.returncode, module.stdout, module.stderr), (0, wanted.stdout, b""))

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

    def test_ranges_of_every_kind_of_number(self):
        scan = self.scans[0]
        where = dict(angle_min_rad=scan.angle_min_rad, angle_step_rad=scan.angle_step_rad, utime=np.int64(1))
        masked = np.ma.array(scan.ranges_m, mask=scan.ranges_m > 2)
        for ranges_m in (scan.ranges_m[::-1], list(scan.ranges_m), tuple(map(float, scan.ranges_m)), [1, 2, 3],
                         np.arange(9, dtype=np.uint16), masked, scan.ranges_m.astype(np.float16), memoryview(scan.ranges_m)):
            made = crsm_slam.Scan(ranges_m, **where)
            self.assertEqual((made.ranges_m.dtype, made.utime), (np.float32, 1))
            self.assertEqual(made.ranges_m.shape, (len(ranges_m),))
        made = crsm_slam.Scan(masked, **where)
        self.assertTrue(np.array_equal(np.isnan(made.ranges_m), masked.mask))
        self.assertTrue(np.array_equal(made.ranges_m[~masked.mask], masked.compressed()))
        named = crsm_slam.Slam().process(ranges_m=scan.ranges_m, **where)
        self.assertEqual(named.state, crsm_slam.Slam().process(scan=made).state)

    def test_states_are_compared_with_those_of_an_array(self):
        path = self.slam.trajectory()
        self.assertEqual(int((path["state"] == crsm_slam.State.FIRST).sum()),
                         sum(step.state == crsm_slam.State.FIRST for step in self.steps))
        self.assertEqual(path["state"][1], crsm_slam.State.OK)
        self.assertIs(self.steps[1].state, crsm_slam.State.OK)
        self.assertEqual((str(crsm_slam.State.OK), crsm_slam.State.OK.name), ("State.OK", "OK"))

    def test_paths_are_text_or_of_pathlib(self):
        log = crsm_slam.Log(pathlib.Path(CORRIDOR))
        self.assertEqual(next(log).utime, self.scans[0].utime)
        self.assertEqual(repr(log), f"Log({CORRIDOR!r})")
        self.slam.save(self.work / "of_pathlib")
        loaded = crsm_slam.Slam.load(self.work / "of_pathlib", start=np.zeros(3), **self.settings)
        self.assertEqual(len(loaded.trajectory()), len(self.scans))

    def test_what_a_log_and_numpy_say_are_settings_again(self):
        settings = crsm_slam.Log(CORRIDOR, **{**self.settings, "sweep_s": np.float64(-0.1), "loops": np.bool_(False)}).settings
        self.assertEqual((settings["sweep_s"], settings["loops"]), (-0.1, False))
        self.assertEqual(crsm_slam.Log(CORRIDOR, **settings).settings, settings)

    def test_results_show_what_they_are(self):
        self.assertRegex(repr(self.scans[0]), r"^Scan\(utime=1000000, 240 ranges, angle_min_rad=-2\.09")
        self.assertRegex(repr(self.steps[1]), r"^Step\(state=State\.OK, T_map_laser=\[.*\], fitness=0\.")
        self.assertRegex(repr(self.slam.make_map()), r"^Map\(\d+ x \d+ cells of 0\.05 m\)$")
        self.assertRegex(repr(self.slam.judge()), r"^Verdict\(trust=Trust\.GOOD, off_m=0\.")

    def test_marks_are_kept_with_the_map(self):
        slam = crsm_slam.Slam(**self.settings)
        for scan in self.scans[:80]:
            slam.process(scan)
        slam.mark("v", "victim", utime=self.scans[50].utime, points_m=np.array([[1.0, 0.5]]), name="in the hall")
        slam.mark("v", "victim", utime=self.scans[60].utime, points_m=[(1.0, 0.5)], radius_m=0.2)
        slam.mark("zone", "keep-out", points_m=[(0, 0), (2, 0), (1, 1)])
        victim, zone = slam.marks()
        self.assertEqual((victim.id, victim.kind, victim.name, victim.sightings, victim.on_map),
                         ("v", "victim", "in the hall", 2, True))
        self.assertEqual((victim.points_m.shape, zone.points_m.shape, victim.covariance.shape), ((1, 2), (3, 2), (2, 2)))
        self.assertTrue(np.allclose(zone.points_m, [[0, 0], [2, 0], [1, 1]]))
        self.assertEqual(repr(victim), "PlacedMark(id='v', kind='victim')")
        slam.save(self.work / "marked")
        loaded = crsm_slam.Slam.load(self.work / "marked", **self.settings)
        self.assertTrue(np.allclose(loaded.marks()[0].points_m, victim.points_m))
        slam.mark("zone", "door", points_m=[(1, 1)], moves=True)
        self.assertEqual(slam.marks()[1].kind, "door")
        for id in ("v", "zone"):
            slam.remove_mark(id)
        self.assertEqual(slam.marks(), [])
        for wrong in (lambda: slam.mark("v", "victim", utime=1), lambda: slam.mark("w", "A Victim"),
                      lambda: slam.remove_mark("w")):
            with self.assertRaisesRegex(ValueError, "^mark '[vw]': "):
                wrong()
        with self.assertRaises(TypeError):
            slam.mark("w", "door", points_m=[(1, 2, 3)])

    def test_an_interrupt_ends_the_wait_for_a_laser(self):
        log = crsm_slam.Log("rplidar:/nowhere/ttyUSB0")
        threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt):
            next(log)

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
            poses = [loaded.process(scan) for scan in self.scans[450:510]]
            self.assertEqual(sum(step.state == crsm_slam.State.LOST for step in poses[10:]), 0)
            path = self.slam.trajectory()
            wanted = np.array([path["x_m"][509], path["y_m"][509]])
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

    def run_python(self, text):
        """Runs a program in a Python of its own. Returns its exit code, its output and its errors."""
        head = f"import crsm_slam\nscans = list(crsm_slam.Log({CORRIDOR!r}))\n"
        ended = subprocess.run([sys.executable, "-c", head + text], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               text=True, timeout=60, cwd=self.work)
        return ended.returncode, ended.stdout, ended.stderr

    def test_threads_share_the_scans_of_a_log(self):
        code, output, errors = self.run_python("""
import threading
open("shared.clf", "w").writelines(
    f"FLASER 180 {'3.5 ' * 180}0 0 0 0 0 0 {i}.5 host {i}.5\\n" for i in range(1, 3001))
log = crsm_slam.Log("shared.clf")
for _ in range(3):
    loop, utimes = iter(log), []
    def take():
        for scan in iter(lambda: next(loop, None), None): utimes.append(scan.utime)
    threads = [threading.Thread(target=take) for _ in range(4)]
    for thread in threads: thread.start()
    for thread in threads: thread.join()
    print(len(utimes), len(set(utimes)))
""")
        self.assertEqual((code, output), (0, "3000 3000\n" * 3), errors)

    def test_python_ends_while_daemon_threads_work(self):
        code, output, errors = self.run_python("""
import threading, time
def work():
    while True:
        slam = crsm_slam.Slam()
        for scan in scans: slam.process(scan)
for _ in range(3): threading.Thread(target=work, daemon=True).start()
time.sleep(0.3)
print("the end")
""")
        self.assertEqual((code, output), (0, "the end\n"), errors)

    def test_a_forked_process_makes_maps_of_its_own(self):
        code, output, errors = self.run_python("""
import os
slam = crsm_slam.Slam()
for scan in scans[:50]: slam.process(scan)
if os.fork() == 0:
    try: slam.process(scans[50])
    except RuntimeError as error: print(error, flush=True)
    del slam
    slam = crsm_slam.Slam()
    for scan in scans[:50]: slam.process(scan)
    print("done", flush=True)
    os._exit(0)
os.wait()
""")
        self.assertEqual(code, 0, errors)
        self.assertEqual(output, "this Slam is of the process that was forked: make or load one in the new process\ndone\n")

    def test_what_is_moved_aside_is_a_warning_that_names_it(self):
        folder = self.work / "said"
        for num in range(2):
            slam = crsm_slam.Slam(**self.settings)
            for scan in self.scans[:30]:
                slam.process(scan)
            if num == 0:
                slam.save(folder)
                continue
            with self.assertWarnsRegex(RuntimeWarning, f"the results of another map in {folder} are now in {folder}/earlier.1"):
                slam.save(folder)

    def test_paths_are_those_of_the_file_system(self):
        slam = crsm_slam.Slam(**self.settings)
        for scan in self.scans[:30]:
            slam.process(scan)
        name = os.fsdecode(b"not UTF-8 \xff")
        slam.save(self.work / name)
        self.assertEqual(len(crsm_slam.Slam.load(self.work / name).trajectory()), 30)
        missing = str(self.work / os.fsdecode(b"missing \xff"))
        with self.assertRaisesRegex(RuntimeError, "there is no saved map in " + missing):
            crsm_slam.Slam.load(missing)
        for call in (slam.save, crsm_slam.Slam.load, crsm_slam.Log):
            with self.assertRaisesRegex(ValueError, "null"):
                call("a\0b")
            with self.assertRaises(UnicodeEncodeError):
                call("a\ud800")

    def test_an_error_of_the_callers_own_code_comes_through(self):
        class Own:
            def __index__(self):
                raise KeyError("own")
            __float__ = __fspath__ = __index__

        ranges = np.full(100, 3.0)
        for arguments in ({"utime": Own(), "angle_min_rad": 0.0}, {"utime": 1, "angle_min_rad": Own()}):
            with self.assertRaisesRegex(KeyError, "own"):
                crsm_slam.Scan(ranges_m=ranges, angle_step_rad=0.01, **arguments)
        with self.assertRaisesRegex(KeyError, "own"):
            crsm_slam.Log(Own())
        with self.assertRaises(UnicodeEncodeError):
            crsm_slam.Slam(**{"a\ud800": 1})

    def test_no_object_is_without_a_value(self):
        for kind in (crsm_slam.Scan, crsm_slam.Slam, crsm_slam.Log, crsm_slam.Map, crsm_slam.Step, crsm_slam.Verdict):
            with self.assertRaisesRegex(TypeError, "cannot be copied, pickled or made by __new__"):
                kind.__new__(kind)
        with self.assertRaises(TypeError):
            copy.copy(self.scans[0])

        class Own(crsm_slam.Slam):
            pass

        self.assertIsInstance(Own(preset="sick"), Own)

    def test_equal_paths_have_equal_bytes(self):
        slam = crsm_slam.Slam(**self.settings)
        for scan in self.scans[:30]:
            slam.process(scan)
        first = slam.trajectory().tobytes()
        for size in (1000, 3000, 100000):
            np.full(size, 255, np.uint8)  # what lay in memory before
            self.assertEqual(slam.trajectory().tobytes(), first)

    def test_half_a_journal_is_loaded_with_a_warning(self):
        self.slam.save(self.work / "half")
        journal = self.work / "half/journal/journal.lcm"
        os.truncate(journal, journal.stat().st_size // 2)
        with self.assertWarnsRegex(RuntimeWarning, r"journal\.lcm: torn .* bytes are left out; \d+ scans remain"):
            half = crsm_slam.Slam.load(self.work / "half")
        self.assertLess(len(half.trajectory()), len(self.scans))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            self.assertRaises(RuntimeWarning, crsm_slam.Slam.load, self.work / "half")
            crsm_slam.Slam.load(self.work / "saved")

    def test_what_of_a_log_is_left_out_is_said(self):
        (self.work / "bad.clf").write_text(
            "".join(f"FLASER 3 1 2 {'x' if i == 5 else 3} 0 0 0 0 0 0 {i}.5 host {i}.5\n" for i in range(1, 9)))
        code, _, errors = self.run_python("for scan in crsm_slam.Log('bad.clf'): pass")
        self.assertEqual(code, 0)
        self.assertIn("crsm_slam: bad.clf: 1 of 8 scans are left out: line 5 is wrong", errors)

    def test_the_module_can_be_looked_at(self):
        code, output, errors = self.run_python("import crsm_slam.__main__; print('still here')")
        self.assertEqual((code, output), (0, "still here\n"), errors)

    def check_wrong(self, calls):
        for call, kind, text in calls:
            with self.assertRaises(kind, msg=text) as raised:
                call()
            self.assertIn(text, str(raised.exception))
            self.assertNotIn("\n", str(raised.exception))

    def test_wrong_settings_and_files_say_what_would_be_right(self):
        self.check_wrong([
            (lambda: crsm_slam.Slam("sick"), TypeError, "Slam(preset='sick'"),
            (lambda: crsm_slam.Slam({"preset": "sick"}), TypeError, "Slam(preset='sick'"),
            (lambda: crsm_slam.Slam(preset="sikc"), ValueError, "preset: 'sikc' is not one of"),
            (lambda: crsm_slam.Slam(range_max=4), ValueError, "range_max: no such key; there are preset, profile, range_min_m"),
            (lambda: crsm_slam.Slam(cel_size_m=1), ValueError, "did you mean cell_size_m?"),
            (lambda: crsm_slam.Slam(cell_size_m=5), ValueError, "cell_size_m: '5' is not a number from 0.005 to 1"),
            (lambda: crsm_slam.Slam(loops="yes"), ValueError, "loops: 'yes' is not true or false"),
            (lambda: crsm_slam.Slam.load("/nowhere"), RuntimeError, "there is no saved map in /nowhere"),
            (lambda: crsm_slam.Slam.load(self.work / "saved/map.png"), RuntimeError, "there is no saved map in"),
            (lambda: crsm_slam.Slam.load(self.work / "saved", cell_size_m=0.2), ValueError, "was made with 0.05"),
            (lambda: crsm_slam.Slam.load(self.work / "saved", strat=[0, 0, 0]), ValueError, "strat: no such key"),
            (lambda: crsm_slam.Slam.load(self.work / "saved", start=[0, 0]), ValueError, "start: must be x"),
            (lambda: crsm_slam.Slam.load(self.work / "saved", start=np.eye(4)), ValueError, "of a matrix T these are T[0, -1]"),
            (lambda: crsm_slam.Log("/nowhere"), RuntimeError, "/nowhere"),
            (lambda: crsm_slam.Log(5), TypeError, "name: is of type int, must be text or a pathlib.Path"),
            (lambda: crsm_slam.Log(CORRIDOR, laser_channel="LASR"), RuntimeError, "LASR"),
            (lambda: crsm_slam.Log(CORRIDOR, odometry="yes"), TypeError, "odometry: is 'yes', must be True or False"),
            (lambda: crsm_slam.Log(CORRIDOR, laser_topic="/scan"), ValueError, "laser_topic: no such key; there are"),
            (lambda: crsm_slam.Log(CORRIDOR, laser_chanel="LASER"), ValueError, "did you mean laser_channel?"),
            (lambda: self.slam.save("/proc/nowhere"), RuntimeError, "/proc/nowhere"),
            (lambda: self.slam.save(""), ValueError, "folder: is empty"),
        ])

    def test_wrong_scans_say_what_would_be_right(self):
        scan, slam = self.scans[0], crsm_slam.Slam()
        good = dict(angle_min_rad=scan.angle_min_rad, angle_step_rad=scan.angle_step_rad, utime=1)

        def process(ranges_m=np.ones(9), **others):
            return lambda: slam.process(ranges_m, **{**good, **others})

        self.check_wrong([
            (process(np.ones((2, 2))), ValueError, "ranges_m: must have one dimension, has shape (2, 2)"),
            (process(np.ones(1)), ValueError, "1 ranges, must be 2 to 4096"),
            (process([]), ValueError, "0 ranges, must be 2 to 4096"),
            (process(np.full(9, 3000)), ValueError, "ranges_m: has whole numbers up to 3000, must be metres"),
            (process(np.ones(9, bool)), TypeError, "ranges_m: has dtype bool, must be an array of numbers"),
            (process(np.ones(9, complex)), TypeError, "ranges_m: has dtype complex128"),
            (process([1.0, None]), TypeError, "ranges_m: is of type list, must be an array of numbers"),
            (process("123"), TypeError, "ranges_m: is of type str"),
            (process(None), TypeError, "ranges_m: is of type NoneType"),
            (process(odometry=[1, 2]), ValueError, "odometry: must be x [m], y [m], yaw [rad], has shape (2,)"),
            (process(odometry=np.eye(4)), ValueError, "of a matrix T these are T[0, -1], T[1, -1]"),
            (process(odometry=[np.nan, 0, 0]), ValueError, "odometry: [nan, 0.0, 0.0] must be finite"),
            (process(times_s=[1, 2]), ValueError, "2 times_s, must be"),
            (process(times_s=np.full(9, 1.7e9)), ValueError, "times_s must be within 2 s of utime"),
            (process(angle_min_rad=-90), ValueError, "angle_min_rad -90 must be within a full turn: radians"),
            (process(angle_step_rad=1), ValueError, "angle_step_rad 1 times its ranges, 9, must be within a full turn"),
            (process(angle_min_rad="-1.5"), TypeError, "angle_min_rad: is of type str, must be a number of radians"),
            (process(utime=1.5), TypeError, "utime: is of type float, must be a whole number of microseconds"),
            (process(utime="1"), TypeError, "utime: is of type str"),
            (process(utime=-1), ValueError, "utime: -1 is negative"),
            (process(utime=-10**30), ValueError, "is negative"),
            (process(utime=1700000000 * 10**9), ValueError, "nanoseconds // 1000"),
            (process(utime=10**30), ValueError, "nanoseconds // 1000"),
            (lambda: slam.process(np.ones(9)), TypeError, "Slam.process() needs angle_min_rad, angle_step_rad, utime"),
            (lambda: slam.process(), TypeError, "Slam.process() needs ranges_m, angle_min_rad"),
            (lambda: slam.process(np.ones(9), -1.5, 0.1, 1), TypeError, "name the others: angle_min_rad"),
            (lambda: slam.process(scan, utime=1), TypeError, "takes a Scan alone"),
            (lambda: slam.process(np.ones(9), ranges_m=np.ones(9), **good), TypeError, "got ranges_m twice"),
            (process(angle_stp_rad=1), TypeError, "has no argument angle_stp_rad; it takes ranges_m, angle_min_rad"),
            (process(angle_stp_rad=1), TypeError, "did you mean angle_step_rad?"),
            (lambda: crsm_slam.Scan(np.ones(9), utime=1), TypeError, "Scan() needs angle_min_rad, angle_step_rad"),
        ])
        self.assertEqual(len(slam.trajectory()), 0)
        slam.process(scan)
        self.check_wrong([(lambda: slam.process(scan), ValueError, "this utime was used before; each scan has its own")])

    def test_help_says_it_as_python_writes_it(self):
        for kind in (crsm_slam.Scan, crsm_slam.Slam, crsm_slam.Log):
            self.assertTrue(kind.__doc__.startswith(kind.__name__ + "("), kind)
            self.assertEqual(kind.__module__, "crsm_slam")
        for name in self.settings:
            self.assertIn(f"\n  {name} = ", crsm_slam.Slam.__doc__)
        for kind in (getattr(crsm_slam, name) for name in crsm_slam.__all__):
            for name, member in vars(kind).items() if isinstance(kind, type) else ():
                if not name.startswith("_") and not isinstance(member, kind):
                    self.assertTrue(member.__doc__, f"{kind.__name__}.{name}")
                    self.assertNotIn("_crsm_slam", member.__doc__)

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
