#!/usr/bin/env python3
"""Looks whether each flag that a README names is one of the program before it, or else of any program or script here.

usage: tests/readme/check_flags.py
CRSM_BIN_DIR in the environment: the folder of the programs, build/bin by default. What a program's or a script's --help
prints are its flags. Those of other people's programs stand in OTHERS.
"""

import os
import pathlib
import re
import subprocess
import sys

from blocks import files_of, in_order
from markdown import CODE_SPAN, kinds_of

PROJECT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("CRSM_BIN_DIR", PROJECT / "build/bin"))
FLAG = re.compile(r"(?<![\w-])--[a-z][\w-]*")
PROGRAM = re.compile(r"(?<![\w/.:-])(?:[\w.-]+/)*([\w.-]+)(?=[\s`&]|$)")
PROGRAMS = ("fleet_mapper", "fleet_relay", "laser_publisher", "loop_closer", "map_exporter", "map_updater", "map_viewer",
            "mbot_publisher", "ray_selector", "rrhc_matcher", "run_stack", "slam_eval", "slam_offline")
SUBCOMMANDS = ("map", "trajectory", "relations", "plan", "summary", "world", "export")  # of slam_eval
PASS_ON = ("bench", "film")  # these give flags that they do not know to run_stack
OTHERS = {  # by the program that has them
    "cmake": {"--install", "--component"}, "systemctl": {"--now"}, "lcm-logger": {"--rotate"}, "GNU parallel": {"--sshlogin"},
    "lcm-gen": {"--cpp", "--cpp-hpath", "--python", "--ppath"}, "pkg-config": {"--cflags", "--libs"},
    "venv": {"--system-site-packages"}, "bench": {"--benchmark_filter"}}
IN_PROSE = set.union(*(OTHERS[name] for name in ("systemctl", "lcm-logger", "GNU parallel")))
TEST_SCRIPTS = ("tests/protocol/check", "tests/library/abi_test.py")  # the flags of these stand in their text


def ask(*program):
    done = subprocess.run([*program, "--help"], env={**os.environ, "CRSM_BIN_DIR": str(BIN)}, stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, timeout=60, check=True)
    return set(FLAG.findall(done.stdout))


def read_helps():
    """The flags of each program and script, by its name."""
    helps = {name: set(flags) for name, flags in OTHERS.items()}
    helps.update({pathlib.Path(path).name: set(FLAG.findall((PROJECT / path).read_text())) for path in TEST_SCRIPTS})
    for path in [*(BIN / name for name in PROGRAMS), *sorted((PROJECT / "scripts").iterdir())]:
        if path.is_file() and os.access(path, os.X_OK):
            helps[path.name] = helps.get(path.name, set()) | ask(path)
    for kind in SUBCOMMANDS:
        helps["slam_eval"] |= ask(BIN / "slam_eval", kind)
    for script in PASS_ON:
        helps[script] |= helps["run_stack"]
    return helps


def code_of(text):
    """The code of a page, with its line: each line of a block, and each code span."""
    for number, (line, kind) in enumerate(zip(text.splitlines(), kinds_of(text)), start=1):
        if kind == "code":
            yield from ((number, part) for part in re.sub(r"\s#\s.*", "", line).split(" & "))
    shown = "\n".join("" if kind == "code" else line for line, kind in zip(text.splitlines(), kinds_of(text)))
    yield from ((shown.count("\n", 0, span.start()) + 1, span[2]) for span in CODE_SPAN.finditer(shown))


def check_flags(texts, helps):
    """texts: the READMEs by their names. helps: the flags of each program."""
    every = IN_PROSE.union(*(flags for name, flags in helps.items() if name not in OTHERS or name == "bench"))
    failures = []
    for file, text in texts.items():
        for line, code in code_of(text):
            for flag in FLAG.finditer(code):
                before = next((name for name in PROGRAM.findall(code[:flag.start()]) if name in helps), "")
                if flag[0] not in (helps[before] if before else every):
                    failures.append(f"{file}:{line}: " + (f"{before} has no {flag[0]}" if before else f"nothing has {flag[0]}"))
    return failures


def main(arguments):
    if arguments:
        print(__doc__.strip())
        return 0 if arguments == ["--help"] else 2
    texts = {file: (PROJECT / file).read_text() for file in in_order(files_of(PROJECT)) if (PROJECT / file).is_file()}
    failures = check_flags(texts, read_helps())
    print("\n".join(failures) or f"{len(texts)} READMEs: all flags are there")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
