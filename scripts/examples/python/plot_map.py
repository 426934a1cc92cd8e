#!/usr/bin/env python3
"""Draws a saved map and its path with matplotlib, and shows it or writes it to a file.

usage: plot_map.py FOLDER [PICTURE]
"""
import sys

import crsm_slam
import matplotlib

if len(sys.argv) > 2:
    matplotlib.use("Agg")  # no window
from matplotlib import pyplot

slam = crsm_slam.Slam.load(sys.argv[1])
built = slam.make_map()
path = slam.trajectory()
path = path[path["piece"] == 1]
pyplot.imshow(built.cells, cmap="gray", vmin=0, vmax=255, origin="lower", extent=built.extent_m)
pyplot.plot(path["x_m"], path["y_m"], linewidth=1)
pyplot.xlabel("x [m]")
pyplot.ylabel("y [m]")
pyplot.title(f"{len(path)} scans, {len(slam.loops())} loops")
pyplot.savefig(sys.argv[2], dpi=150) if len(sys.argv) > 2 else pyplot.show()
