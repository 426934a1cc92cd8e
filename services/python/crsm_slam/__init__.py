"""CRSM SLAM: maps of buildings, and poses of a robot, from the scans of a planar laser.

    import crsm_slam

    log = crsm_slam.Log("run.bag")              # or your own arrays: slam.process(ranges_m, ...)
    slam = crsm_slam.Slam(**log.settings)
    for scan in log:
        step = slam.process(scan)               # step.state, step.T_map_laser, step.fitness
    print(slam.judge())                         # whether the map can be trusted, and why
    slam.save("out/run")                        # map.png, map.yaml, trajectory.tum, and all that load() needs

Lengths are in metres, angles in radians, counter-clockwise, times in microseconds where they are called utime. A pose is
(x, y, yaw). T_a_b is the pose of frame b in frame a. `python3 -m crsm_slam LOG --out DIR` is the program slam_offline.
"""
from ._crsm_slam import Log, Map, MapChanges, Scan, Slam, State, Step, Tile, Trust, Verdict, presets, version

__version__ = version()
__all__ = ["Log", "Map", "MapChanges", "Scan", "Slam", "State", "Step", "Tile", "Trust", "Verdict", "presets", "version"]
