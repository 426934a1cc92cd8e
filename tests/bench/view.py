"""What map_viewer costs: the stack's pace without it and with a page that is open, the viewer's processor time and
memory by the number of pages, bytes on the wire, and frames that a browser draws. See scripts/bench."""

import argparse
import contextlib
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

if "--chromium" in sys.argv:
    sys.path.insert(0, str(stack.PROJECT / "tests/view"))
    from browser import open_chromium  # which may begin this script anew, with Debian's Python

HANDSHAKE = ("GET /live?robot=0 HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
             "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
             "Sec-WebSocket-Protocol: crsm.view.v1\r\n\r\n")
MESSAGE_HEADER_BYTES = 5  # of a record: its kind and size
VERSION_AT = 9            # in the record of a map, behind `anew` and epoch
COUNT_FRAMES = """
const times_ms = window.frame_times_ms = [];
(function count(now_ms) {
  times_ms.push(now_ms);
  requestAnimationFrame(count);
})(performance.now());
"""


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


def open_browser(port):
    """A page in headless Chromium, which counts the frames that it draws from now on."""
    browser = open_chromium("1440,960")
    browser.get(f"http://127.0.0.1:{port}/")
    browser.execute_script(COUNT_FRAMES)
    return browser


def close_browser(browser):
    """Frames in a second, the longest [ms] of 99 in 100 frames, and what one took of the processor [ms]."""
    times_ms = browser.execute_script("return window.frame_times_ms")
    used_s = processor_time_below(browser.service.process.pid)
    browser.quit()
    frames_ms = sorted(after - before for before, after in zip(times_ms, times_ms[1:]))
    return (1e3 * len(frames_ms) / sum(frames_ms), frames_ms[int(0.99 * len(frames_ms))],
            1e3 * used_s / len(frames_ms))


def processor_time_below(pid):
    """Seconds of a process and of all below it that run."""
    used_ticks, parents = {}, {}
    for path in pathlib.Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):  # it has ended meanwhile
            fields = path.read_text().rsplit(")", 1)[1].split()
            used_ticks[path.parent.name] = int(fields[11]) + int(fields[12])
            parents[path.parent.name] = fields[1]
    below = {str(pid)}
    while more := {child for child, parent in parents.items() if parent in below} - below:
        below |= more
    return sum(used_ticks[process] for process in below) / os.sysconf("SC_CLK_TCK")


def peak_memory_mb(pid):
    status = pathlib.Path(f"/proc/{pid}/status").read_text()
    return int(status.split("VmHWM:")[1].split()[0]) * 1024 / 1e6


class Viewer:
    """map_viewer, and pages that are open."""

    def __init__(self, flags, out, num_pages, with_browser):
        with socket.create_server(("127.0.0.1", 0)) as probe:
            port = probe.getsockname()[1]
        self.program = stack.Program("map_viewer", [*flags, "--http", f"127.0.0.1:{port}"], out)
        self.program.await_ready()
        self.pages = subprocess.Popen([sys.executable, __file__, "--drain", str(port), str(num_pages)],
                                      stdout=subprocess.PIPE, text=True) if num_pages else None
        self.browser = open_browser(port) if with_browser else None
        time.sleep(0.5)

    def end(self):
        """Seconds of the processor, memory [MB], bytes and versions that one page got, and frames of the browser."""
        frames = close_browser(self.browser) if self.browser else None
        memory_mb = peak_memory_mb(self.program.popen.pid)
        self.program.popen.terminate()
        used = sum(self.program.processor_time())
        num_bytes, num_versions = map(int, self.pages.communicate()[0].split()) if self.pages else (0, 0)
        return used, memory_mb, num_bytes, num_versions, frames


def run(log, flags, out, rate, num_pages, with_browser=False):
    """num_pages: None for no viewer. Returns the seconds that the stack took, and what Viewer.end says."""
    out.mkdir(parents=True)
    flags = [*flags, "--lcm-url", f"udpm://239.255.76.67:{21000 + os.getpid() % 11000}?ttl=0"]
    lockstep = rate == "max"
    services = [stack.Program(name, [part.format(out=out) for part in own if lockstep or part != "--lockstep"] +
                              (flags if name != "map_viewer" else []), out,
                              stack.shared_core(name) if lockstep else None) for name, own in stack.SERVICES.items()]
    for service in services:
        service.await_ready()
    viewer = Viewer(flags[-2:], out, num_pages, with_browser) if num_pages is not None else None
    publisher = stack.Program("laser_publisher", [log, "--rate", rate, *flags], out,
                              stack.shared_core("laser_publisher") if lockstep else None)
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


def compare_pace(name, log, flags, folder, num_runs):
    ratios = []
    for number in range(num_runs):
        without, _ = run(log, flags, folder / f"without{number}", "max", None)
        beside, _ = run(log, flags, folder / f"beside{number}", "max", 1)
        ratios.append(beside / without)
    scans = stack.num_scans(folder / "without0")
    print(f"{name}: {scans} scans; in lockstep with a viewer and a page {statistics.median(ratios):.3f} times the time "
          f"without ({min(ratios):.3f} to {max(ratios):.3f}, {num_runs} runs)")


def count_pages(log, flags, folder, rate, with_browser, counts):
    print(f"at {rate} times the pace of the log{', and a page in headless Chromium besides' if with_browser else ''}:")
    print("pages  processor of the viewer [%]  its memory [MB]  to a page [kB/s]  whole grids instead [kB/s]")
    for num_pages in counts:
        out = folder / f"pages{num_pages}"
        elapsed_s, seen = run(log, flags, out, rate, num_pages, with_browser)
        used_s, memory_mb, num_bytes, num_versions, frames = seen
        print(f"{num_pages:5} {100 * used_s / elapsed_s:29.1f} {memory_mb:16.0f} {num_bytes / elapsed_s / 1e3:17.0f} "
              f"{num_versions * whole_grid_bytes(out) / elapsed_s / 1e3:27.0f}")
        if frames:
            print("      {:.0f} frames/s in Chromium, 99 in 100 of them within {:.0f} ms; one takes {:.0f} ms of a "
                  "processor".format(*frames))


def main():
    if sys.argv[1:2] == ["--drain"]:
        return drain(int(sys.argv[2]), int(sys.argv[3]))
    parser = argparse.ArgumentParser(prog="scripts/bench view")
    parser.add_argument("log", nargs="?", default="sim:demo")
    parser.add_argument("--runs", type=int, default=5, help="pairs of runs in lockstep; 0: none")
    parser.add_argument("--rate", default="10", help="at which pages are counted and the viewer's time is taken")
    parser.add_argument("--pages", type=int, nargs="+", default=[0, 1, 20], metavar="N")
    parser.add_argument("--chromium", action="store_true", help="a page in a browser besides, whose frames are counted")
    arguments, flags = parser.parse_known_args()
    with tempfile.TemporaryDirectory(prefix="crsm_bench_") as name:
        folder = pathlib.Path(name)
        log = folder / "scans.lcm"
        stack.convert(arguments.log, log)
        if arguments.runs:
            compare_pace(arguments.log, log, flags, folder, arguments.runs)
        count_pages(log, flags, folder, arguments.rate, arguments.chromium, arguments.pages)
    return 0


if __name__ == "__main__":
    sys.exit(main())
