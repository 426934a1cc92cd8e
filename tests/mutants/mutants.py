"""Puts one small fault at a time into a copy of the source, and counts how many the tests catch. See scripts/mutants."""

import argparse
import collections
import dataclasses
import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

PROJECT = pathlib.Path(__file__).resolve().parents[2]
OUT = PROJECT / "out/mutants"
SOURCES = (  # globs of the files that get faults
    "common/math/*.?pp", "common/scan/*.?pp", "common/map/*.?pp", "common/match/**/*.?pp", "common/slam.?pp",
    "services/wire/wire*.?pp", "services/replica/map_replica.?pp", "services/replica/map_follower.?pp",
    "services/base/held_by_utime.hpp", "services/stages/scan_queue.hpp", "services/map_updater/delta_parts.?pp",
    "services/map_updater/pages.?pp", "services/journal/journal.?pp", "services/wire/lcm_event_log.?pp")
SUITES = {"unit_tests": 1, "accuracy_tests": 1, "process_tests": 2}  # how often each has to fail: the last depends on time
TIMEOUT_FACTOR = 10  # times what a suite takes without a fault, and 30 s at least
LOGS_ARE_MISSING = 77  # exit code of a suite that passed otherwise
CAUGHT, SURVIVED, NOT_BUILT = "caught", "survived", "does not build"

OPERATORS = {
    "<": ("<=", ">"), "<=": ("<", ">="), ">": (">=", "<"), ">=": (">", "<="), "==": ("!=",), "!=": ("==",),
    "&&": ("||",), "||": ("&&",), "+": ("-",), "-": ("+",), "*": ("/",), "/": ("*",),
    "++": ("--",), "--": ("++",), "+=": ("-=",), "-=": ("+=",), "*=": ("/=",), "/=": ("*=",)}
OPERATOR = re.compile(r"(?<= )(?:[<>]=?|[=!]=|&&|\|\||[-+*/]=?)(?= )|\+\+|--")  # clang-format puts blanks around those
NUMBER = re.compile(r"(?<![\w.'])(\d+\.?\d*(?:e[+-]?\d+)?)([uUlLfF]*)(?![\w.'])")
CONDITION = re.compile(r"\b(?:if|while) \((?:[^;{}\n]*; )?")
STATEMENT = re.compile(r"(?:(?<=[;{)] )|(?<=\n)[ ]+)(?!return\b)[\w*][\w:.>\[\]-]*(?: [-+*/|&]?= [^;{}]*|\([^;{}]*\));")
HIDDEN = re.compile(r'//[^\n]*|/\*.*?\*/|^[ ]*#[^\n]*|"(?:[^"\\\n]|\\.)*"|(?<!\d)\'(?:[^\'\\\n]|\\.)+\'|static_assert\([^;]*;',
                    re.DOTALL | re.MULTILINE)


class Failure(Exception):
    """Why nothing can be judged."""


@dataclasses.dataclass(frozen=True)
class Mutant:
    file: str
    line: int
    column: int
    start: int  # offsets of what is replaced
    end: int
    text: str  # what stands there instead
    original: str  # the whole lines, blanks joined
    mutated: str

    @property
    def id(self):
        return f"{self.file}:{self.line}:{self.column} {self.text}"

    def __str__(self):
        return f"{self.id}\n  - {self.original}\n  + {self.mutated}"


def find_faults(content):
    """Start, end and new text of each small fault. Some of them do not build."""
    text = HIDDEN.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), content)
    for found in OPERATOR.finditer(text):
        yield from ((found.start(), found.end(), other) for other in OPERATORS[found[0]])
    for found in NUMBER.finditer(text):
        value = float(found[1])
        others = {10 * value, 0.0} if re.search(r"[.e]", found[1]) else {value + 1, value - 1, 10 * value}
        for other in sorted(others - {value, -1.0}):
            number = repr(other) if re.search(r"[.e]", found[1]) else str(int(other))
            yield found.start(), found.end(), number + found[2]
    for found in CONDITION.finditer(text):
        end, depth = found.end(), 1
        while end < len(text) and depth:
            depth += {"(": 1, ")": -1}.get(text[end], 0)
            end += 1
        yield found.end(), end - 1, f"!({content[found.end():end - 1]})"
    for found in STATEMENT.finditer(text):
        start = found.end() - len(found[0].lstrip())
        yield start, found.end(), "{}"


