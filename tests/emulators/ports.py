"""Where an emulated laser is to be found: a TCP port, or a pseudo-terminal in the place of a serial port. Both can be
unplugged and plugged in again."""

import contextlib
import fcntl
import os
import select
import socket
import struct
import time
import tty

TCGETS2 = 0x802C542A  # struct termios2: four flags, line and 19 characters, two speeds


class TcpPort:
    def __init__(self):
        self.client = None
        self.server = None
        self.number = 0
        self.plug()

    def plug(self):
        self.server = socket.create_server(("127.0.0.1", self.number), reuse_port=True)
        self.number = self.server.getsockname()[1]

    def unplug(self):
        """Whoever connects is refused then."""
        self.server.close()
        self._end()

    def _end(self):
        if self.client:
            self.client.close()
        self.client = None

    @property
    def address(self):
        return f"tcp://127.0.0.1:{self.number}"

    def baud(self):
        return None

    def read(self, longest_s):
        """What has come; None where nobody is there."""
        waits_for = self.client or self.server
        try:
            if not select.select([waits_for], [], [], longest_s)[0]:
                return b"" if self.client else None
            if not self.client:
                self.client = self.server.accept()[0]
                self.client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                return b""
            data = self.client.recv(4096)
        except (OSError, ValueError):  # was unplugged meanwhile, or the other side was killed
            data = None
        if not data:
            self._end()
            return None
        return data

    def write(self, data):
        """Whether all went out."""
        if not self.client:
            return False
        try:
            self.client.settimeout(5)
            self.client.sendall(data)
            return True
        except OSError:
            self._end()
            return False


class PtyPort:
    """path: of the link that is there while the laser is plugged in."""

    def __init__(self, path):
        self.path = path
        self.master = None
        self.plug()

    def plug(self):
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)  # held open, or the end of a driver would end the terminal
        os.set_blocking(self.master, False)
        os.symlink(os.ttyname(self.slave), self.path)

    def unplug(self):
        os.unlink(self.path)
        os.close(self.master)
        os.close(self.slave)
        self.master = None

    @property
    def address(self):
        return str(self.path)

    def baud(self):
        """That the driver has set."""
        return struct.unpack("4I20B2I", fcntl.ioctl(self.master, TCGETS2, bytes(44)))[-1]

    def read(self, longest_s):
        if self.master is None:
            time.sleep(longest_s)
            return None
        if select.select([self.master], [], [], longest_s)[0]:
            with contextlib.suppress(BlockingIOError):
                return os.read(self.master, 4096)
        return b""

    def write(self, data):
        """Whether all went out: what nobody reads is lost, as on a serial line."""
        while data and self.master is not None:
            if not select.select([], [self.master], [], 1)[1]:
                return False
            with contextlib.suppress(BlockingIOError):
                data = data[os.write(self.master, data):]
        return self.master is not None
