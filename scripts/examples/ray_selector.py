#!/usr/bin/env python3
"""A replacement for ray_selector: it sends the valid rays of each scan, and marks every n-th of them as critical.

It needs a stack beside it: scripts/run_stack LOG --out DIR --without ray_selector. README.md beside this file says what a
replacement must do.
"""

import argparse
import math

from bot_core import planar_lidar_t
from crsm import critical_rays_t

from lcm_bus import LcmBus

RANGE_MIN_M, RANGE_MAX_M = 0.05, 28.5
MOST_CRITICAL = 80


def select(scan):
    rays = critical_rays_t()
    rays.utime = scan.utime  # which scan it is: the answer bears the same
    for i, range_m in enumerate(scan.ranges):
        if math.isfinite(range_m) and RANGE_MIN_M <= range_m <= RANGE_MAX_M:
            rays.angle_rad.append(scan.rad0 + i * scan.radstep)
            rays.range_m.append(range_m)
    if scan.radstep < 0:  # angles rise
        rays.angle_rad.reverse()
        rays.range_m.reverse()
    rays.num_rays = len(rays.range_m)
    step = max(1, math.ceil(rays.num_rays / MOST_CRITICAL))
    rays.critical = list(range(0, rays.num_rays, step))
    rays.num_critical = len(rays.critical)
    return rays


class RaySelector:
    def __init__(self, bus):
        self._bus = bus
        self._last_answer = None
        bus.subscribe("LASER", planar_lidar_t, self._answer)

    def _answer(self, scan):
        """Lockstep: a scan that comes once more gets the answer that it had."""
        if self._last_answer is None or self._last_answer.utime != scan.utime:
            self._last_answer = select(scan)
        self._bus.publish("CRITICAL_RAYS", self._last_answer)


def main():
    argparse.ArgumentParser(prog="scripts/examples/run ray_selector.py", description=__doc__).parse_args()
    bus = LcmBus()
    RaySelector(bus)
    while True:
        bus.handle(timeout_s=1.0)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
