"""Where places of a map are in the simulated world that it is of."""
import math


def read_path(path):
    rows = [line.split() for line in path.read_text().splitlines() if not line.startswith("#")]
    return {row[0]: (float(row[1]), float(row[2])) for row in rows}


def find_motion(found, true):
    """The rotation and shift that lay the found path on the true one best: cos, sin, x, y."""
    pairs = [(found[time], true[time]) for time in found if time in true]
    mean = [sum(pair[side][axis] for pair in pairs) / len(pairs) for side in (0, 1) for axis in (0, 1)]
    dot = cross = 0.0
    for (ax, ay), (bx, by) in pairs:
        ax, ay, bx, by = ax - mean[0], ay - mean[1], bx - mean[2], by - mean[3]
        dot += ax * bx + ay * by
        cross += ax * by - ay * bx
    yaw = math.atan2(cross, dot)
    cos, sin = math.cos(yaw), math.sin(yaw)
    return cos, sin, mean[2] - cos * mean[0] + sin * mean[1], mean[3] - sin * mean[0] - cos * mean[1]


def move(motion, point):
    cos, sin, x, y = motion
    return cos * point[0] - sin * point[1] + x, sin * point[0] + cos * point[1] + y
