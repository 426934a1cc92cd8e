"""A SICK LMS that speaks CoLa A, as SICK's telegram listing 8014631 says."""

import math

from emulator import Emulator


class Sick(Emulator):
    def __init__(self, port, scans, rate_hz):
        self.state = 1          # SCdevicestate: 0 busy, 1 ready, 2 error
        self.contamination = 0  # LCMstate: 0 none, 1 warning, 2 error
        self.status = 0         # of scans: 0 good, 1 error, 2 warning of dirt, 4 too much of it
        self.number = 0
        self.clock_begins_us = (1 << 32) - 1500000  # its 32 bits are soon at their end
        super().__init__(port, scans, rate_hz)

    def telegram(self, text):
        return b"\x02" + text.encode() + b"\x03"

    def hear(self):
        while b"\x03" in self.heard:
            text, _, self.heard = self.heard.partition(b"\x03")
            self.obey(text.rpartition(b"\x02")[2].decode(errors="replace"))

    def obey(self, request):
        if request in ("sEN LMDscandata 0", "sEN LMDscandata 1"):
            self.streaming = request.endswith("1")
            self.answer(self.telegram(f"sEA LMDscandata {request[-1]}"))
        elif request == "sRN DeviceIdent":
            self.answer(self.telegram("sRA DeviceIdent 10 LMS10x_FieldEval 10 V1.36-21.10.2010"))
        elif request == "sRN SCdevicestate":
            self.answer(self.telegram(f"sRA SCdevicestate {self.state}"))
        elif request == "sRN LCMstate":
            self.answer(self.telegram(f"sRA LCMstate {self.contamination}"))
        else:
            self.answer(self.telegram("sFA 1"))

    def encode(self, scan):
        self.number = (self.number + 1) % (1 << 16)
        now_us = (self.clock_begins_us + int(1e6 * self.device_s())) % (1 << 32)
        start = round(math.degrees(scan.angle_min_rad) * 10000) + 900000  # 90 deg is straight ahead
        step = round(math.degrees(scan.angle_step_rad) * 10000)
        distances = " ".join(f"{round(1000 * range_m):X}" for range_m in scan.ranges_m)
        return self.telegram(
            f"sSN LMDscandata 1 1 89A27F 0 {self.status:X} {self.number:X} {self.number:X} {now_us:X} {now_us:X} "
            f"0 0 7 0 0 {round(100 * self.rate_hz):X} 168 0 1 DIST1 3F800000 00000000 {start & 0xFFFFFFFF:X} {step:X} "
            f"{len(scan.ranges_m):X} {distances} 0 0 0 0 0 0")