def mutants_of(file, content):
    mutants = []
    for start, end, text in sorted(set(find_faults(content))):
        first, last = content.rfind("\n", 0, start) + 1, (content + "\n").find("\n", end)
        mutated = content[first:start] + text + content[end:last]
        mutants.append(Mutant(file, content.count("\n", 0, start) + 1, start - first + 1, start, end, text,
                              " ".join(content[first:last].split()), " ".join(mutated.split())))
    return mutants


def draw(mutants, seed):
    """All mutants in a random order: one of each line, then a second one of each line that has two, and so on."""
    def number(mutant):
        return hashlib.sha256(f"{seed} {mutant.file} {mutant.original} {mutant.mutated} {mutant.column}".encode()).digest()

    turns = collections.Counter()
    order = []
    for mutant in sorted(mutants, key=number):
        order.append((turns[mutant.file, mutant.line], mutant))
        turns[mutant.file, mutant.line] += 1
    return [mutant for _, mutant in sorted(order, key=lambda entry: entry[0])]


class Workspace:
    """A private copy of the project. Tests run with a network and process ids of their own, and with limits."""

    SANDBOX = """PATH=$PATH:/usr/sbin:/sbin
ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo || exit 99
ulimit -c 0 && ulimit -f 2000000 && ulimit -v 16000000 || exit 99
"$@"
exit $?"""

    def __init__(self, files):
        self.source = OUT / "source"
        for name in files:
            target = self.source / name
            content = (PROJECT / name).read_bytes()
            if not target.is_file() or target.read_bytes() != content:
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(content)
                shutil.copymode(PROJECT / name, target)
        for path in self.source.rglob("*"):
            name = path.relative_to(self.source).as_posix()
            if path.is_file() and name not in files and not name.startswith("build/"):
                path.unlink()
        user = [] if os.geteuid() == 0 else ["--user", "--map-root-user"]
        self.sandbox = ["unshare", *user, "--net", "--pid", "--fork", "--kill-child", "--mount-proc", "bash", "-c",
                        self.SANDBOX, "sandbox"]
        if self.run([*self.sandbox, "true"]) != 0:
            raise Failure("a mutant needs a sandbox, which the kernel does not allow: needs root, or user namespaces")
        options = ("-DCMAKE_BUILD_TYPE=Release", "-DCRSM_TESTS=ON", "-DCRSM_VIEWER=ON")
        if self.run(["cmake", "-S", ".", "-B", "build", "-G", "Ninja", *options]) != 0:
            raise Failure(f"cmake fails, see {OUT / 'log.txt'}")

    def run(self, command):
        """The exit code. What the command prints goes to log.txt."""
        with open(OUT / "log.txt", "wb") as log:
            return subprocess.run(command, cwd=self.source, stdin=subprocess.DEVNULL, stdout=log, stderr=log).returncode

    def build(self):
        return self.run(["ninja", "-C", "build", *SUITES]) == 0

    def test(self, suite, timeout_s):
        """Whether a suite passes; if not, its first test that fails."""
        data = os.environ.get("CRSM_DATA", PROJECT.parent / "shared/data")
        limited = ["timeout", "-k", "10", str(round(timeout_s)), "env", f"CRSM_DATA={data}", "CRSM_STOP_AT_FIRST=1"]
        for _ in range(SUITES[suite]):
            code = self.run([*self.sandbox, *limited, f"build/bin/{suite}", "--abort"])
            if code in (0, LOGS_ARE_MISSING):
                return True, ""
        said = (OUT / "log.txt").read_text(errors="replace")
        names = re.findall(r"^-{60,}\n(.+)\n(?:.*\n)*?-{60,}$", said, re.MULTILINE)
        return False, f"{suite}: {'time limit' if code in (124, 137) else names[-1] if names else f'exit code {code}'}"

    def judge(self, mutant, usual_s):
        """The verdict, and the test that gave it."""
        path = self.source / mutant.file
        content = path.read_text()
        try:
            path.write_text(content[:mutant.start] + mutant.text + content[mutant.end:])
            if not self.build():
                return NOT_BUILT, ""
            for suite in SUITES:
                passed, test = self.test(suite, max(30.0, TIMEOUT_FACTOR * usual_s[suite]))
                if not passed:
                    return CAUGHT, test
            return SURVIVED, ""
        finally:
            path.write_text(content)


