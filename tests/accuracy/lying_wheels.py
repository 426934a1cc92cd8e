#!/usr/bin/env python3
"""Maps logs whose wheels lie, with --odometry and without, and says which lies make the map worse.

Lies:
  honest    the wheels as they are
  short5    ways 5 % too short
  short20   ways 20 % too short
  reverse   the sign of the way is wrong where the robot drives backwards; if it hardly does: on a tenth of the path
  frozen    the wheels stand still from the middle of the log on
  jump      5 m at once, every 300 scans
  slip90    90 degrees at once, every 300 scans
  noise10   gaussian noise of 0.3 m per root metre and 0.5 rad per root radian: ten times that of good wheels

A log that is not there is looked for in $CRSM_DATA, or shared/data beside the project.

Exit codes: 0 no lie makes a map worse than none by more than 10 % and 2 mm, 1 one does, 2 usage, 77 a log is not there.
"""
import argparse
import gzip
import json
import math
import os
import random
import statistics
import struct
import subprocess
import sys
import tempfile

FLAT = 'flat'
FLAT_WHEELS = 'wheels 1 1 0.02 0.03'
PROJECT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '../..')
DEMO = f'{PROJECT}/common/worlds/demo.world'
DATA = os.environ.get('CRSM_DATA', f'{PROJECT}/../shared/data')
SKIPPED = 77
WORSE_SHARE, WORSE_M = 1.1, 0.002
PERIOD = 300  # scans between two jumps
LEAST_BACKWARDS_M = 1.0  # less is the noise of the wheels
STRETCH_M, ONE_OF = 2.0, 10  # of the path that is driven backwards where the robot never is


def wrap(angle):
    return math.atan2(math.sin(angle), math.cos(angle))


def motion_between(a, b):
    c, s = math.cos(a[2]), math.sin(a[2])
    dx, dy = b[0] - a[0], b[1] - a[1]
    return (c * dx + s * dy, c * dy - s * dx, wrap(b[2] - a[2]))


def move(pose, motion):
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return (pose[0] + c * motion[0] - s * motion[1], pose[1] + s * motion[0] + c * motion[1], wrap(pose[2] + motion[2]))


def shorten(share):
    return lambda motions: [(share * x, share * y, turn) for x, y, turn in motions]


def reverse(motions):
    backwards_m = -sum(x for x, _, _ in motions if x < 0)
    out, driven_m = [], 0.0
    for x, y, turn in motions:
        drives_back = x < 0 if backwards_m >= LEAST_BACKWARDS_M else int(driven_m / STRETCH_M) % ONE_OF == ONE_OF // 2
        driven_m += math.hypot(x, y)
        out.append((-x, -y, turn) if drives_back else (x, y, turn))
    return out


def freeze(motions):
    half = len(motions) // 2
    return motions[:half] + [(0.0, 0.0, 0.0)] * (len(motions) - half)


def leap(x_m, turn_rad):
    def lie(motions):
        return [(x + x_m, y, turn + turn_rad) if (i + 1) % PERIOD == 0 else (x, y, turn)
                for i, (x, y, turn) in enumerate(motions)]
    return lie


def shake(motions):
    noise = random.Random(1)
    out = []
    for x, y, turn in motions:
        way = math.hypot(x, y)
        share = 1 + noise.gauss(0, 0.3) / math.sqrt(way) if way > 0 else 0.0
        out.append((share * x, share * y, turn + noise.gauss(0, 0.5) * math.sqrt(abs(turn))))
    return out


LIES = {
    'honest': list,
    'short5': shorten(0.95),
    'short20': shorten(0.8),
    'reverse': reverse,
    'frozen': freeze,
    'jump': leap(5.0, 0.0),
    'slip90': leap(0.0, math.pi / 2),
    'noise10': shake,
}


def lie_about(poses, kind):
    motions = [motion_between(a, b) for a, b in zip(poses, poses[1:])]
    told = poses[:1]
    for motion in LIES[kind](motions):
        told.append(move(told[-1], motion))
    return told


