#!/usr/bin/env python3
"""Writes the laser of an LCM log as a CARMEN log, to the standard output.

The types come with libcrsm-slam-dev: PYTHONPATH=/usr/share/crsm_slam/python. LCM itself is not needed.
"""
import argparse
import struct

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("log", help="of LCM, with bot_core.planar_lidar_t on LASER")
arguments = parser.parse_args()

from bot_core import planar_lidar_t

with open(arguments.log, "rb") as log:
    while header := log.read(28):  # of an event: sync word, number, utime, and two lengths
        _, _, _, channel_bytes, data_bytes = struct.unpack(">IqqII", header)
        channel, data = log.read(channel_bytes), log.read(data_bytes)
        if channel == b"LASER":
            scan = planar_lidar_t.decode(data)
            ranges = " ".join(map(repr, scan.ranges))
            print(f"ROBOTLASER1 0 {scan.rad0!r} 0 {scan.radstep!r} 0 0 0 {scan.nranges} {ranges} 0 0 0 0 0 0 0 0 0 0 0 0 "
                  f"{scan.utime // 1000000}.{scan.utime % 1000000:06} host 0")
