#!/usr/bin/env python3
"""Maps a log or a bag of any kind that slam_offline reads.

usage: map_log.py LOG FOLDER
"""
import sys

import crsm_slam

log = crsm_slam.Log(sys.argv[1])
slam = crsm_slam.Slam(**log.settings)
for scan in log:
    slam.process(scan)
print(slam.judge())
slam.save(sys.argv[2])
