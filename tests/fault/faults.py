"""What the fault tests share: the programs, logs of scans, hosts on a network of their own, a look at the bus.

A test is a file beside this one that calls run(test) at its end. test(case) prints figures, and raises Failure or
Skipped where it does not pass.
"""

import argparse
import contextlib
import filecmp
import itertools
import json
import os
import pathlib
import re
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time

PROJECT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("CRSM_BIN_DIR", PROJECT / "build/bin"))
SERVICES = ["map_updater", "loop_closer", "rrhc_matcher", "ray_selector", "map_exporter"]
RESULTS = ["map.png", "trajectory.tum"]
GROUP = "239.255.76.67"
SKIPPED = 77  # exit code

LCM_RING_BYTES = 204800  # LCM's buffer for what it received: its pages are taken when a queue first gets that long


def may_grow_bytes(settled_bytes):
    """By how much the memory of a process may grow once it has settled, however long it runs: 1 %, some pages; LCM."""
    return max(0.01 * settled_bytes, 3e5) + LCM_RING_BYTES


class Failure(Exception):
    """What is wrong, with the numbers."""


class Skipped(Exception):
    """Why the test cannot run here."""


def check(condition, text):
    if not condition:
        raise Failure(text)


def need_root():
    if os.geteuid() != 0:
        raise Skipped("needs root")


def need_program(*names):
    for name in names:
        if not shutil.which(name):
            raise Skipped(f"there is no program {name}")


