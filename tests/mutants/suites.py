"""Runs test programs where a mutant can do no harm: with a network and process ids of their own, and with limits."""

import dataclasses
import os
import pathlib
import re
import shutil
import subprocess

MEMORY_LIMIT_KB = 16_000_000  # address space of each process; a map reserves 1 GB of it, most of which takes no memory
FILE_LIMIT_KB = 2_000_000
TIMEOUT_FACTOR = 10  # times what the suite takes without a fault
LEAST_TIMEOUT_S = 30
SKIPPED = 77  # exit code of a suite that passed but for tests over logs that are not there
REAL_LOGS = pathlib.Path(__file__).resolve().parents[3] / "shared/data"  # beside the project, where there are some
GRACE_S = 10  # for a test program to say which test it was in

# When the first process of the sandbox ends, the kernel ends all that are left in it.
_SCRIPT = f"""
PATH=$PATH:/usr/sbin:/sbin
ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo || exit 99
ulimit -c 0 && ulimit -f {FILE_LIMIT_KB} && ulimit -v {MEMORY_LIMIT_KB} || exit 99
"$@"
exit $?
"""


@dataclasses.dataclass(frozen=True)
class Suite:
    name: str
    target: str
    others: bool = False  # whether it runs other programs of the project too
    tries: int = 1  # a suite that depends on time must fail as often as this to count


SUITES = [
    Suite("unit", "unit_tests"),
    Suite("accuracy", "accuracy_tests"),
    Suite("process", "process_tests", others=True, tries=2),
]


@dataclasses.dataclass(frozen=True)
class Outcome:
    passed: bool
    test: str = ""  # the first that failed


def sandbox():
    """The command in front of one to be run in a sandbox; None where the kernel does not allow it."""
    user = [] if os.geteuid() == 0 else ["--user", "--map-root-user"]
    command = ["unshare", *user, "--net", "--pid", "--fork", "--kill-child", "--mount-proc", "bash", "-c", _SCRIPT,
               "sandbox"]
    works = subprocess.run([*command, "true"], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                           stderr=subprocess.DEVNULL)
    return command if works.returncode == 0 else None


def first_failure(output):
    """Name of the first test that failed, as Catch2's console reporter tells; the last line where there is none."""
    failed = re.search(r"^.*: (FAILED:|.*fatal error condition)", output, re.MULTILINE)
    headers = list(re.finditer(r"^-{60,}\n(.+?)\n-{60,}$", output[:failed.start()] if failed else "", re.M | re.S))
    if headers:
        return " ".join(headers[-1].group(1).split())
    lines = output.split("\n") if output else []
    return next((line.strip() for line in reversed(lines) if line.strip()), "it says nothing")


def run_suite(workspace, suite, command_prefix, timeout_s):
    """Runs a suite up to its first failure."""
    log, temporary = workspace.folder / f"{suite.name}.txt", workspace.folder / "tmp"
    shutil.rmtree(temporary, ignore_errors=True)
    temporary.mkdir()
    program = workspace.build_folder / "bin" / suite.target
    command = [*command_prefix, "timeout", "-k", str(GRACE_S), str(round(timeout_s)), program, "--abort"]
    environment = {"TMPDIR": str(temporary), "CRSM_STOP_AT_FIRST": "1",
                   "CRSM_DATA": os.environ.get("CRSM_DATA", str(REAL_LOGS))}
    code = workspace.commands.run(command, log, timeout_s + 3 * GRACE_S, workspace.build_folder, environment)
    shutil.rmtree(temporary, ignore_errors=True)
    if code in (0, SKIPPED):
        return Outcome(True)
    if code == 99:
        return Outcome(False, "the sandbox could not be made")
    test = first_failure(log.read_text(errors="replace"))
    return Outcome(False, f"time limit: {test}" if code in (None, 124, 137) else test)
