"""Whether maps are off by no more than they say: simulated worlds, by lasers of many kinds, with and without wheels."""

import dataclasses
import math
import pathlib
import tempfile

from measure import PROJECT, Section, map_all, map_log, median
from page import table

PICTURE = PROJECT / "tests/results/bounds.svg"
WORLDS = ("arena", "block", "corridor", "demo", "env1", "env2", "env3", "env4", "hall", "rooms", "symmetric", "twins")
LASERS = {  # degrees, beams, range [m], scans a second, noise [m]
    "the world's own": None,
    "180°, 30 m": "180 181 30 10 0.01",
    "360°, 12 m": "360 360 12 5.5 0.01",
    "270°, 30 m": "270 1081 30 20 0.01",
    "360°, 5 m": "360 360 5 5 0.01",
    "240°, 4 m": "240 683 4 10 0.01",
    "270°, 3.5 m": "270 270 3.5 10 0.01",
    "90°, 8 m": "90 180 8 10 0.015",
}
CAMPUS = "180°, a campus"
SEEDS = (5, 6, 7)  # the edges of the graph were weighed on 1 to 4
WHEELS = "wheels 1.01 0.98 0.03 0.03"  # in every second seed
CELL_M = 0.05  # no map is better: a smaller error counts as so much
WRONG_M, RIGHT_M = 0.3, 0.1
COLOURS = {"good": "#1a7f37", "doubtful": "#d98200", "bad": "#c02020"}


@dataclasses.dataclass(frozen=True)
class Mapped:
    laser: str
    error_m: float
    bound_m: float | None  # nothing if the map says none
    trust: str

    @property
    def is_held(self):
        return self.error_m <= self.bound_m


def map_source(laser, source, seed):
    """Maps a source without a flag, as a stranger would. The error is that of the worst pose."""
    run = map_log(source, ["--seed", seed], align_truth=True)
    verdict = run.summary["verdict"]
    return Mapped(laser, run.worst_m, verdict.get("off_m"), verdict["trust"])


def write_world(folder, world, laser, seed):
    lines = (PROJECT / f"common/worlds/{world}.world").read_text().splitlines()
    if LASERS[laser]:
        lines = [f"laser {LASERS[laser]}" if line.startswith("laser ") else line for line in lines]
    if seed % 2 == 0:
        lines.insert(1, WHEELS)
    path = folder / f"{world}-{list(LASERS).index(laser)}-{seed}.world"
    path.write_text("\n".join(lines) + "\n")
    return f"sim:{path}"


def draw(runs, path):
    """A dot for each map that says a bound: its error and what it says, both by their logarithms, 1 cm to 100 m."""
    side, margin = 420, 50

    def place(length_m):
        return margin + (min(max(math.log10(length_m), -2.0), 2.0) + 2.0) / 4.0 * (side - 1.5 * margin)

    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{side}" height="{side}" font-family="sans-serif" '
             'font-size="11"><rect width="100%" height="100%" fill="white"/>',
             f'<path d="M{place(0.01)},{side - place(0.01)} L{place(100)},{side - place(100)}" stroke="black"/>']
    for power in range(-2, 3):
        at, name = place(10.0**power), f"{10.0**power:g}"
        parts.append(f'<path d="M{at:.1f},{side - place(0.01)} V{side - place(100)} M{place(0.01)},{side - at:.1f} '
                     f'H{place(100)}" stroke="#dddddd"/><text x="{at:.1f}" y="{side - margin + 16}" '
                     f'text-anchor="middle">{name}</text><text x="{margin - 6}" y="{side - at + 4:.1f}" '
                     f'text-anchor="end">{name}</text>')
    for run in runs:
        if run.bound_m is not None:
            parts.append(f'<circle cx="{place(run.error_m):.1f}" cy="{side - place(run.bound_m):.1f}" r="3" '
                         f'fill="{COLOURS[run.trust]}" fill-opacity="0.6"/>')
    parts += [f'<text x="{side / 2}" y="{side - 12}" text-anchor="middle">worst pose off by [m]</text>',
              f'<text x="14" y="{side / 2}" text-anchor="middle" transform="rotate(-90 14 {side / 2})">'
              'may be off by, as the map says [m]</text>']
    parts += [f'<text x="{place(0.015):.0f}" y="{side - place(60) + 16 * number}" fill="{colour}">{trust}</text>'
              for number, (trust, colour) in enumerate(COLOURS.items()) if any(run.trust == trust for run in runs)]
    path.write_text("\n".join([*parts, "</svg>"]) + "\n")


def row(name, runs):
    said = [run for run in runs if run.bound_m is not None]
    held = sum(run.is_held for run in said)
    good = [run for run in said if run.trust == "good"]
    return [name, len(runs), f"{held} of {len(said)}", f"{sum(run.is_held for run in good)} of {len(good)}",
            f"{median([run.bound_m / max(run.error_m, CELL_M) for run in said]):.1f}" if said else "-",
            sum(run.trust == "good" and run.error_m > WRONG_M for run in runs),
            sum(run.trust == "bad" and run.error_m < RIGHT_M for run in runs)]


def measure_bounds():
    with tempfile.TemporaryDirectory(prefix="crsm_bounds_") as name:
        jobs = {}
        for seed in SEEDS:
            for laser in LASERS:
                for world in WORLDS:
                    source = write_world(pathlib.Path(name), world, laser, seed)
                    jobs[world, laser, seed] = lambda a=(laser, source, seed): map_source(*a)
            for length_m in (1000, 3000):
                source = f"sim:campus:{length_m}:{seed}"
                jobs["campus", length_m, seed] = lambda a=(CAMPUS, source, seed): map_source(*a)
        runs = list(map_all("bounds", jobs).values())
    draw(runs, PICTURE)
    rows = [row(laser, [run for run in runs if run.laser == laser]) for laser in [*LASERS, CAMPUS]]
    return "\n\n".join([
        table(["laser", "maps", "bounds held", "of good maps", "bound / error, median", f"good, but off by {WRONG_M:g} m",
               f"bad, but right to {RIGHT_M:g} m"], [*rows, row("all", runs)]),
        f"![errors and bounds]({PICTURE.relative_to(PROJECT / 'tests')})"])


SECTIONS = [
    Section("Bounds", 12, "Twelve simulated worlds by eight lasers, and campuses of 1 and 3 km, each over some seeds, every "
            "second one with wheels that err by some per cent. No flag is given. The error is that of the worst pose, after "
            "the best alignment. An error under a cell counts as a cell. The weights of the graph's edges were chosen on other "
            "seeds of the same worlds.",
            ["build/bin/slam_offline sim:WORLD --seed N --out DIR", "build/bin/slam_eval trajectory DIR --align --json"],
            measure_bounds),
]
