"""The rooms of common/ and services/ use only rooms that stand above them in the tables of their READMEs."""
import functools
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
INCLUDE = re.compile(r'^#include "((?:common|services)/[^"]+)"', re.MULTILINE)
ROW = re.compile(r"^\| \[?`([a-z_]+)(?:/|\.hpp)`", re.MULTILINE)


def read_rooms(tree, heading):
    """The rooms of a tree in the order of the table below a heading: each may use those before it."""
    text = (ROOT / tree / "README.md").read_text()
    section = text.split(f"## {heading}\n")[1].split("\n## ")[0]
    return ROW.findall(section)


def room_of(path):
    """Of "common/scan/deskew.hpp" ("common", "scan"), of "common/slam.hpp" ("common", "slam")."""
    tree, room = pathlib.PurePath(path).parts[:2]
    return tree, room.split(".")[0]


def find_includes(tree):
    """Each file of a tree with each file of the project that it includes, as paths from the root."""
    for path in sorted((ROOT / tree).rglob("*.?pp")):
        name = path.relative_to(ROOT).as_posix()
        for included in INCLUDE.findall(path.read_text()):
            yield name, included


# Whoever uses them hides them behind a header of its own.
SLOW_HEADERS = {
    "Eigen/": ("common/", "services/sources/bags/"),
    "CLI/": "services/settings/",
    "toml++/": "services/settings/",
    "boost/": "services/map_viewer/web_server.cpp",
    "opencv2/": "common/results/",
    "pybind11/": "services/python/",
}
SOURCES = [path.relative_to(ROOT).as_posix() for tree in ("common", "services")
           for path in sorted((ROOT / tree).rglob("*.cpp"))]


@functools.lru_cache(maxsize=None)
def includes_of(name):
    path = ROOT / name
    return re.findall(r'^#include [<"]([^>"]+)[>"]', path.read_text(), re.MULTILINE) if path.exists() else []


def reach(name):
    """All that a file includes, and what that includes."""
    found, left = set(), [name]
    while left:
        new = set(includes_of(left.pop())) - found
        found |= new
        left += new
    return found


class Arrows(unittest.TestCase):
    def check(self, tree, rooms, is_allowed_elsewhere):
        wrong = []
        num_includes = 0
        for name, included in find_includes(tree):
            (_, room), (other_tree, other) = room_of(name), room_of(included)
            num_includes += 1
            if other_tree != tree:
                fits = is_allowed_elsewhere
            elif room == other:
                fits = True
            elif room in rooms:
                fits = other in rooms and rooms.index(other) < rooms.index(room)
            else:
                fits = other in rooms  # a process uses rooms, and no other process
            if not fits:
                wrong.append(f"{name} includes {included}")
        self.assertEqual(wrong, [])
        self.assertGreater(num_includes, 100)

    def test_rooms_of_common_use_those_above_them(self):
        rooms = read_rooms("common", "The rooms")
        self.assertGreater(len(rooms), 8)
        self.check("common", rooms, is_allowed_elsewhere=False)

    def test_rooms_of_services_use_those_above_them_and_no_process_another(self):
        rooms = read_rooms("services", "The rooms")
        self.assertGreater(len(rooms), 7)
        self.check("services", rooms, is_allowed_elsewhere=True)

    def test_headers_that_take_compilers_long_reach_few_files(self):
        for header, allowed in SLOW_HEADERS.items():
            reached = [name for name in SOURCES if any(used.startswith(header) for used in reach(name))]
            self.assertEqual([name for name in reached if not name.startswith(allowed)], [], header)
            self.assertTrue(reached, header)


if __name__ == "__main__":
    unittest.main()
