#!/usr/bin/env python3
"""Bags that others' programs wrote give the same scans, map and trajectory as the log of the same simulated drive.

usage: tests/bags/bags_test.py ros1|ros2 BIN_DIR
ros1 needs Debian's python3-rosbag, python3-sensor-msgs and python3-nav-msgs; ros2 needs lz4 and zstd (scripts/setup
--bags), and npm with its registry (--npm). Exit code 77 where they are not there.
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

from drive import copy_as_odometry, read_drive, read_odometry, write_carmen

HERE = pathlib.Path(__file__).resolve().parent
SKIPPED = 77
MOST_SCANS = 300
RESULTS = ("map.png", "trajectory.tum")


class Skip(Exception):
    pass


def check(holds, what):
    if not holds:
        raise AssertionError(what)
    print(f"  {what}", flush=True)


def run(*command):
    return subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)


def must_run(*command, **options):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False, **options)
    if done.returncode != 0:
        raise AssertionError(f"{command[0]}: exit code {done.returncode}: {done.stdout}{done.stderr}")


def python_with_rosbag():
    for python in (sys.executable, "/usr/bin/python3"):
        if run(python, "-c", "import rosbag, nav_msgs.msg, sensor_msgs.msg").returncode == 0:
            return python
    raise Skip("there is no python3-rosbag: scripts/setup --bags")


class Drive:
    """A simulated drive, what the programs make of it, and how to compare."""

    def __init__(self, bin_dir, folder):
        self.bin = bin_dir
        self.folder = folder
        whole = folder / "whole.lcm"
        must_run(bin_dir / "laser_publisher", "sim:demo", "--lcm-url", f"file://{whole}?mode=w")
        self.log = folder / "drive.lcm"
        copy_as_odometry(whole, self.log, MOST_SCANS)
        self.sweeps = read_drive(whole, MOST_SCANS)
        self.path = whole
        self.reference = self.convert(self.log)[0]
        self.maps = self.map(self.log, "reference")
        write_carmen(self.sweeps, folder / "drive.clf")
        check(self.map(folder / "drive.clf", "carmen") == self.maps, "the CARMEN log gives the map of the LCM log")

    def convert(self, source, *flags):
        """All scans and odometry of a source as bytes, and what was said."""
        to = self.folder / "converted.lcm"
        done = run(self.bin / "laser_publisher", source, "--lcm-url", f"file://{to}?mode=w", *flags)
        return (to.read_bytes() if done.returncode == 0 else b""), done.stderr

    def map(self, source, name):
        out = self.folder / f"out_{name}"
        must_run(self.bin / "slam_offline", source, "--no-odometry", "--out", out)
        return [(out / result).read_bytes() for result in RESULTS]

    def check_same(self, source, same_map=True, odometry=True):
        scans = self.convert(source)[0]
        reference = self.reference if odometry else without_odometry(self.reference)
        check((scans if odometry else without_odometry(scans)) == reference, f"{source.name}: the same scans")
        if same_map:
            check(self.map(source, source.name) == self.maps, f"{source.name}: the same map and trajectory")

    def check_transforms(self, source):
        """The path of the laser by TF, which a robot carries off its centre."""
        scans, said = self.convert(source)
        check(without_odometry(scans) == without_odometry(self.reference), f"{source.name}: the same scans")
        check("the laser stands at x 0.250 m, y -0.100 m, yaw 90.0 deg on the robot" in said,
              f"{source.name}: where the laser stands is found in TF")
        poses = read_odometry(self.folder / "converted.lcm")
        check(len(poses) == len(self.sweeps) and all(map(is_same_pose, poses, (s.pose for s in self.sweeps))),
              f"{source.name}: the path of the laser by TF")
        out = self.folder / "out_transforms"
        said = run(self.bin / "slam_offline", source, "--out", out, "--force").stderr
        check("of TF) is used" in said, f"{source.name}: the odometry of TF is used")

    def check_begin(self, source, least):
        """Of a recording that was killed: as far as it goes, and said."""
        scans, said = self.convert(source)
        scans, reference = without_odometry(scans), without_odometry(self.reference)  # the last one's may be lost
        share = len(scans) / len(reference)
        check(reference[:len(scans)] == scans and share >= least, f"{source.name}: {share:.0%} of the same scans")
        check("(truncated)" in said, f"{source.name}: is said to be cut")

    def check_refused(self, source, text):
        said = self.convert(source)[1]
        check(text in said, f"{source.name}: {said.strip()}")


def without_odometry(log):
    """What is not odometry, whatever its number in the log."""
    return [event[8:] for event in log.split(b"\xed\xa1\xda\x01") if b"ODOMETRY" not in event[:40]]


def is_same_pose(a, b):
    """Of x, y, z and quaternion; poses have whole micrometres and microradians, and are rounded twice."""
    return all(abs(value - other) < 3e-6 for value, other in zip(a, b))


def cut(path, share):
    to = path.with_name(f"{path.stem}_cut{path.suffix}")
    content = path.read_bytes()
    to.write_bytes(content[:int(share * len(content))])
    return to


def test_ros1(drive):
    out = drive.folder / "ros1"
    out.mkdir()
    must_run(python_with_rosbag(), "-B", HERE / "write_ros1.py", drive.path, MOST_SCANS, out)
    for compression in ("none", "bz2", "lz4"):
        drive.check_same(out / f"{compression}.bag")
        drive.check_begin(out / f"{compression}_killed.bag", 0.7)
        drive.check_begin(cut(out / f"{compression}.bag", 0.6), 0.4)
    for name in ("tf.bag", "old_tf.bag"):
        drive.check_transforms(out / name)
    two = out / "two_lasers.bag"
    drive.check_refused(two, "--laser-channel must name one of /front/scan (sensor_msgs/LaserScan in ros1), /rear/scan")
    rear = drive.convert(two, "--laser-channel", "/rear/scan")[0]
    check(rear == drive.reference, "two_lasers.bag: the one that is named")


def install_packages(bin_dir):
    packages = bin_dir.parent / "bags_packages"
    packages.mkdir(exist_ok=True)
    shutil.copy(HERE / "package.json", packages)
    install = ["npm", "install", "--ignore-scripts", "--no-audit", "--no-fund", "--no-package-lock"]
    if not shutil.which("npm") or subprocess.run(install, cwd=packages, capture_output=True, check=False).returncode:
        raise Skip("npm is not here, or does not reach its registry: scripts/setup --npm")
    return packages / "node_modules"


def test_ros2(drive):
    for program in ("lz4", "zstd"):
        if not shutil.which(program):
            raise Skip(f"there is no {program}: scripts/setup --bags")
    modules = install_packages(drive.bin)
    out = drive.folder / "ros2"
    out.mkdir()
    (out / "sweeps.json").write_text(json.dumps([sweep.as_json() for sweep in drive.sweeps]), encoding="ascii")
    environment = {**os.environ, "NODE_MODULES": str(modules)}
    must_run("node", HERE / "write_mcap.mjs", out / "sweeps.json", out, env=environment)
    must_run(sys.executable, "-B", HERE / "write_rosbag2.py", out / "cdr.json", out)
    for name in ("chunks.mcap", "lz4.mcap", "zstd.mcap", "no_chunks.mcap", "no_summary.mcap", "run.db3", "folder",
                 "killed_folder"):
        drive.check_same(out / name)
    drive.check_same(out / "json.mcap", odometry=False)
    for name in ("tf.mcap", "tf.db3"):
        drive.check_transforms(out / name)
    some = without_odometry(drive.convert(out / "messages_zstd.db3")[0])
    check(len(some) > 10 and some == without_odometry(drive.reference)[:len(some)], "messages_zstd.db3: the same scans")
    for name in ("chunks.mcap", "lz4.mcap", "zstd.mcap", "no_chunks.mcap", "run.db3"):
        drive.check_begin(cut(out / name, 0.6), 0.4)


def main():
    if len(sys.argv) != 3 or sys.argv[1] not in ("ros1", "ros2"):
        print(__doc__.strip())
        return 2
    with tempfile.TemporaryDirectory(prefix="crsm_bags_") as folder:
        try:
            test = test_ros1 if sys.argv[1] == "ros1" else test_ros2
            if test is test_ros1:
                python_with_rosbag()
            test(Drive(pathlib.Path(sys.argv[2]).resolve(), pathlib.Path(folder)))
        except Skip as reason:
            print(f"skipped: {reason}")
            return SKIPPED
        except AssertionError as error:
            print(f"FAILED: {error}")
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
