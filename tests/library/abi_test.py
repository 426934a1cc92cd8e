#!/usr/bin/env python3
"""The binary interface of the shared library is the one that abi.txt holds: its symbols, and the layout of the types in
slam.hpp. A program that was linked with an earlier library of the same SOVERSION runs with this one.

usage: tests/library/abi_test.py LIBRARY COMPILER [--accept]
  --accept   writes abi.txt anew. Refuses if the version of CMakeLists.txt was not raised, or, where something was removed
             or changed, the SOVERSION of scripts/cmake/library.cmake.
Skipped (exit code 77) without nm and readelf of binutils, and where a pointer has not 64 bits.
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
HEADERS = HERE.parents[1] / "services/library"
STORED = HERE / "abi.txt"
NAMESPACE = "crsm_slam"
SKIPPED = 77


def run(*command):
    return subprocess.run([str(word) for word in command], check=True, stdout=subprocess.PIPE, text=True).stdout


def read_symbols(library):
    """As the linker sees them: "symbol _ZN9crsm_slam4SlamD1Ev"."""
    return ["symbol " + line.split()[-1] for line in run("nm", "--dynamic", "--defined-only", library).splitlines()]


class Entry:
    """One entry of debug information, with those in it."""

    def __init__(self, tag):
        self.tag, self.attributes, self.entries = tag, {}, []

    @property
    def name(self):
        return self.attributes.get("name", "")


def text_of(value):
    """Of an attribute without its form, which versions of readelf write each in their own way."""
    value = re.sub(r"^\((?:indirect[^)]*|[a-z]+[0-9x]*)\)", "", value).strip()
    return re.sub(r"^(?:: |\(offset: 0x[0-9a-f]+\): )", "", value).strip()


def read_entries(object_file):
    """The outermost entry, and all of them by their offsets."""
    path, by_offset = [Entry("root")], {}
    for line in run("readelf", "--wide", "--debug-dump=info", object_file).splitlines():
        if begin := re.match(r" *<([0-9a-f]+)><([0-9a-f]+)>: Abbrev Number: \d+ \(DW_TAG_(\w+)\)", line):
            level, offset, tag = int(begin[1], 16), begin[2], begin[3]
            entry = by_offset[offset] = Entry(tag)
            del path[level + 1:]
            path[-1].entries.append(entry)
            path.append(entry)
        elif attribute := re.match(r" *<[0-9a-f]+> +DW_AT_(\w+) *: (.*)", line):
            path[-1].attributes[attribute[1]] = text_of(attribute[2])
    return path[0], by_offset


class Layout:
    """Lines for the types of a header, as a compiler lays them out."""

    def __init__(self, root, by_offset):
        self.by_offset, self.lines = by_offset, []
        for unit in root.entries:
            for space in unit.entries:
                if space.tag == "namespace" and space.name == NAMESPACE:
                    self.add_all(space, "")

    def add_all(self, space, before):
        for entry in space.entries:
            is_complete = entry.name and "declaration" not in entry.attributes
            if is_complete and entry.tag in ("structure_type", "class_type"):
                self.add_type(entry, before + entry.name)
            elif is_complete and entry.tag == "enumeration_type":
                for value in entry.entries:
                    self.lines.append(f"enum {before}{entry.name} {value.name} = {value.attributes['const_value']}")

    def add_type(self, entry, name):
        self.lines.append(f"type {name}: {int(entry.attributes['byte_size'], 0)} bytes")
        for member in entry.entries:
            if member.tag in ("member", "inheritance") and "data_member_location" in member.attributes:
                at = int(member.attributes["data_member_location"], 0)
                self.lines.append(f"type {name}.{member.name} at {at}: {self.type_name(member)}")
            elif "virtuality" in member.attributes:
                self.lines.append(f"type {name} virtual {member.name}")
        self.add_all(entry, name + "::")

    def type_name(self, entry):
        """The first name on the way to a type; without what compilers write each in their own way."""
        while offset := re.match(r"<0x([0-9a-f]+)>", entry.attributes.get("type", "")):
            entry = self.by_offset[offset[1]]
            if entry.name:
                name = entry.name.replace("long unsigned int", "unsigned long").replace(" >", ">")
                return re.sub(r"(\d)[uUlL]+\b", r"\1", name)
        return entry.tag


def read_layout(compiler):
    with tempfile.TemporaryDirectory(prefix="crsm_abi_") as folder:
        source, object_file = pathlib.Path(folder) / "header.cpp", pathlib.Path(folder) / "header.o"
        source.write_text("#include <crsm_slam/slam.hpp>\n")
        run(compiler, "-std=c++20", "-gdwarf-4", "-fno-eliminate-unused-debug-types", "-I", HEADERS, "-c", source, "-o",
            object_file)
        return Layout(*read_entries(object_file)).lines


def read_versions(library):
    """The version of the library, and its SOVERSION."""
    name = pathlib.Path(library).resolve().name
    soname = re.search(r"SONAME.*\[(.*)\]", run("readelf", "-d", library))[1]
    return name.split(".so.")[1], soname.split(".so.")[1]


def describe(library, compiler):
    version, soversion = read_versions(library)
    lines = sorted(read_symbols(library)) + read_layout(compiler)
    return [f"version {version}", f"SOVERSION {soversion}", *lines]


def complaints(stored, now):
    """What must be raised before `now` may take the place of `stored`."""
    removed = [line for line in stored[2:] if line not in now]
    added = [line for line in now[2:] if line not in stored]
    # A member that fits into the padding of a type changes no other line, but callers do not set it.
    types = {line.split(":")[0] for line in stored if line.startswith("type ")}
    inserted = [line for line in added if re.sub(r"\.\w* .*", "", line) in types]
    if (removed or inserted) and stored[1] == now[1]:
        return [*(f"- {line}" for line in removed), *(f"+ {line}" for line in added),
                f"programs that are linked with the library break: undo that, or raise the {now[1]} and the {now[0]}"]
    if added and stored[0] == now[0]:
        return [*(f"+ {line}" for line in added), f"the interface is larger: raise the {now[0]}"]
    return []


def main():
    if {"--help", "-h"} & set(sys.argv) or len(sys.argv) < 3:
        print(__doc__.strip())
        return 0 if len(sys.argv) == 2 else 2
    library, compiler = sys.argv[1:3]
    missing = [tool for tool in ("nm", "readelf") if not shutil.which(tool)]
    if missing or sys.maxsize < 2**32:
        print(f"skipped: {' and '.join(missing)} of binutils is not there: scripts/setup" if missing else "skipped: no 64-bit machine")
        return SKIPPED
    now = describe(library, compiler)
    if not any(line.startswith("symbol ") for line in now) or not any(line.startswith("type Slam:") for line in now):
        print("abi: finds no interface: nm or readelf writes it in a way that is not known here")
        return 1
    stored = STORED.read_text().splitlines() if STORED.exists() else ["version none", "SOVERSION none"]
    wrong = complaints(stored, now)
    if not wrong and set(stored[2:]) != set(now[2:]):  # compilers have an order each
        if "--accept" not in sys.argv:
            wrong = ["the interface has changed, and its version was raised: tests/library/abi_test.py --accept writes it"]
        else:
            STORED.write_text("\n".join(now) + "\n")
    print("\n".join(wrong) or f"abi: {len(now) - 2} lines as in {STORED.name}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
