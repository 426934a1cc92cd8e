"""A Hokuyo that speaks SCIP 2.0, as Hokuyo's document C-42-03320B says."""

import math

from emulator import Emulator


def checksum(text):
    return chr((sum(text.encode()) & 0x3F) + 0x30)


def letters(number, count):
    """6 bits a letter, the highest first."""
    return "".join(chr((number >> 6 * (count - 1 - i) & 0x3F) + 0x30) for i in range(count))


class Hokuyo(Emulator):
    NOTHING_SEEN = 1  # an error code: no object in the range

    def __init__(self, port, scans, rate_hz, first):
        """first: a scan like all of them, from which the laser's steps follow."""
        self.steps_per_turn = round(2 * math.pi / first.angle_step_rad)
        self.last_step = len(first.ranges_m) - 1
        self.front_step = round(-first.angle_min_rad / first.angle_step_rad)
        self.echo = ""
        self.status = "00"        # of BM and MD
        self.scan_status = "99"   # of scans
        self.clock_begins_ms = (1 << 24) - 1500  # its 24 bits are soon at their end
        super().__init__(port, scans, rate_hz)

    def reply(self, echo, status, *lines):
        text = f"{echo}\n{status}{checksum(status)}\n" + "".join(f"{line}\n" for line in lines) + "\n"
        self.answer(text.encode())

    def words(self, *pairs):
        return [f"{key}:{value};{checksum(f'{key}:{value}')}" for key, value in pairs]

    def hear(self):
        while b"\n" in self.heard:
            line, _, self.heard = self.heard.partition(b"\n")
            self.obey(line.decode(errors="replace").strip("\r"))

    def obey(self, command):
        name = command[:2]
        if name == "VV":
            self.reply(command, "00", *self.words(("VEND", "Hokuyo Automatic Co.,Ltd."), ("PROD", "SOKUIKI Sensor"),
                                                  ("FIRM", "3.0.00"), ("PROT", "SCIP 2.0"), ("SERI", "H0000001")))
        elif name == "PP":
            self.reply(command, "00", *self.words(
                ("MODL", "URG-04LX(Hokuyo Automatic Co.,Ltd.)"), ("DMIN", 20), ("DMAX", 30000),
                ("ARES", self.steps_per_turn), ("AMIN", 0), ("AMAX", self.last_step), ("AFRT", self.front_step),
                ("SCAN", round(60 * self.rate_hz))))
        elif name == "II":
            self.reply(command, "00", *self.words(("MODL", "URG-04LX"), ("LASR", "OFF"),
                                                  ("STAT", "Sensor works well.")))
        elif name == "BM":
            self.reply(command, "01" if self.status != "00" else "02" if self.streaming else "00")
        elif name == "QT":
            self.streaming = False
            self.reply(command, "00")
        elif name == "MD":
            self.reply(command, self.status)
            self.streaming = self.status == "00"
            self.echo = command
        elif command:
            self.reply(command, "0E")

    def encode(self, scan):
        if self.scan_status != "99":
            status, self.scan_status = self.scan_status, "99"
            self.streaming = status < "50"
            self.reply(self.echo, status)
            return None
        stamp = letters((self.clock_begins_ms + int(1000 * self.device_s())) % (1 << 24), 4)
        data = "".join(letters(round(1000 * range_m) or self.NOTHING_SEEN, 3) for range_m in scan.ranges_m)
        blocks = [stamp] + [data[i:i + 64] for i in range(0, len(data), 64)]
        return (f"{self.echo}\n99b\n" + "".join(f"{block}{checksum(block)}\n" for block in blocks) + "\n").encode()
