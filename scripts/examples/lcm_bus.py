"""LCM over UDP multicast in pure Python, for systems without LCM's Python package, such as Debian 12.

The protocol is LCM's own (https://lcm-proj.github.io/lcm/content/udp-multicast-protocol.html): a packet is a small message,
or a fragment of a larger one. If you have the package `lcm`, its class LCM does the same and more.
"""

import os
import re
import select
import socket
import struct
import time

SMALL, FRAGMENT = 0x4C433032, 0x4C433033  # LC02, LC03
SMALL_HEADER, FRAGMENT_HEADER = struct.Struct(">II"), struct.Struct(">IIIIHH")
LARGEST_SMALL = 65_000  # bytes: what one packet takes, with its header
LARGEST_MESSAGE = 64 << 20
MOST_INCOMPLETE = 16  # messages, of which fragments have come: the oldest gives way


class LcmBus:
    """Messages in and out. All that this process says comes from one socket: who listens knows it by that."""

    def __init__(self, url=None):
        url = url or os.environ.get("LCM_DEFAULT_URL") or "udpm://239.255.76.67:7667?ttl=0"
        form = re.fullmatch(r"udpm://([0-9.]*)(?::(\d+))?(?:\?(.*))?", url)
        if not form:
            raise ValueError(f"{url}: not a bus by UDP multicast, as udpm://239.255.76.67:7667?ttl=0")
        self._group = (form[1] or "239.255.76.67", int(form[2] or 7667))
        options = dict(option.split("=", 1) for option in (form[3] or "").split("&") if "=" in option)
        self._out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._out.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, int(options.get("ttl", 0)))
        self._in = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._in.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._in.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        self._in.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2 << 20)
        self._in.bind(self._group)
        try:
            member = socket.inet_aton(self._group[0]) + socket.inet_aton("0.0.0.0")
            self._in.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)
        except OSError as error:
            raise OSError(f"{url}: no multicast route for LCM; as root: ip link set lo up multicast on; "
                          "ip route add 224.0.0.0/4 dev lo") from error
        self._sequence = 0
        self._handlers = {}
        self._incomplete = {}

    def subscribe(self, channel, message_type, handler):
        """Calls `handler` with each message on a channel. What is of another type, or cut, is passed over."""
        self._handlers[channel] = (message_type, handler)

    def publish(self, channel, message):
        name, payload = channel.encode() + b"\0", message.encode()
        self._sequence = (self._sequence + 1) % 2**32
        if len(name) + len(payload) <= LARGEST_SMALL:
            self._out.sendto(SMALL_HEADER.pack(SMALL, self._sequence) + name + payload, self._group)
            return
        starts = range(0, len(payload), LARGEST_SMALL - len(name))
        for number, start in enumerate(starts):
            header = FRAGMENT_HEADER.pack(FRAGMENT, self._sequence, len(payload), start, number, len(starts))
            part = payload[start:start + starts.step]
            self._out.sendto(header + (name if number == 0 else b"") + part, self._group)

    def handle(self, timeout_s):
        """Handles one packet, waiting for it no longer than that. Whether one came."""
        if not select.select([self._in], [], [], timeout_s)[0]:
            return False
        packet, sender = self._in.recvfrom(65536)
        whole = self._take(packet, sender)
        if whole and whole[0] in self._handlers:
            message_type, handler = self._handlers[whole[0]]
            try:
                message = message_type.decode(whole[1])
            except (ValueError, struct.error, UnicodeDecodeError, MemoryError):
                return True
            handler(message)
        return True

    def _take(self, packet, sender):
        """Channel and bytes of a message that is whole now; nothing of others."""
        if len(packet) >= SMALL_HEADER.size and SMALL_HEADER.unpack_from(packet)[0] == SMALL:
            return self._split(packet[SMALL_HEADER.size:])
        if len(packet) < FRAGMENT_HEADER.size:
            return None
        magic, sequence, size, start, number, count = FRAGMENT_HEADER.unpack_from(packet)
        if magic != FRAGMENT or size > LARGEST_MESSAGE:
            return None
        parts = self._incomplete.setdefault((sender, sequence), {})
        parts[number] = (start, packet[FRAGMENT_HEADER.size:])
        while len(self._incomplete) > MOST_INCOMPLETE:
            del self._incomplete[next(iter(self._incomplete))]
        if len(parts) < count:
            return None
        self._incomplete.pop((sender, sequence), None)
        return self._split(b"".join(part for _, part in sorted(parts.values())))

    @staticmethod
    def _split(packet):
        name, separator, payload = packet.partition(b"\0")
        return (name.decode(errors="replace"), payload) if separator else None


def now_utime():
    """Microseconds since the epoch, as messages have them."""
    return time.time_ns() // 1000
