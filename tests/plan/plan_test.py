"""Floor plans of ten simulated flats, against what is true of them. Constants were chosen on the seeds 1 to 6."""
import math
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[1]))
import flats
import programs
from plan_places import find_motion, move, read_path
from programs import BIN, check

SEEDS = range(101, 111)
WALL_M, WALL_RAD = 0.02, math.radians(0.5)


def run(*command):
    subprocess.run([str(word) for word in command], capture_output=True, text=True, check=True)


def read_dxf(path):
    """Walls, doors and the texts of rooms, map frame."""
    lines = path.read_text().splitlines()
    pairs = list(zip(map(int, lines[::2]), lines[1::2]))
    check(pairs[-1] == (0, "EOF"), f"{path} does not end in EOF")
    found = {"WALLS": [], "DOORS": [], "ROOMS": []}
    entity = {}
    for code, value in pairs:
        if code == 0:
            if entity.get(8) in found:
                numbers = [float(entity[key]) for key in (10, 20, 11, 21) if key in entity]
                found[entity[8]].append((numbers, entity.get(1)))
            entity = {}
        entity[code] = value
    return found


def lies_on(point, yaw, wall, most_m, most_rad):
    a, b = wall
    of_wall = math.atan2(b[1] - a[1], b[0] - a[0])
    turn = abs((yaw - of_wall + math.pi / 2) % math.pi - math.pi / 2)
    return turn <= most_rad and flats.distance(point, a, b) <= most_m


def share_on(wall, others, most_m, most_rad):
    """How much of a wall lies on others [m], and how long it is."""
    yaw = math.atan2(wall[1][1] - wall[0][1], wall[1][0] - wall[0][0])
    points = flats.steps(*wall, 0.05)
    on = sum(any(lies_on(point, yaw, other, most_m, most_rad) for other in others) for point in points)
    size = flats.length(*wall)
    return size * on / len(points), size


def judge(folder, seed):
    flat = flats.make_flat(seed)
    world, out = folder / f"{seed}.world", folder / f"{seed}"
    world.write_text(flat.text + flats.list_boxes(flat.furniture) + flat.person)
    run(BIN / "slam_offline", f"sim:{world}", "--seed", seed, "--out", out)
    run(BIN / "slam_eval", "plan", out, "--out", folder / f"{seed}.dxf")
    plan = read_dxf(folder / f"{seed}.dxf")
    motion = find_motion(read_path(out / "trajectory.tum"), read_path(out / "truth.tum"))
    x, y, yaw = flat.start

    def place(point):
        return move((math.cos(yaw), math.sin(yaw), x, y), move(motion, point))

    walls = [(place(n[:2]), place(n[2:])) for n, _ in plan["WALLS"]]
    found = [share_on(wall, walls, WALL_M, WALL_RAD) for wall in flat.walls]
    false = [wall for wall in walls
             if flats.length(*wall) - share_on(wall, flat.walls, 0.1, math.radians(5))[0] > 0.5]
    rooms = [(place(n[:2]), float(text.split(", ")[-1].split()[0])) for n, text in plan["ROOMS"]]
    num_rooms = 0
    for rx, ry, w, h in flat.rooms:
        areas = [area for (ax, ay), area in rooms if rx < ax < rx + w and ry < ay < ry + h]
        num_rooms += len(areas) == 1 and abs(areas[0] / (w * h) - 1) <= 0.03
    doors = [((place(n[:2])[0] + place(n[2:])[0]) / 2, (place(n[:2])[1] + place(n[2:])[1]) / 2)
             for n, _ in plan["DOORS"]]
    num_doors = sum(any(flats.length(door, at) < 0.2 for at in doors) for door in flat.doors)
    return {"wall_m": sum(part for part, _ in found), "of_m": sum(size for _, size in found),
            "false": [tuple((round(x, 2), round(y, 2)) for x, y in wall) for wall in false],
            "rooms": num_rooms, "of_rooms": len(flat.rooms), "drawn_rooms": len(rooms),
            "doors": num_doors, "of_doors": len(flat.doors), "drawn_doors": len(doors)}


def test(case):
    results = {}
    for seed in SEEDS:
        found = results[seed] = judge(case.out, seed)
        case.say(f"flat {seed}: {100 * found['wall_m'] / found['of_m']:.1f} % of {found['of_m']:.1f} m of wall, "
                 f"{found['rooms']} of {found['of_rooms']} rooms ({found['drawn_rooms']} drawn), "
                 f"{found['doors']} of {found['of_doors']} doors ({found['drawn_doors']} drawn), "
                 f"walls that are none: {found['false']}")
    total = {key: sum(found[key] for found in results.values())
             for key in ("wall_m", "of_m", "rooms", "of_rooms", "doors", "of_doors", "drawn_rooms", "drawn_doors")}
    num_false = sum(len(found["false"]) for found in results.values())
    shares = sorted(found["wall_m"] / found["of_m"] for found in results.values())
    case.say(f"{len(results)} flats: {100 * total['wall_m'] / total['of_m']:.1f} % of the walls within 2 cm and "
             f"0.5 degrees (median {100 * shares[len(shares) // 2]:.1f}, worst {100 * shares[0]:.1f} %), "
             f"{total['rooms']} of {total['of_rooms']} rooms within 3 % ({total['drawn_rooms']} drawn), "
             f"{total['doors']} of {total['of_doors']} doors ({total['drawn_doors']} drawn), "
             f"{num_false} walls that are none")
    check(total["wall_m"] >= 0.95 * total["of_m"], "less than 95 % of the walls are right")
    check(total["rooms"] >= 0.9 * total["of_rooms"], "less than 90 % of the rooms are right")
    check(total["doors"] >= 0.9 * total["of_doors"], "less than 90 % of the doors are right")
    check(num_false == 0, f"{num_false} walls longer than 0.5 m are none")


programs.run(test)
