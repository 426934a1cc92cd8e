"""Passes packets between processes that are each on a bus of their own: late, in another order, twice, or not at all.

usage: relay.py SEED PORT...
What comes on one port goes to all others. Each copy goes its own way. SIGTERM ends it, and it says what it did.
"""

import heapq
import random
import select
import signal
import socket
import sys
import time

GROUP = "239.255.76.67"
LOST, LATE, TWICE = 0.05, 0.3, 0.05  # shares of the copies
LONGEST_S = 0.5


def listen(port):
    listener = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 21)
    listener.bind((GROUP, port))
    listener.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP,
                        socket.inet_aton(GROUP) + socket.inet_aton("0.0.0.0"))
    listener.setblocking(False)
    return listener


def delays(randomness, counts):
    """After how long each copy of a packet arrives: none, one or two."""
    counts["sent"] += 1
    if randomness.random() < LOST:
        counts["lost"] += 1
        return
    late = randomness.random() < LATE
    counts["late"] += late
    yield LONGEST_S * randomness.random() if late else 0.0
    if randomness.random() < TWICE:
        counts["twice"] += 1
        yield LONGEST_S * randomness.random()


def relay(randomness, ports, counts):
    listeners = {listen(port): port for port in ports}
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
    sender.bind(("", 0))
    own_port = sender.getsockname()[1]
    waiting = []  # when, a number that tells two of one moment apart, port, packet
    number = 0
    print("relay: ready", flush=True)
    while True:
        timeout_s = max(0.0, waiting[0][0] - time.monotonic()) if waiting else None
        for listener in select.select(listeners, [], [], timeout_s)[0]:
            packet, source = listener.recvfrom(65536)
            if source[1] == own_port:
                continue
            for port in ports:
                for delay_s in delays(randomness, counts) if port != listeners[listener] else ():
                    number += 1
                    heapq.heappush(waiting, (time.monotonic() + delay_s, number, port, packet))
        while waiting and waiting[0][0] <= time.monotonic():
            _, _, port, packet = heapq.heappop(waiting)
            sender.sendto(packet, (GROUP, port))


def main():
    counts = dict.fromkeys(("sent", "lost", "late", "twice"), 0)

    def end(*_):
        print(" ".join(f"{name} {count}" for name, count in counts.items()), flush=True)
        sys.exit(0)

    signal.signal(signal.SIGTERM, end)
    relay(random.Random(int(sys.argv[1])), [int(port) for port in sys.argv[2:]], counts)


main()
