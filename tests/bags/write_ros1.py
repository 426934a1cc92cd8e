#!/usr/bin/env python3
"""Writes a drive as ROS 1 bags, by the recorder's own library (Debian's python3-rosbag).

usage: tests/bags/write_ros1.py DRIVE.lcm MOST_SCANS OUT_DIR [CHUNK_BYTES]
"""

import os
import pathlib
import sys

import rosbag
import rospy
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String

from drive import read_drive


def laser_message(sweep):
    message = LaserScan()
    message.header.stamp = rospy.Time(*sweep.stamp)
    message.header.frame_id = "laser"
    message.angle_min = sweep.angle_min
    message.angle_increment = sweep.angle_increment
    message.range_max = 1000.0
    message.ranges = sweep.ranges
    message.intensities = [47.0] * len(sweep.ranges)
    return message


def odometry_message(sweep):
    message = Odometry()
    message.header.stamp = rospy.Time(*sweep.stamp)
    message.child_frame_id = "base_link"
    pose = message.pose.pose
    pose.position.x, pose.position.y, pose.position.z = sweep.pose[:3]
    orientation = pose.orientation
    orientation.w, orientation.x, orientation.y, orientation.z = sweep.pose[3:]
    return message


def fill(bag, sweeps, lasers=("/scan",)):
    for number, sweep in enumerate(sweeps):
        time = rospy.Time(*sweep.stamp)
        if number % 10 == 0:
            bag.write("/chatter", String(f"scan {number}"), time)
        for laser in lasers:
            bag.write(laser, laser_message(sweep), time)
        if sweep.pose:
            bag.write("/odom", odometry_message(sweep), time)


def write(path, sweeps, compression, chunk_bytes, lasers=("/scan",)):
    with rosbag.Bag(path, "w", compression=compression, chunk_threshold=chunk_bytes) as bag:
        fill(bag, sweeps, lasers)


def write_and_be_killed(path, sweeps, compression, chunk_bytes):
    """Without an index, and its last chunk without an end."""
    child = os.fork()
    if child == 0:
        bag = rosbag.Bag(path, "w", compression=compression, chunk_threshold=chunk_bytes)
        fill(bag, sweeps)
        bag._file.flush()
        os._exit(0)
    assert os.waitpid(child, 0)[1] == 0


def main():
    drive, most, out = sys.argv[1], int(sys.argv[2]), pathlib.Path(sys.argv[3])
    chunk_bytes = int(sys.argv[4]) if len(sys.argv) > 4 else 100000
    sweeps = read_drive(drive, most)
    for compression in ("none", "bz2", "lz4"):
        write(str(out / f"{compression}.bag"), sweeps, compression, chunk_bytes)
        write_and_be_killed(str(out / f"{compression}_killed.bag"), sweeps, compression, chunk_bytes)
    write(str(out / "two_lasers.bag"), sweeps, "none", chunk_bytes, ("/front/scan", "/rear/scan"))


if __name__ == "__main__":
    main()
