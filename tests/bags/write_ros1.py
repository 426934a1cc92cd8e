#!/usr/bin/env python3
"""Writes a drive as ROS 1 bags, by the recorder's own library (Debian's python3-rosbag).

usage: tests/bags/write_ros1.py DRIVE.lcm MOST_SCANS OUT_DIR [CHUNK_BYTES]
"""

import math
import os
import pathlib
import sys

import genpy.dynamic
import rosbag
import rospy
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String

from drive import MOUNTING, read_drive

# TF's messages are of no package of Debian's python3-rosbag: genpy makes them from their definition.
TRANSFORMS = "geometry_msgs/TransformStamped[] transforms\n" + "=" * 80 + """
MSG: geometry_msgs/TransformStamped
""" + TransformStamped._full_text
TfMessage = genpy.dynamic.generate_dynamic("tf2_msgs/TFMessage", TRANSFORMS)["tf2_msgs/TFMessage"]
OldTfMessage = genpy.dynamic.generate_dynamic("tf/tfMessage", TRANSFORMS)["tf/tfMessage"]


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


def transform(parent, child, pose, time):
    stamped = TransformStamped()
    stamped.header.stamp = time
    stamped.header.frame_id = parent
    stamped.child_frame_id = child
    x, y, yaw = pose
    stamped.transform.translation.x, stamped.transform.translation.y = x, y
    stamped.transform.rotation.z, stamped.transform.rotation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return stamped


def write_tf(path, sweeps):
    """What never moves once, on /tf_static; and a map to which another program moves the odometry."""
    with rosbag.Bag(path, "w") as bag:
        start = rospy.Time(*sweeps[0].stamp)
        plate = transform("base_link", "plate", (MOUNTING[0], MOUNTING[1], 0), rospy.Time(0))
        laser = transform("plate", "laser", (0, 0, MOUNTING[2]), rospy.Time(0))
        bag.write("/tf_static", TfMessage([plate, laser]), start)
        for number, sweep in enumerate(sweeps):
            time = rospy.Time(*sweep.stamp)
            bag.write("/scan", laser_message(sweep), time)
            correction = transform("map", "odom", (number % 7, 0, number), time)
            bag.write("/tf", TfMessage([correction, transform("odom", "base_link", sweep.robot, time)]), time)


def write_old_tf(path, sweeps):
    """As before ROS Hydro: slashes before the names, and what never moves again and again."""
    with rosbag.Bag(path, "w") as bag:
        for sweep in sweeps:
            time = rospy.Time(*sweep.stamp)
            bag.write("/tf", OldTfMessage([transform("/odom_combined", "/base_link", sweep.robot, time)]), time)
            bag.write("/tf", OldTfMessage([transform("/base_link", "/laser", MOUNTING, time)]), time)
            bag.write("/scan", laser_message(sweep), time)


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
    write_tf(str(out / "tf.bag"), sweeps)
    write_old_tf(str(out / "old_tf.bag"), sweeps)
    write(str(out / "two_lasers.bag"), sweeps, "none", chunk_bytes, ("/front/scan", "/rear/scan"))


if __name__ == "__main__":
    main()
