#!/usr/bin/env python3
"""Prints the robot's pose from POSE, until Ctrl-C: x y yaw, in metres and radians."""

import argparse
import math

from bot_core import pose_t

from lcm_bus import LcmBus


def show(pose):
    w, _, _, z = pose.orientation  # a turn about the vertical alone
    print(f"{pose.pos[0]:.3f} {pose.pos[1]:.3f} {2.0 * math.atan2(z, w):.3f}", flush=True)


def main():
    argparse.ArgumentParser(prog="scripts/examples/run listener.py", description=__doc__).parse_args()
    bus = LcmBus()
    bus.subscribe("POSE", pose_t, show)
    while True:
        bus.handle(timeout_s=1.0)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
