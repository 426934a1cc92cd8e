"""An RPLidar A2, as SLAMTEC's "RPLIDAR Interface Protocol and Application Notes" says."""

import math
import struct

from emulator import Emulator

SAMPLE_US = 508


class Rplidar(Emulator):
    def __init__(self, port, scans, rate_hz):
        self.health = (0, 0)     # status and error code
        self.motor_turns = True
        super().__init__(port, scans, rate_hz)

    def hear(self):
        while len(self.heard) >= 2:
            start, request = self.heard[:2]
            if start != 0xA5:
                self.heard = self.heard[1:]
                continue
            size = 2
            if request & 0x80:  # with a payload: its size, itself, and a checksum
                if len(self.heard) < 3 or len(self.heard) < 4 + self.heard[2]:
                    return
                size = 4 + self.heard[2]
            self.heard = self.heard[size:]
            self.obey(request)

    def obey(self, request):
        if request == 0x25:  # STOP, which has no answer
            self.streaming = False
            self.forget_crossing()
        elif request == 0x50:  # GET_INFO: model, firmware, hardware, serial number
            self.answer(b"\xA5\x5A\x14\x00\x00\x00\x04" + bytes([0x28, 29, 1, 7]) + bytes(range(16)))
        elif request == 0x52:  # GET_HEALTH
            self.answer(b"\xA5\x5A\x03\x00\x00\x00\x06" + struct.pack("<BH", *self.health))
        elif request == 0x59:  # GET_SAMPLERATE
            self.answer(b"\xA5\x5A\x04\x00\x00\x00\x15" + struct.pack("<HH", SAMPLE_US, 250))
        elif request == 0x20 and self.health[0] != 2:  # SCAN
            self.answer(b"\xA5\x5A\x05\x00\x00\x40\x81")
            self.streaming = self.motor_turns

    def encode(self, scan):
        """A whole turn, clockwise: of a scan that goes the other way, from straight ahead."""
        beams = [(math.degrees(-(scan.angle_min_rad + i * scan.angle_step_rad)) % 360, range_m)
                 for i, range_m in enumerate(scan.ranges_m)]
        if scan.angle_step_rad > 0:
            beams.sort()
        data = b""
        for number, (angle_deg, range_m) in enumerate(beams):
            starts, quality = number == 0, 15 if range_m else 0
            data += struct.pack("<BHH", quality << 2 | (1 if starts else 2), round(angle_deg * 64) << 1 | 1,
                                round(range_m * 4000))
        return data