class CarmenLog:
    """FLASER n r1..rn x y theta odom_x odom_y odom_theta t host t2: the second pose is that of the robot's wheels."""

    def __init__(self, path):
        with gzip.open(path, 'rt') if path.endswith('.gz') else open(path) as log:
            self.lines = [line.split() for line in log]
        self.scans = [fields for fields in self.lines if fields and fields[0] == 'FLASER']
        self.poses = [tuple(map(float, fields[-6:-3])) for fields in self.scans]

    def write(self, path, poses):
        for fields, pose in zip(self.scans, poses):
            fields[-6:-3] = [f'{value:.6f}' for value in pose]
        with open(path, 'w') as log:
            log.writelines(' '.join(fields) + '\n' for fields in self.lines)


class LcmLog:
    """ODOMETRY holds bot_core.pose_t: fingerprint, utime, pos, vel, orientation (w, x, y, z), ..., all big-endian."""
    EVENT, SYNC = struct.Struct('>IqqII'), 0xEDA1DA01
    POS, ORIENTATION = 16, 64

    def __init__(self, path):
        with open(path, 'rb') as log:
            data = log.read()
        self.events, at = [], 0
        while at < len(data):
            sync, number, utime, channel_size, size = self.EVENT.unpack_from(data, at)
            if sync != self.SYNC:
                sys.exit(f'{path}: no event at byte {at}')
            at += self.EVENT.size
            channel = data[at:at + channel_size]
            self.events.append((number, utime, channel, bytearray(data[at + channel_size:at + channel_size + size])))
            at += channel_size + size
        self.odometry = [message for _, _, channel, message in self.events if channel == b'ODOMETRY']
        self.poses = [self.pose_of(message) for message in self.odometry]

    def pose_of(self, message):
        x, y = struct.unpack_from('>2d', message, self.POS)
        w, _, _, z = struct.unpack_from('>4d', message, self.ORIENTATION)
        return (x, y, 2 * math.atan2(z, w))

    def write(self, path, poses):
        for message, (x, y, yaw) in zip(self.odometry, poses):
            struct.pack_into('>2d', message, self.POS, x, y)
            struct.pack_into('>4d', message, self.ORIENTATION, math.cos(yaw / 2), 0, 0, math.sin(yaw / 2))
        with open(path, 'wb') as log:
            for number, utime, channel, message in self.events:
                log.write(self.EVENT.pack(self.SYNC, number, utime, len(channel), len(message)) + channel + message)


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f'{" ".join(command)}: exit code {done.returncode}: {done.stderr[-500:]}')
    return done.stdout


class Drive:
    """A log that is mapped, and how its error is measured. A seed of the flat is another drive: its noise is new."""

    def __init__(self, name, seed, bin_dir, folder):
        self.seed, self.bin_dir, self.folder = str(seed), bin_dir, folder
        if name == FLAT:
            with open(DEMO) as demo, open(f'{folder}/flat.world', 'w') as world:
                world.write(demo.read() + '\n' + FLAT_WHEELS + '\n')
            source, self.suffix, self.flags = f'sim:{folder}/flat.world', '.lcm', []
            run(f'{bin_dir}/slam_offline', source, '--seed', self.seed, '--out', f'{folder}/truth')
            run(f'{bin_dir}/laser_publisher', source, '--odometry', '--seed', self.seed,
                '--lcm-url', f'file://{folder}/honest.lcm?mode=w')
            self.log = LcmLog(f'{folder}/honest.lcm')
        else:
            self.suffix, self.flags, self.log = '.clf', ['--preset', 'sick'], CarmenLog(name)
            self.relations = name.removesuffix('.gz').removesuffix('.clf') + '.relations'
        self.honest = self.log.poses
        if len(self.honest) < 2:
            sys.exit(f'{name}: has no odometry')

    def map(self, kind, *flags):
        """Error [m], scans lost, trust."""
        log, out = f'{self.folder}/lying{self.suffix}', f'{self.folder}/{kind}{"".join(flags)}'
        self.log.write(log, lie_about(self.honest, kind))
        run(f'{self.bin_dir}/slam_offline', log, *self.flags, *flags, '--seed', self.seed, '--out', out)
        if self.suffix == '.lcm':
            truth = f'{self.folder}/truth/truth.tum'
            measured = run(f'{self.bin_dir}/slam_eval', 'trajectory', out, truth, '--align', '--json')
            error_m = json.loads(measured)['rmse_m']
        else:
            measured = run(f'{self.bin_dir}/slam_eval', 'relations', out, self.relations, '--json')
            error_m = json.loads(measured)['translation_m']['mean']
        with open(f'{out}/summary.json') as file:
            summary = json.load(file)
        return error_m, summary['lost'], summary['verdict']['trust']