class Case:
    """One run of a test: how thorough, and where its files go."""

    def __init__(self, quick, long, out):
        self.quick = quick
        self.long = long
        self.out = out

    def say(self, text):
        print(f"  {text}", flush=True)

    def folder(self, name):
        folder = self.out / name
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        return folder

    def logs(self):
        """Name, LCM log and flags of each course: a simulated one always, a real one where it is there."""
        courses = [("sim:demo", "sim:demo", [])]
        real = PROJECT.parent / "shared/data/radish/fr079.clf.gz"
        if real.exists():
            courses.append(("fr079", real, ["--preset", "sick"]))
        else:
            self.say(f"without the real log: there is no {real}")
        for name, source, flags in courses:
            yield name, self.convert(name.replace(":", "_"), source), flags

    def logs_that_come_back(self):
        """As logs(), of courses on which loops are closed."""
        yield "sim:block", self.convert("sim_block", "sim:block"), ["--preset", "sick"]

    def logs_that_break(self):
        """As logs(), of a robot that is carried, and later goes on after a gap: trajectories that are joined."""
        drives = [read_log(self.convert(f"demo_{seed}", "sim:demo", seed)) for seed in (1, 2)]
        scans = []
        for drive, begin, end, later_us in ((0, 0.0, 0.55, 0), (1, 0.2, 0.6, 200_000), (0, 0.4, 1.0, 20_000_000)):
            part = drives[drive][int(begin * len(drives[drive])):int(end * len(drives[drive]))]
            shift = utime_of(scans[-1]) + later_us - utime_of(part[0]) if scans else 0
            scans += [with_utime(scan, utime_of(scan) + shift) for scan in part]
        path = self.out / "broken.lcm"
        write_log(path, scans[::3])
        yield "a robot that is carried", path, []

    def convert(self, name, source, seed=1):
        """An LCM log of what the publisher reads from `source`."""
        path = self.out / f"{name}.lcm"
        subprocess.run([BIN / "laser_publisher", source, "--seed", str(seed), "--lcm-url", f"file://{path}?mode=w"],
                       check=True, stderr=subprocess.DEVNULL)
        return path

    def convert_long(self, course, num_scans, rate_hz=10, stands=False, source=None):
        """A log of a simulated robot that drives to and fro, or stands where it began. Returns its path and the number of
        scans of one way."""
        one_way = read_log(self.convert(course, source or f"sim:{course}"))
        first_utime = utime_of(one_way[0])
        scans = itertools.repeat(one_way[0]) if stands else to_and_fro(one_way)
        path = self.out / "long.lcm"
        write_log(path, (with_utime(scan, first_utime + number * 1000000 // rate_hz)
                         for number, scan in enumerate(itertools.islice(scans, num_scans))))
        return path, 1 if stands else len(one_way)


def run(test):
    """The main function of a test."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--long", action="store_true")
    parser.add_argument("--out", type=pathlib.Path)
    arguments = parser.parse_args()
    with contextlib.ExitStack() as stack:
        out = arguments.out or pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="crsm_fault_")))
        out.mkdir(parents=True, exist_ok=True)
        name = pathlib.Path(sys.argv[0]).stem
        begin = time.monotonic()
        try:
            test(Case(arguments.quick, arguments.long, out.resolve()))
            print(f"PASS {name}, {time.monotonic() - begin:.0f} s")
        except Skipped as reason:
            print(f"SKIPPED {name}: {reason}")
            sys.exit(SKIPPED)
        except Failure as reason:
            print(f"FAIL {name}: {reason}")
            sys.exit(1)
        except subprocess.CalledProcessError as error:
            print(f"FAIL {name}: {error} {error.stderr or ''}")
            sys.exit(1)


# ---- processes


class Program:
    """A program that runs, and dies with this process. Its stderr goes to a file."""

    def __init__(self, command, log, host=None, environment=None):
        command = [str(part) for part in command]
        if "/" not in command[0]:
            command[0] = str(BIN / command[0])
        self.name = pathlib.Path(command[0]).name
        self.log = log
        with open(log, "wb") as stderr:
            self.popen = subprocess.Popen(
                ["setpriv", "--pdeathsig", "TERM", *(host.enter if host else []), *command], stdin=subprocess.DEVNULL,
                stdout=stderr, stderr=stderr, env={**os.environ, "CRSM_BIN_DIR": str(BIN), **(environment or {})})
        self.pid = self.popen.pid

    def errors(self):
        return self.log.read_text(errors="replace")

    def await_ready(self):
        await_condition(lambda: f"{self.name}: ready" in self.errors() or self.popen.poll() is not None, 30)
        check(self.popen.poll() is None, f"{self.name} ended: {self.errors()[-500:]}")

    def interrupt(self):
        self.popen.send_signal(signal.SIGINT)
        return self.wait()

    def wait(self, timeout_s=1800):
        try:
            return self.popen.wait(timeout_s)
        except subprocess.TimeoutExpired:
            self.popen.kill()
            raise Failure(f"{self.name} did not end within {timeout_s} s") from None


def await_condition(condition, timeout_s, period_s=0.005):
    give_up = time.monotonic() + timeout_s
    while not condition():
        check(time.monotonic() < give_up, f"nothing came of it within {timeout_s} s")
        time.sleep(period_s)


def child(parent, name):
    """Process id of the living child with this name; None if there is none."""
    with contextlib.suppress(OSError):
        for pid in pathlib.Path(f"/proc/{parent}/task/{parent}/children").read_text().split():
            with contextlib.suppress(OSError):
                comm, rest = pathlib.Path(f"/proc/{pid}/stat").read_text().partition("(")[2].rsplit(") ", 1)
                if comm == name[:15] and not rest.startswith("Z"):
                    return int(pid)
    return None


def resident_bytes(pid):
    return int(pathlib.Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE")


def peak_bytes(pid):
    """The most that was resident so far."""
    return 1024 * int(re.search(r"VmHWM:\s*(\d+) kB", pathlib.Path(f"/proc/{pid}/status").read_text()).group(1))


def num_descriptors(pid):
    return len(os.listdir(f"/proc/{pid}/fd"))


def bus_url(ttl=0):
    """A bus of this process's own: LCM tells them apart by their port."""
    bus_url.number += 1
    return f"udpm://{GROUP}:{21000 + (os.getpid() * 16 + bus_url.number) % 11000}?ttl={ttl}"


bus_url.number = 0


def port_of(url):
    return int(re.search(r":(\d+)\?", url).group(1))


# ---- stacks


def start_stack(log, out, flags, host=None, environment=None):
    return Program([PROJECT / "scripts/run_stack", log, "--out", out, "--lcm-url", bus_url(), *flags],
                   out / "run_stack.log", host, environment)


def run_stack(log, out, flags, host=None):
    """Maps a log in lockstep. Returns the seconds that the publisher took."""
    stack = start_stack(log, out, flags, host)
    check(stack.wait() == 0, f"run_stack failed: {stack.errors()[-1000:]}")
    return publisher_seconds(stack.errors())


def run_offline(log, out, flags):
    """Maps a log in one process."""
    subprocess.run([BIN / "slam_offline", log, "--out", out, *flags], check=True, capture_output=True, text=True)


def publisher_seconds(text):
    return float(re.findall(r"scans in ([0-9.]+) s", text)[-1])


def check_same_results(out, expected):
    for name in RESULTS:
        check((out / name).exists(), f"there is no {out / name}")
        check(filecmp.cmp(out / name, expected / name, shallow=False), f"{out / name} is not {expected / name}")


def summary(out):
    return json.loads((out / "summary.json").read_text())


# ---- LCM logs and messages


def read_log(path, channel="LASER"):
    """The messages on a channel, as bytes. A message's utime is its bytes 8 to 15."""
    data = path.read_bytes()
    at = 0
    messages = []
    while at < len(data):
        _, _, _, channel_bytes, data_bytes = struct.unpack_from(">IqqII", data, at)
        begin = at + 28 + channel_bytes
        if data[at + 28:begin].decode() == channel:
            messages.append(data[begin:begin + data_bytes])
        at = begin + data_bytes
    return messages


def write_log(path, messages, channel="LASER"):
    with open(path, "wb") as log:
        for number, message in enumerate(messages):
            log.write(struct.pack(">IqqII", 0xEDA1DA01, number, utime_of(message), len(channel), len(message)))
            log.write(channel.encode() + message)


class Driver:
    """Publishes scans on a bus as a laser's driver does."""

    def __init__(self, port):
        self.port = port
        self.num_sent = 0
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1 << 22)

    def publish(self, scan):
        header = struct.pack(">II", 0x4C433032, self.num_sent & 0xFFFFFFFF) + b"LASER\0"
        self.socket.sendto(header + scan, (GROUP, self.port))
        self.num_sent += 1


