#!/usr/bin/env python3
"""Draws a saved map and its path with matplotlib, and shows it or writes it to a file."""
import argparse

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("folder", help="of the results")
parser.add_argument("picture", nargs="?", help="a file to write; without it a window opens")
arguments = parser.parse_args()

import crsm_slam
import matplotlib

if arguments.picture:
    matplotlib.use("Agg")  # no window
from matplotlib import pyplot

slam = crsm_slam.Slam.load(arguments.folder)
built = slam.make_map()
path = slam.trajectory()
path = path[path["piece"] == 1]
pyplot.imshow(built.cells, cmap="gray", vmin=0, vmax=255, origin="lower", extent=built.extent_m)
pyplot.plot(path["x_m"], path["y_m"], linewidth=1)
pyplot.xlabel("x [m]")
pyplot.ylabel("y [m]")
pyplot.title(f"{len(path)} scans, {len(slam.loops())} loops")
pyplot.savefig(arguments.picture, dpi=150) if arguments.picture else pyplot.show()