def is_worse(with_m, without_m):
    return with_m > WORSE_SHARE * without_m and with_m > without_m + WORSE_M


def compare(name, kinds, seeds, bin_dir):
    """Prints a line for each kind; how many of the kinds are worse than no wheels in the median of the seeds.

    One drive of aces in sixteen breaks without any wheels: that is no lie's doing.
    """
    runs = {kind: [] for kind in kinds}
    without = []
    for seed in seeds:
        with tempfile.TemporaryDirectory() as folder:
            drive = Drive(name, seed, bin_dir, folder)
            without.append(drive.map('honest'))
            for kind in kinds:
                runs[kind].append(drive.map(kind, '--odometry'))

    def column(results, index, form):
        return ' '.join(form.format(result[index]) for result in results)

    def median_m(results):
        return statistics.median(result[0] for result in results)

    num_worse = 0
    for kind in kinds:
        worse = is_worse(median_m(runs[kind]), median_m(without))
        num_worse += worse
        print(f"{os.path.basename(name).split('.')[0]:<10} {kind:<8} {column(runs[kind], 0, '{:8.4f}')}  "
              f"{column(without, 0, '{:8.4f}')}  {column(runs[kind], 1, '{:5d}')}  {column(without, 1, '{:5d}')}  "
              f"{column(runs[kind], 2, '{:9}')}  {'WORSE' if worse else 'ok'}", flush=True)
    return num_worse


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('bin_dir', help='the folder of slam_offline, slam_eval and laser_publisher')
    parser.add_argument('logs', nargs='+', help=f'NAME.clf or NAME.clf.gz with NAME.relations beside it, or {FLAT}: '
                                                'the simulated flat')
    parser.add_argument('--seeds', default='1,2', help='two are the default: 1,2')
    parser.add_argument('--kinds', default=','.join(LIES), help='which of ' + ', '.join(LIES))
    args = parser.parse_args()
    kinds = args.kinds.split(',')
    wrong = [kind for kind in kinds if kind not in LIES]
    if wrong:
        parser.error(f'--kinds: {wrong[0]} is none of {", ".join(LIES)}')
    seeds = [int(seed) for seed in args.seeds.split(',')]
    logs = [name if name == FLAT or os.path.exists(name) else os.path.join(DATA, name) for name in args.logs]
    missing = [name for name in logs if name != FLAT and not os.path.exists(name)]
    if missing:
        print(f'skipped: no {os.path.normpath(missing[0])}; CRSM_DATA names another folder')
        return SKIPPED
    width = 9 * len(seeds)
    print(f"{'log':<10} {'kind':<8} {'error with [m]':<{width}} {'without [m]':<{width}} {'lost with':<{6 * len(seeds)}} "
          f"{'without':<{6 * len(seeds)}} {'map with':<{10 * len(seeds)}} verdict")
    num_worse = sum(compare(name, kinds, seeds, args.bin_dir) for name in logs)
    print(f'{num_worse} of {len(kinds) * len(logs)} are worse than without wheels')
    return 1 if num_worse else 0


if __name__ == '__main__':
    sys.exit(main())
