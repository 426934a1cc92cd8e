"""What the emulated lasers have in common: a thread that hears requests, and sends the scans of a world in real time.

A laser goes on as it was asked to, whoever is there: it knows nothing of processes that were killed. What it sends can
be damaged on the way, and it can be silent, held back, unplugged, or report a fault.
"""

import math
import random
import threading
import time


class Scan:
    """ranges_m: along beams from angle_min_rad on, counter-clockwise; 0 where nothing is seen."""

    def __init__(self, angle_min_rad, angle_step_rad, ranges_m):
        self.angle_min_rad = angle_min_rad
        self.angle_step_rad = angle_step_rad
        self.ranges_m = ranges_m


def made_up_scans(beams, fov_deg, seed=1):
    """Scans without end, no two alike: ranges from 0.5 to 3.5 m, and some beams that see nothing. As many beams as a
    laser of the whole turn has lie one step short of it."""
    randomness = random.Random(seed)
    step_rad = math.radians(fov_deg) / (beams if fov_deg == 360 else beams - 1)
    while True:
        ranges_m = [0.0 if randomness.random() < 0.05 else randomness.randrange(500, 3500) / 1000 for _ in range(beams)]
        yield Scan(-math.radians(fov_deg) / 2, step_rad, ranges_m)


class Emulator(threading.Thread):
    """scans: an iterable of Scan. rate_hz: of scans. After the last scan nothing more is sent."""

    baud = 115200
    clock_error = 2e-4  # by how much the laser's clock is too fast

    def __init__(self, port, scans, rate_hz):
        super().__init__(daemon=True)
        self.port = port
        self.scans = iter(scans)
        self.rate_hz = rate_hz
        self.sent = []       # scans that went out undamaged
        self.maybe = []      # scans that were damaged, cut off, or sent to nobody: they may come, if as they were
        self.streaming = False
        self.held = False    # it measures nothing
        self.silent = False  # nothing that it says gets through
        self.at_end = False
        self.damages = []    # what is done to the bytes of the next scans, one after the other
        self.noise = b""     # comes before the next scan
        self.lock = threading.RLock()
        self.began = time.monotonic()
        self.due = time.monotonic()
        self.sent_at = 0.0   # the last scan
        self.ended = False
        self.heard = b""
        self.start()

    # ---- for the test

    def damage_next(self, *damages):
        with self.lock:
            self.damages += damages

    def unplug(self):
        with self.lock:
            self.port.unplug()
            self.forget(3)

    def fall_silent(self):
        with self.lock:
            self.silent = True
            self.forget(1)

    def hold(self):
        with self.lock:
            self.held = True

    def forget(self, count):
        """Maybe nobody has heard the last scans, or to their end."""
        with self.lock:
            count = min(count, len(self.sent))
            self.maybe += self.sent[len(self.sent) - count:]
            del self.sent[len(self.sent) - count:]

    def forget_crossing(self):
        """A scan that was under way when it was told to stop is thrown away by whoever told it."""
        if time.monotonic() - self.sent_at < 0.05:
            self.forget(1)

    def plug(self):
        """As a laser that gets its power back, unless streaming is set again."""
        with self.lock:
            self.streaming = False
            self.heard = b""
            self.reset()
            self.port.plug()

    def end(self):
        self.ended = True
        self.join()

    # ---- the laser

    def reset(self):
        """It was switched on."""

    def device_s(self):
        return (time.monotonic() - self.began) * (1 + self.clock_error)

    def run(self):
        while not self.ended:
            with self.lock:
                data = self.port.read(0.002)
                if data is None:
                    self.heard = b""
                elif data and self.understands():
                    self.heard += data
                    self.hear()
                elif data:
                    self.port.write(bytes(random.randrange(128, 256) for _ in range(16)))
                if self.streaming and not self.held and time.monotonic() >= self.due:
                    self.due = max(self.due + 1 / self.rate_hz, time.monotonic() - 0.5)
                    self.send_next(data is not None)
            time.sleep(0.0005)  # for those who wait for the lock

    def understands(self):
        return self.port.baud() in (None, self.baud)

    def answer(self, data):
        if not self.silent:
            self.port.write(data)

    def send_next(self, somebody_hears):
        try:
            scan = next(self.scans)
        except StopIteration:
            self.at_end = True
            self.streaming = False
            return
        data = self.encode(scan)
        if data is None:  # it has said something else, and measured nothing
            return
        damage = self.damages.pop(0) if self.damages and somebody_hears else None
        if damage:
            data = damage(data)
        if self.silent or not somebody_hears:
            return
        if not self.understands():
            data = bytes(random.randrange(128, 256) for _ in range(len(data)))
        whole = self.port.write(self.noise + data) and self.understands()
        self.noise = b""
        self.sent_at = time.monotonic()
        (self.sent if whole and not damage else self.maybe).append(scan)

    def hear(self):
        """Takes requests from self.heard and answers them."""
        raise NotImplementedError

    def encode(self, scan):
        """What the laser sends when it has measured a scan."""
        raise NotImplementedError
