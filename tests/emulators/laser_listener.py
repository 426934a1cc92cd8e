"""Hears LASER on a bus of LCM, and says which of the scans that an emulated laser has sent have come."""

import math
import socket
import struct
import threading

GROUP = "239.255.76.67"
LCM_SHORT_MESSAGE = 0x4C433032


def beams_of(scan):
    """Angle counter-clockwise in [0, 2 pi) and range of all that was seen, by angle."""
    if not hasattr(scan, "beams"):
        scan.beams = sorted(((scan.angle_min_rad + i * scan.angle_step_rad) % (2 * math.pi), range_m)
                            for i, range_m in enumerate(scan.ranges_m) if range_m > 0)
    return scan.beams


class Received:
    """A bot_core.planar_lidar_t."""

    def __init__(self, data):
        self.utime, count = struct.unpack_from(">qi", data, 8)
        self.ranges_m = struct.unpack_from(f">{count}f", data, 20)
        intensities = struct.unpack_from(">i", data, 20 + 4 * count)[0]
        self.angle_min_rad, self.angle_step_rad = struct.unpack_from(">ff", data, 24 + 4 * (count + intensities))

    def shows(self, sent, angle_error_rad, range_error_m):
        """Whether this is what the laser has sent: all that it saw, at its place, and nothing else."""
        mine, theirs = beams_of(self), beams_of(sent)
        if len(mine) != len(theirs):
            return False
        # One that lies at 0 may come just before 2 pi.
        for shift in range(-2, 3):
            turned = mine[shift:] + mine[:shift] if shift else mine
            if all(abs((a - b + math.pi) % (2 * math.pi) - math.pi) <= angle_error_rad and abs(r - s) <= range_error_m
                   for (a, r), (b, s) in zip(turned, theirs)):
                return True
        return False


class LaserListener(threading.Thread):
    def __init__(self, port):
        super().__init__(daemon=True)
        self.scans = []
        self.ended = False
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
        self.socket.bind((GROUP, port))
        self.socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP,
                               socket.inet_aton(GROUP) + socket.inet_aton("0.0.0.0"))
        self.socket.settimeout(0.2)
        self.start()

    def run(self):
        while not self.ended:
            try:
                packet = self.socket.recv(65536)
            except TimeoutError:
                continue
            magic = struct.unpack_from(">I", packet)[0]
            end = packet.find(b"\0", 8)
            if magic == LCM_SHORT_MESSAGE and packet[8:end] == b"LASER":
                self.scans.append(Received(packet[end + 1:]))
        self.socket.close()

    def end(self):
        self.ended = True
        self.join()


def compare(sent, maybe, received, angle_error_rad, range_error_m):
    """How many of `sent` have not come, and how many came that are neither there nor in `maybe`. Both are in order."""
    def shows(scan, other):
        return scan.shows(other, angle_error_rad, range_error_m)

    missing, made_up, at = 0, 0, 0
    waiting = list(received)
    for scan in sent:
        found = next((i for i in range(at, len(waiting)) if shows(waiting[i], scan)), None)
        if found is None:
            missing += 1
        else:
            made_up += sum(not any(shows(extra, other) for other in maybe) for extra in waiting[at:found])
            at = found + 1
    made_up += sum(not any(shows(extra, other) for other in maybe) for extra in waiting[at:])
    return missing, made_up
