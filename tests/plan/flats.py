"""Flats with furniture and people, as worlds for the simulator, and what is true of them."""
import dataclasses
import math
import random


def length(a, b):
    return math.hypot(b[0] - a[0], b[1] - a[1])


def distance(point, a, b):
    """From a point to the line from a to b."""
    way = (b[0] - a[0], b[1] - a[1])
    square = way[0] ** 2 + way[1] ** 2
    along = (point[0] - a[0]) * way[0] + (point[1] - a[1]) * way[1]
    share = 0.0 if square == 0 else max(0.0, min(1.0, along / square))
    return length(point, (a[0] + share * way[0], a[1] + share * way[1]))


def steps(a, b, every):
    """Points on the line from a to b, in the middle of equal parts of it."""
    num = max(1, round(length(a, b) / every))
    return [(a[0] + (b[0] - a[0]) * (i + 0.5) / num, a[1] + (b[1] - a[1]) * (i + 0.5) / num) for i in range(num)]


@dataclasses.dataclass
class Flat:
    text: str     # of the world, without what may come and go
    person: str   # who walks in the corridor
    walls: list   # of (x, y), (x, y): all but what is in a doorway
    doors: list   # of (x, y): their middles
    rooms: list   # of x, y, width, height: between the faces of their walls
    start: tuple  # x, y, yaw of the laser at the first scan
    furniture: list  # of x, y, width, height
    place: object    # a function that draws a place for a box
    num_rooms: int


def cut(a, b, gaps):
    """The parts of a wall along x or y between its gaps."""
    axis = 0 if a[1] == b[1] else 1
    at = [a[axis]] + sorted(end for gap in gaps for end in gap) + [b[axis]]
    return [tuple((value, a[1]) if axis == 0 else (a[0], value) for value in pair) for pair in zip(at[::2], at[1::2])]


def make_flat(seed):
    """Rooms on both sides of a corridor. Of odd seeds walls have no thickness, of even ones 0.12 m."""
    draw = random.Random(seed)
    thick = 0.0 if seed % 2 else 0.12
    width, hall = draw.uniform(9, 13), draw.uniform(1.3, 1.8)
    lines, walls, doors, rooms, path, boxes = [], [], [], [(0, 0, width, hall)], [], []
    start = (0.6, hall * 0.6)
    in_hall = {False: [], True: []}
    for upper in (False, True):
        depth = draw.uniform(3, 4.5)
        num = draw.choice([2, 3])
        ends = [width * (i + draw.uniform(-0.12, 0.12) * (0 < i < num)) / num for i in range(num + 1)]
        for i in range(num):
            left, right = ends[i] + (thick / 2 if i else 0), ends[i + 1] - (thick / 2 if i + 1 < num else 0)
            near = hall + thick if upper else -thick
            far = near + depth if upper else near - depth
            rooms.append((left, min(near, far), right - left, depth))
            door = draw.uniform(0.8, 1.0)
            at = draw.uniform(left + 0.35, right - 0.35 - door)
            gap = (at, at + door)
            in_hall[upper].append(gap)
            doors.append((at + door / 2, (near + (hall if upper else 0)) / 2))
            walls += cut((left, near), (right, near), [gap])
            walls += [((left, near), (left, far)), ((left, far), (right, far)), ((right, far), (right, near))]
            if thick:
                lines += [((x, near), (x, hall if upper else 0)) for x in gap]
            out = 1 if upper else -1
            middle = (at + door / 2, near + out * 0.7)
            round_trip = [(at + door / 2, hall * 0.5), middle, ((left + right) / 2, near + out * depth * 0.5),
                          (left + 0.9, far - out * 1.0), ((left + right) / 2, near + out * depth * 0.5),
                          (right - 0.9, far - out * 1.0), ((left + right) / 2, near + out * depth * 0.5), middle,
                          (at + door / 2, hall * 0.5)]
            path.append((at, round_trip))
            boxes.append((left, right, near, far, out))
    walls += cut((0, 0), (width, 0), in_hall[False]) + cut((0, hall), (width, hall), in_hall[True])
    walls += [((0, 0), (0, hall)), ((width, 0), (width, hall))]
    way = [start]
    for _, trip in sorted(path, key=lambda leg: leg[0]):
        way += trip
    way += [(width - 0.6, hall * 0.5), (0.7, hall * 0.5)]
    way = [point for i, point in enumerate(way) if i == 0 or length(point, way[i - 1]) > 0.05]
    def place(room, kind, draw, furniture):
        """A box in a room, in the way of neither the robot nor other furniture; None where there is no room for it."""
        left, right, near, far, out = boxes[room]
        for _ in range(50):
            if kind == "free":
                w, d = draw.uniform(0.5, 0.9), draw.uniform(0.4, 0.8)
                x = draw.uniform(left + 0.5, right - 0.5 - w)
                y = draw.uniform(min(near, far) + 0.5, max(near, far) - 0.5 - d)
            else:
                w, d = draw.uniform(0.8, 1.6), draw.uniform(0.35, 0.6)
                x, y = draw.uniform(left + 0.05, right - 0.05 - w), (far - d - 0.02 if out > 0 else far + 0.02)
                if draw.random() < 0.5:
                    w, d = d, w
                    x, y = left + 0.02, draw.uniform(min(near, far) + 0.6, max(near, far) - 0.05 - d)
            corners = [(x, y), (x + w, y), (x + w, y + d), (x, y + d)]
            rim = [point for a, b in zip(corners, corners[1:] + corners[:1]) for point in steps(a, b, 0.1)]
            clear = all(distance(point, a, b) > 0.4 for point in rim for a, b in zip(way, way[1:]))
            apart = all(x > bx + bw + 0.3 or bx > x + w + 0.3 or y > by + bd + 0.3 or by > y + d + 0.3
                        for bx, by, bw, bd in furniture)
            if clear and apart:
                return x, y, w, d
        return None

    furniture = []
    for room in range(len(boxes)):
        for kind in ("wall", "wall", "free"):
            box = place(room, kind, draw, furniture)
            if box:
                furniture.append(box)
    text = ["laser 270 540 12 10 0.01", "speed 0.4 0.6"]
    text += [f"wall {a[0]:.4f} {a[1]:.4f} {b[0]:.4f} {b[1]:.4f}" for a, b in walls + lines]
    text += [f"waypoint {x:.4f} {y:.4f}" for x, y in way]
    person = f"person 1 {hall * 0.8:.3f} {width - 1:.3f} {hall * 0.8:.3f} 0.7\n"
    yaw = math.atan2(way[1][1] - start[1], way[1][0] - start[0])
    return Flat("\n".join(text) + "\n", person, walls, doors, rooms, (*start, yaw), furniture, place, len(boxes))


def list_boxes(furniture):
    return "".join(f"box {x:.4f} {y:.4f} {w:.4f} {d:.4f}\n" for x, y, w, d in furniture)
