"""CRSM SLAM: maps of buildings, and poses of a robot, from the scans of a planar laser.

    import crsm_slam

    log = crsm_slam.Log("run.bag")              # or your own arrays: slam.process(ranges_m, ...)
    slam = crsm_slam.Slam(**log.settings)
    for scan in log:
        step = slam.process(scan)               # step.state, step.T_map_laser, step.fitness
    print(slam.judge())                         # whether the map can be trusted, and why
    slam.save("out/run")                        # map.png, map.yaml, trajectory.tum, and all that load() needs

With arrays of your own:

    slam = crsm_slam.Slam(range_max_m=12)
    for seconds, ranges in my_scans:            # ranges: (N,), metres
        step = slam.process(ranges, angle_min_rad=-numpy.pi, angle_step_rad=2 * numpy.pi / len(ranges),
                            utime=int(1e6 * seconds))

A map for later:

    slam = crsm_slam.Slam.load("out/run")       # the next scan goes on with it, or
    slam.finish_map()                           # is localised on it

Lengths are in metres, angles in radians, counter-clockwise, times in microseconds where they are called utime. A pose is
(x, y, yaw). T_a_b is the pose of frame b in frame a. `python3 -m crsm_slam LOG --out DIR` is the program slam_offline.
A wrong call raises TypeError or ValueError, a file that cannot be read or written raises RuntimeError: one line that says
what would be right.
"""
import numpy  # whoever lacks it is told so by its name

from ._crsm_slam import Log, Map, MapChanges, PlacedMark, Scan, Slam, State, Step, Tile, Trust, Verdict, presets, version

for _kind in (Log, Map, MapChanges, PlacedMark, Scan, Slam, Step, Tile, Verdict):
    _kind.__module__ = __name__  # where users find it, as help() says
del _kind, numpy

__version__ = version()
__all__ = ["Log", "Map", "MapChanges", "PlacedMark", "Scan", "Slam", "State", "Step", "Tile", "Trust", "Verdict", "presets", "version"]