def project_files():
    """The files that git knows or would add, and a digest of those that make the programs."""
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=PROJECT, check=True,
                            stdout=subprocess.PIPE, text=True).stdout
    files = sorted({name for name in listed.split("\0") if name and (PROJECT / name).is_file()})
    digest = hashlib.sha256()
    for name in files:
        if name.startswith(("CMakeLists.txt", "common/", "services/", "lcmtypes/")):
            digest.update(name.encode() + (PROJECT / name).read_bytes())
    return files, digest.hexdigest()[:16]


def all_mutants():
    mutants = []
    for glob in SOURCES:
        files = sorted(path for path in PROJECT.glob(glob) if path.is_file())
        if not files:
            raise Failure(f"'{glob}' in tests/mutants/mutants.py matches no file: has it moved?")
        for path in files:
            mutants += mutants_of(path.relative_to(PROJECT).as_posix(), path.read_text())
    return mutants


def measure_suites(workspace):
    print("building and testing the source without a fault", flush=True)
    if not workspace.build():
        raise Failure(f"the source without a fault cannot be built, see {OUT / 'log.txt'}")
    usual_s = {}
    for suite in SUITES:
        begin = time.monotonic()
        passed, test = workspace.test(suite, 3600)
        if not passed:
            raise Failure(f"it fails without any fault: {test}")
        usual_s[suite] = time.monotonic() - begin
    return usual_s


def judge_all(mutants, num, is_rerun):
    """Judges until `num` mutants were built. What was judged before, of the same programs, counts."""
    OUT.mkdir(parents=True, exist_ok=True)
    files, program = project_files()
    store = OUT / "results.jsonl"
    records = [json.loads(line) for line in store.read_text().splitlines()] if store.exists() else []
    known = {} if is_rerun else {record["id"]: record for record in records if record["program"] == program}
    workspace, usual_s = Workspace(files), {}
    verdicts = collections.defaultdict(list)
    for mutant in mutants:
        if sum(len(of_one) for verdict, of_one in verdicts.items() if verdict != NOT_BUILT) == num:
            break
        record = known.get(mutant.id)
        if not record:
            usual_s = usual_s or measure_suites(workspace)
            verdict, test = workspace.judge(mutant, usual_s)
            record = {"program": program, "id": mutant.id, "verdict": verdict, "test": test}
            with store.open("a") as file:
                file.write(json.dumps(record) + "\n")
            print(f"{verdict}: {mutant.id}{f' by {test}' if test else ''}", flush=True)
        verdicts[record["verdict"]].append(mutant)
    return verdicts


def main():
    parser = argparse.ArgumentParser(prog="mutants", usage="see --help")
    parser.add_argument("--num", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--only", nargs="+", default=[])
    parser.add_argument("--least", type=float, default=85.0)
    arguments = parser.parse_args()
    mutants = draw(all_mutants(), arguments.seed)
    for name in arguments.only:
        if not any(f"{mutant.id} ".startswith((f"{name}:", f"{name} ")) for mutant in mutants):
            raise Failure(f"--only {name}: there is no such mutant, see --list")
    if arguments.only:
        chosen = tuple(f"{name}{end}" for name in arguments.only for end in ": ")
        mutants = [mutant for mutant in mutants if f"{mutant.id} ".startswith(chosen)]
    num = len(mutants) if arguments.only else arguments.num
    if arguments.list:
        print(*mutants[:num], sep="\n")
        return 0
    verdicts = judge_all(mutants, num, bool(arguments.only))
    print("", *(f"SURVIVED: {mutant}" for mutant in verdicts[SURVIVED]), sep="\n")
    caught, survived = len(verdicts[CAUGHT]), len(verdicts[SURVIVED])
    percent = 100.0 * caught / max(1, caught + survived)
    print(f"{caught} caught, {survived} survived, {len(verdicts[NOT_BUILT])} did not build. Score {percent:.1f} %")
    return 0 if percent >= arguments.least else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Failure as failure:
        sys.exit(f"mutants: {failure}")
    except KeyboardInterrupt:
        sys.exit(130)