def utime_of(message):
    return struct.unpack_from(">q", message, 8)[0]


def with_utime(message, utime):
    return message[:8] + struct.pack(">q", utime) + message[16:]


def to_and_fro(messages):
    """A robot that drives the course to its end, backwards to its beginning, and so on: no jump anywhere."""
    while True:
        yield from messages[:-1]
        yield from messages[:0:-1]


class Listener(threading.Thread):
    """Hears POSE and SERVICE_STATUS: how old each pose is [s], where utime is the wall clock; all counters."""

    beginnings = [b"POSE", b"SERV"]  # the first four letters of what it listens to

    def __init__(self, port):
        super().__init__(daemon=True)
        self.ages_s = []
        self.statuses = {}
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        self.socket.setsockopt(socket.SOL_SOCKET, 35, 1)  # SO_TIMESTAMPNS: when the kernel got it
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
        self._keep_only()
        self.socket.bind((GROUP, port))
        self.socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP,
                               socket.inet_aton(GROUP) + socket.inet_aton("0.0.0.0"))
        self.start()

    def _keep_only(self):
        """A filter in the kernel for the beginning of the channel, behind 8 bytes each of UDP and LCM."""
        import ctypes
        load, jump_equal, give = 0x20, 0x15, 0x06
        code = [(load, 0, 0, 16)]
        for i, beginning in enumerate(self.beginnings):
            code.append((jump_equal, len(self.beginnings) - i, 0, int.from_bytes(beginning, "big")))
        code += [(give, 0, 0, 0), (give, 0, 0, 0xFFFFFFFF)]
        program = ctypes.create_string_buffer(b"".join(struct.pack("HBBI", *line) for line in code))
        self.socket.setsockopt(socket.SOL_SOCKET, 26,  # SO_ATTACH_FILTER
                               struct.pack("HxxxxxxQ", len(code), ctypes.addressof(program)))

    def run(self):
        while True:
            packet, ancillary, _, _ = self.socket.recvmsg(65536, 256)
            end = packet.index(b"\0", 8)
            seconds, nanoseconds = struct.unpack("qq", ancillary[0][2][:16])
            self.hear(packet[8:end], packet[end + 1:], seconds + 1e-9 * nanoseconds)

    def hear(self, channel, data, at_s):
        if channel == b"POSE":
            self.ages_s.append(at_s - 1e-6 * utime_of(data))
        elif channel.startswith(b"SERVICE_STATUS/"):
            name, counters = decode_status(data)
            self.statuses[name] = counters


