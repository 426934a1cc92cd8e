"""What has changed since a map was made: simulated flats in which five things were moved, came or went, against what is
true of them. Constants were chosen on the seeds 1 to 6. CRSM_CHANGES_SEEDS: flats, 3 by default."""
import csv
import json
import math
import os
import pathlib
import random
import subprocess
import sys

TESTS = pathlib.Path(__file__).parents[1]
sys.path += [str(TESTS), str(TESTS / "plan")]
import flats
import programs
from plan_places import find_motion, move, read_path
from programs import BIN, check

FIRST = int(os.environ.get("CRSM_CHANGES_FIRST", 201))
SEEDS = range(FIRST, FIRST + int(os.environ.get("CRSM_CHANGES_SEEDS", 3)))
BESIDE_M = 0.25


def run(*command, code=0):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    check(done.returncode == code, f"{' '.join(map(str, command))}: exit code {done.returncode}: {done.stderr}")
    return done.stdout


def edit(flat, seed):
    """Other furniture, and which boxes have come and gone."""
    draw = random.Random(1000 + seed)
    furniture = list(flat.furniture)
    come, gone = [], []
    edits = ["move", "move", "come", "go", draw.choice(["move", "come", "go"])]
    while edits:
        kind = edits[0]
        if kind != "come":
            box = draw.choice([box for box in furniture if box not in come])
            furniture.remove(box)
            gone.append(box)
        if kind != "go":
            box = None
            while not box:
                box = flat.place(draw.randrange(flat.num_rooms), draw.choice(["wall", "free"]), draw, furniture + gone)
            furniture.append(box)
            come.append(box)
        edits.pop(0)
    return furniture, come, gone


def read_changes(out, place):
    with open(out / "changes.csv", encoding="utf-8") as file:
        return [(row["kind"], place((float(row["x_m"]), float(row["y_m"]))), float(row["area_m2"]), int(row["places"]))
                for row in csv.DictReader(file)]


def is_at(point, box):
    x, y, w, d = box
    return x - BESIDE_M <= point[0] <= x + w + BESIDE_M and y - BESIDE_M <= point[1] <= y + d + BESIDE_M


def judge(folder, seed):
    flat = flats.make_flat(seed)
    furniture, come, gone = edit(flat, seed)
    same = flat.text + flats.list_boxes(flat.furniture)
    changed = flat.text + flats.list_boxes(furniture)
    worlds = {"map": same, "changed": changed, "same": same, "people": same + flat.person}
    for number, (name, text) in enumerate(worlds.items()):
        world = folder / f"{name}.world"
        world.write_text(text)
        more = ["--localize", folder / "map"] if name != "map" else []
        run(BIN / "slam_offline", f"sim:{world}", "--seed", seed + 1000 * number, "--force", "--out", folder / name,
            *more)
    motion = find_motion(read_path(folder / "map/trajectory.tum"), read_path(folder / "map/truth.tum"))
    x, y, yaw = flat.start

    def place(point):
        return move((math.cos(yaw), math.sin(yaw), x, y), move(motion, point))

    changes = read_changes(folder / "changed", place)
    found = [any(kind == "new" and is_at(at, box) for kind, at, _, _ in changes) for box in come]
    found += [any(kind == "gone" and is_at(at, box) for kind, at, _, _ in changes) for box in gone]
    false = [change for change in changes if not any(is_at(change[1], box) for box in come + gone)]
    missed = [box for box, is_found in zip(come + gone, found) if not is_found]
    return {"found": sum(found), "of": len(found), "false": false, "missed": missed,
            "same": read_changes(folder / "same", place), "people": read_changes(folder / "people", place)}


def test(case):
    results = {}
    for seed in SEEDS:
        found = results[seed] = judge(case.folder(str(seed)), seed)
        case.say(f"flat {seed}: {found['found']} of {found['of']} found, false {found['false']}, "
                 f"missed {found['missed']}; unchanged {found['same']}; with people {found['people']}")
    num = {key: sum(found[key] for found in results.values()) for key in ("found", "of")}
    num_false = sorted(len(found["false"]) for found in results.values())
    case.say(f"{len(results)} flats: {num['found']} of {num['of']} things found, {sum(num_false)} false "
             f"(at most {num_false[-1]} a drive); {sum(len(found['same']) for found in results.values())} where nothing changed, "
             f"{sum(len(found['people']) for found in results.values())} with people")
    check(num["found"] >= 0.95 * num["of"], "less than 95 % of the things were found")
    check(num_false[-1] <= 1, "more than one change of a drive is none")
    check(not any(found["same"] for found in results.values()), "something has changed where nothing has")
    check(not any(found["people"] for found in results.values()), "people who walk are changes")
    out = case.out / str(SEEDS[0])
    run(BIN / "slam_offline", f"sim:{out / 'changed.world'}", "--localize", out / "map", "--out", out / "over",
        "--force", "--changes-over", "0.1", code=4)
    run(BIN / "slam_offline", f"sim:{out / 'same.world'}", "--localize", out / "map", "--out", out / "over", "--force",
        "--changes-over", "0.1")


    in_processes(out)


def in_processes(out):
    """The stack finds what one process finds, and says it by its exit code."""
    seed = SEEDS[0] + 1000
    run(BIN / "run_stack", f"sim:{out / 'changed.world'}", "--seed", seed, "--localize", out / "map", "--out",
        out / "stack", "--changes-over", "0.1", "--lcm-url", programs.bus_url(), code=4)
    for name in ("changes.csv", "trajectory.tum"):
        check((out / "stack" / name).read_bytes() == (out / "changed" / name).read_bytes(),
              f"{name} of the processes is not that of one process")
    changes = json.loads((out / "stack/summary.json").read_text())["changes"]
    check(len(changes) > 0 and all(change["places"] >= 2 for change in changes), f"summary.json has {changes}")
    print(f"  one process and the stack: the same {len(changes)} changes")


programs.run(test)
