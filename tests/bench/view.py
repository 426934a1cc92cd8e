"""What map_viewer costs: the stack's pace without it and with a page that is open, the viewer's processor time by the
number of pages, and bytes on the wire. See scripts/bench."""

import argparse
import os
import pathlib
import selectors
import socket
import statistics
import subprocess
import sys
import tempfile
import time

import stack

HANDSHAKE = ("GET /live?robot=0 HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
             "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
             "Sec-WebSocket-Protocol: crsm.view.v1\r\n\r\n")
MESSAGE_HEADER_BYTES = 5  # of a record: its kind and size
VERSION_AT = 9            # in the record of a map, behind `anew` and epoch


def drain(port, count):
    """Opens pages, takes what comes until the viewer ends, and prints how many bytes came to one of them, in how many
    messages, and with how many versions of the map."""
    chooser = selectors.DefaultSelector()
    first = None
    num_bytes = num_versions = version = 0
    rest = bytearray()
    for _ in range(count):
        page = socket.create_connection(("127.0.0.1", port))
        page.sendall(HANDSHAKE.encode())
        chooser.register(page, selectors.EVENT_READ)
        first = first or page
    open_pages = count
    while open_pages:
        for key, _ in chooser.select():
            try:
                data = key.fileobj.recv(1 << 20)
            except ConnectionError:
                data = b""
            if not data:
                chooser.unregister(key.fileobj)
                open_pages -= 1
            elif key.fileobj is first:
                num_bytes += len(data)
                rest += data
                for payload in take_messages(rest, key.fileobj):
                    newest = version_in(payload, version)
                    num_versions += newest != version
                    version = newest
    print(num_bytes, num_versions)


def take_messages(rest, page):
    """The whole messages at the beginning of `rest`, which go from it. A ping is answered."""
    if rest.startswith(b"HTTP"):
        end = rest.find(b"\r\n\r\n")
        if end < 0:
            return
        del rest[:end + 4]
    while len(rest) >= 2:
        size, head = rest[1] & 0x7f, 2
        if size >= 126:
            head = 4 if size == 126 else 10
            if len(rest) < head:
                return
            size = int.from_bytes(rest[2:head], "big")
        if len(rest) < head + size:
            return
        opcode, payload = rest[0] & 15, bytes(rest[head:head + size])
        del rest[:head + size]
        if opcode == 9:
            page.sendall(b"\x8a" + bytes([0x80 | len(payload)]) + b"\0\0\0\0" + payload)
        else:
            yield payload


def version_in(payload, version):
    """Of the map that a message completes; `version` where it has none."""
    at = 0
    while at < len(payload):
        kind, size = payload[at], int.from_bytes(payload[at + 1:at + 5], "little")
        if kind == 1:
            begin = at + MESSAGE_HEADER_BYTES + VERSION_AT
            version = int.from_bytes(payload[begin:begin + 8], "little")
        at += MESSAGE_HEADER_BYTES + size
    return version


class Viewer:
    """map_viewer, and pages that are open."""

    def __init__(self, flags, out, num_pages):
        with socket.create_server(("127.0.0.1", 0)) as probe:
            port = probe.getsockname()[1]
        self.program = stack.Program("map_viewer", [*flags, "--http", f"127.0.0.1:{port}"], out)
        self.program.await_ready()
        self.pages = subprocess.Popen([sys.executable, __file__, "--drain", str(port), str(num_pages)],
                                      stdout=subprocess.PIPE, text=True) if num_pages else None
        time.sleep(0.5)

    def end(self):
        """Seconds of the processor, and bytes and versions that one page got."""
        self.program.popen.terminate()
        used = sum(self.program.processor_time())
        num_bytes, num_versions = map(int, self.pages.communicate()[0].split()) if self.pages else (0, 0)
        return used, num_bytes, num_versions


def run(log, flags, out, rate, num_pages):
    """num_pages: None for no viewer. Returns the seconds that the stack took, and what Viewer.end says."""
    out.mkdir(parents=True)
    flags = [*flags, "--lcm-url", f"udpm://239.255.76.67:{21000 + os.getpid() % 11000}?ttl=0"]
    lockstep = rate == "max"
    services = [stack.Program(name, [part.format(out=out) for part in own if lockstep or part != "--lockstep"] +
                              (flags if name != "map_viewer" else []), out) for name, own in stack.SERVICES.items()]
    for service in services:
        service.await_ready()
    viewer = Viewer(flags[-2:], out, num_pages) if num_pages is not None else None
    publisher = stack.Program("laser_publisher", [log, "--rate", rate, *flags], out)
    begin = time.monotonic()
    publisher.processor_time()
    elapsed_s = time.monotonic() - begin
    time.sleep(1.0 if viewer else 0.0)  # for the last version
    seen = viewer.end() if viewer else None
    for service in sorted(services, key=lambda service: service.name != "map_exporter"):  # it goes first
        service.popen.terminate()
        service.processor_time()
    return elapsed_s, seen


def whole_grid_bytes(out):
    """Of the map as one picture without compression."""
    content = (out / "map.png").read_bytes()
    return int.from_bytes(content[16:20], "big") * int.from_bytes(content[20:24], "big")


def main():
    if sys.argv[1:2] == ["--drain"]:
        return drain(int(sys.argv[2]), int(sys.argv[3]))
    parser = argparse.ArgumentParser(prog="scripts/bench view")
    parser.add_argument("log", nargs="?", default="sim:demo")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--rate", default="10", help="at which pages are counted and the viewer's time is taken")
    arguments, flags = parser.parse_known_args()
    with tempfile.TemporaryDirectory(prefix="crsm_bench_") as name:
        folder = pathlib.Path(name)
        log = folder / "scans.lcm"
        stack.convert(arguments.log, log)
        ratios = []
        for number in range(arguments.runs):
            without, _ = run(log, flags, folder / f"without{number}", "max", None)
            beside, _ = run(log, flags, folder / f"beside{number}", "max", 1)
            ratios.append(beside / without)
        scans = stack.num_scans(folder / "without0")
        print(f"{arguments.log}: {scans} scans; in lockstep with a viewer and a page "
              f"{statistics.median(ratios):.3f} times the time without "
              f"({min(ratios):.3f} to {max(ratios):.3f}, {arguments.runs} runs)")
        print(f"at {arguments.rate} times the pace of the log:")
        print("pages  processor of the viewer [%]  to a page [kB/s]  whole grids instead [kB/s]")
        for num_pages in (0, 1, 20):
            out = folder / f"pages{num_pages}"
            elapsed_s, (used_s, num_bytes, num_versions) = run(log, flags, out, arguments.rate, num_pages)
            print(f"{num_pages:5} {100 * used_s / elapsed_s:29.1f} {num_bytes / elapsed_s / 1e3:17.0f} "
                  f"{num_versions * whole_grid_bytes(out) / elapsed_s / 1e3:27.0f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
