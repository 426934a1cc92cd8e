#!/usr/bin/env python3
"""An example of a laser driver: it publishes scans on LASER as bot_core.planar_lidar_t.

It has no device: it simulates a room of 6 x 4 m, in which the laser turns on the spot by 0.2 rad/s.
"""

import argparse
import math
import sys
import time

from bot_core import planar_lidar_t

from lcm_bus import LcmBus, now_utime

BEAMS = 360
RATE_HZ = 10.0
TURN_RAD_S = 0.2


def range_to_wall(heading_rad):
    """From a place 1.5 m left and 0.7 m below the middle of the room [m]."""
    x, y = math.cos(heading_rad), math.sin(heading_rad)
    to_side = ((3.0 + 1.5) if x > 0 else (3.0 - 1.5)) / max(abs(x), 1e-9)
    to_end = ((2.0 + 0.7) if y > 0 else (2.0 - 0.7)) / max(abs(y), 1e-9)
    return min(to_side, to_end)


def scan_at(yaw_rad):
    scan = planar_lidar_t()
    scan.utime = now_utime()  # each scan needs one of its own
    scan.rad0 = -math.pi  # radians, counter-clockwise from straight ahead
    scan.radstep = 2.0 * math.pi / BEAMS
    scan.nranges = BEAMS
    scan.ranges = [range_to_wall(yaw_rad + scan.rad0 + i * scan.radstep) for i in range(BEAMS)]  # metres; 0: no return
    return scan


def main():
    parser = argparse.ArgumentParser(prog="scripts/examples/run driver.py", description=__doc__)
    parser.add_argument("num_scans", type=int, nargs="?", default=sys.maxsize, help="without it: until Ctrl-C")
    num_scans = parser.parse_args().num_scans
    bus = LcmBus()
    for number in range(num_scans):
        bus.publish("LASER", scan_at(TURN_RAD_S * number / RATE_HZ))
        time.sleep(1.0 / RATE_HZ)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
