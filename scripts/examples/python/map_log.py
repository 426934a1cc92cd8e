#!/usr/bin/env python3
"""Maps a log or a bag of any kind that slam_offline reads."""
import argparse

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("log")
parser.add_argument("folder", help="for the results")
arguments = parser.parse_args()

import crsm_slam

log = crsm_slam.Log(arguments.log)
slam = crsm_slam.Slam(**log.settings)
for scan in log:
    slam.process(scan)
print(slam.judge())
slam.save(arguments.folder)