def decode_status(data):
    """Name and counters of a crsm.service_status_t."""
    at = 16

    def number(form):
        nonlocal at
        value = struct.unpack_from(form, data, at)[0]
        at += struct.calcsize(form)
        return value

    def text():
        nonlocal at
        size = number(">i")
        at += size
        return data[at - size:at - 1].decode(errors="replace")

    name = text()
    text()  # version
    number(">i")  # pid
    text()  # state
    num_counters = number(">i")
    names = [text() for _ in range(num_counters)]
    return name, {key: number(">q") for key in names}


def percentile(values, share):
    return sorted(values)[int(share * (len(values) - 1))]


# ---- hosts


class Host:
    """A network namespace that lives as long as its one idle process."""

    def __init__(self):
        self.holder = subprocess.Popen(["setpriv", "--pdeathsig", "KILL", "unshare", "--net", "sleep", "infinity"])
        self.enter = ["nsenter", f"--net=/proc/{self.holder.pid}/ns/net"]
        mine = os.readlink("/proc/self/ns/net")
        await_condition(lambda: self.holder.poll() is not None or
                        os.readlink(f"/proc/{self.holder.pid}/ns/net") != mine, 10)
        if self.holder.poll() is not None:
            raise Skipped("no network namespace can be made here")

    def run(self, command):
        return subprocess.run([*self.enter, "sh", "-ec", command], check=True, capture_output=True, text=True).stdout


@contextlib.contextmanager
def hosts(count, lost_share=0.0):
    """Hosts on one bridge, each of which loses a share of the multicast packets that reach it: of single fragments,
    where a message is larger than a packet of 1500 bytes."""
    need_root()
    need_program("ip", "nsenter", "unshare", "setpriv", *(["nft"] if lost_share else []))
    switch, members = Host(), [Host() for _ in range(count)]
    try:
        try:
            switch.run("ip link add br0 type bridge mcast_snooping 0; ip link set br0 up")
        except subprocess.CalledProcessError as error:
            raise Skipped(f"no bridge can be made here: {error.stderr.strip()}") from None
        for number, member in enumerate(members):
            switch.run(f"ip link add port{number} type veth peer name eth0 netns {member.holder.pid};"
                       f"ip link set port{number} master br0 up")
            member.run(f"ip addr add 10.77.0.{number + 1}/24 dev eth0; ip link set lo up; ip link set eth0 up;"
                       "ip route add 224.0.0.0/4 dev eth0")
            if lost_share:
                member.run("nft 'add table ip faults;"
                           "add chain ip faults lose { type filter hook prerouting priority -450; };"
                           "add rule ip faults lose ip daddr 239.0.0.0/8"
                           f" numgen random mod 10000 < {round(10000 * lost_share)} counter drop'")
        yield members
    finally:
        for host in [switch, *members]:
            host.holder.kill()
            host.holder.wait()


def num_lost(members):
    return sum(int(re.search(r"packets (\d+)", member.run("nft list table ip faults")).group(1)) for member in members)


def run_on_hosts(members, log, out, flags=(), updater_flags=(), publisher_flags=()):
    """Publisher, matcher, and all others on a host each, in lockstep. Returns the seconds that the publisher took."""
    sensor, computer, rest = members
    common = ["--lcm-url", bus_url(ttl=1), *flags]
    services = [
        Program(["map_updater", "--lockstep", *updater_flags, *common], out / "map_updater.log", rest),
        Program(["loop_closer", *common], out / "loop_closer.log", rest),
        Program(["rrhc_matcher", "--lockstep", *common], out / "rrhc_matcher.log", computer),
        Program(["ray_selector", *common], out / "ray_selector.log", rest),
        Program(["map_exporter", "--out", out, *common], out / "map_exporter.log", rest),
    ]
    for service in services:
        service.await_ready()
    publisher = Program(["laser_publisher", log, "--rate", "max", *publisher_flags, *common], out / "publisher.log",
                        sensor)
    check(publisher.wait() == 0, f"the publisher failed: {publisher.errors()[-500:]}")
    for service in reversed(services):
        check(service.interrupt() == 0, f"{service.name} failed: {service.errors()[-500:]}")
    return publisher_seconds(publisher.errors())
