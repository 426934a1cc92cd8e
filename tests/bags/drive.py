"""A simulated drive as an LCM log, read and written here by the book and not by the project's own code."""

import dataclasses
import math
import struct

SYNC = 0xEDA1DA01
MOUNTING = (0.25, -0.1, math.pi / 2)  # x, y, yaw of the laser on the robot


@dataclasses.dataclass
class Sweep:
    utime: int
    angle_min: float
    angle_increment: float
    ranges: list
    pose: tuple = None  # x, y, z of the robot, and its quaternion w, x, y, z

    @property
    def stamp(self):
        """Seconds and nanoseconds."""
        return self.utime // 1000000, self.utime % 1000000 * 1000

    @property
    def robot(self):
        """x, y, yaw of the robot that carries the laser along this path."""
        yaw = 2 * math.atan2(self.pose[6], self.pose[3]) - MOUNTING[2]
        cos, sin = math.cos(yaw), math.sin(yaw)
        return (self.pose[0] - cos * MOUNTING[0] + sin * MOUNTING[1],
                self.pose[1] - sin * MOUNTING[0] - cos * MOUNTING[1], yaw)

    def as_json(self):
        return {"sec": self.stamp[0], "nsec": self.stamp[1], "angle_min": self.angle_min, "pose": self.pose,
                "robot": self.robot if self.pose else None, "mounting": MOUNTING,
                "angle_increment": self.angle_increment, "ranges": self.ranges}


def events_of(log):
    while head := log.read(28):
        sync, _, _, num_channel, num_data = struct.unpack(">IqqII", head)
        assert sync == SYNC
        yield head, log.read(num_channel), log.read(num_data)


def read_drive(path, most):
    """The first sweeps, each with its true pose for its odometry."""
    sweeps = []
    with open(path, "rb") as log:
        for _, channel, data in events_of(log):
            if channel == b"LASER":
                if len(sweeps) == most:
                    break
                utime, num = struct.unpack_from(">qi", data, 8)
                ranges = list(struct.unpack_from(f">{num}f", data, 20))
                angle_min, increment = struct.unpack_from(">ff", data, 24 + 4 * num)
                sweeps.append(Sweep(utime, angle_min, increment, ranges))
            elif channel == b"TRUE_POSE":
                values = struct.unpack_from(">q16d", data, 8)
                if sweeps and values[0] == sweeps[-1].utime:
                    sweeps[-1].pose = (*values[1:4], *values[7:11])
    return sweeps


def read_odometry(path):
    """Each pose on ODOMETRY: x, y, z and the quaternion w, x, y, z."""
    with open(path, "rb") as log:
        values = [struct.unpack_from(">q16d", data, 8) for _, channel, data in events_of(log) if channel == b"ODOMETRY"]
    return [(*value[1:4], *value[7:11]) for value in values]


def copy_as_odometry(path, to, most):
    """The same scans, the true poses as ODOMETRY."""
    num_scans = 0
    with open(path, "rb") as log, open(to, "wb") as copy:
        for head, channel, data in events_of(log):
            num_scans += channel == b"LASER"
            if num_scans > most:
                break
            if channel == b"TRUE_POSE":
                channel = b"ODOMETRY"
            copy.write(head[:20] + struct.pack(">II", len(channel), len(data)) + channel + data)


def write_carmen(sweeps, path):
    with open(path, "w", encoding="ascii") as log:
        for sweep in sweeps:
            ranges = " ".join(map(repr, sweep.ranges))
            time = f"{sweep.utime // 1000000}.{sweep.utime % 1000000:06d}"
            log.write(f"ROBOTLASER1 0 {sweep.angle_min!r} 0 {sweep.angle_increment!r} 0 0 0 "
                      f"{len(sweep.ranges)} {ranges} 0 0 0 0 0 0 0 0 0 0 0 0 {time} host {time}\n")
