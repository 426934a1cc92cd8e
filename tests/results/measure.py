"""What the sections measure with: commands that are run, one after the other or on all cores, and kept as they are said."""

import concurrent.futures
import dataclasses
import json
import os
import pathlib
import statistics
import struct
import subprocess
import sys
import tempfile
import threading

PROJECT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("CRSM_BIN_DIR", PROJECT / "build/bin"))
DATA = pathlib.Path(os.environ.get("CRSM_DATA", PROJECT.parent / "shared/data"))
SICK = ["--preset", "sick"]
LCM_EVENT = struct.Struct(">IqqII")  # of an LCM log: sync word, number, utime, sizes of channel and message


class Failed(Exception):
    """A command that did not do its work, with what it said."""


@dataclasses.dataclass(frozen=True)
class Section:
    """A section of the page, and how it is made."""

    title: str     # its heading; the anchor of links
    minutes: float
    about: str     # one or two plain sentences
    commands: list  # that are run underneath, as somebody would type them
    measure: object  # () -> the text below the commands
    logs: tuple = ()
    is_timed: bool = False  # another load on the machine changes its figures
    is_of_algorithm: bool = True  # another algorithm may change them

    @property
    def name(self):
        return self.title.lower().replace(" ", "-")

    def missing_logs(self):
        return [log for log in self.logs if not (DATA / log).exists()]


def radish(name):
    return f"radish/{name}.clf.gz"


def progress(text):
    print(f"results: {text}", file=sys.stderr, flush=True)


def call(*command, environment=None, may_fail=False):
    """What a command prints. What it says on stderr is shown where it fails."""
    done = subprocess.run([str(part) for part in command], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True, cwd=PROJECT, env={**os.environ, **(environment or {})})
    if done.returncode != 0 and not may_fail:
        raise Failed(f"exit code {done.returncode}: {' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout


def call_script(name, *arguments, environment=None):
    """What a script of the project prints, with the programs and logs that are measured here."""
    known = {"CRSM_BIN_DIR": str(BIN), "CRSM_DATA": str(DATA)}
    return call(PROJECT / "scripts" / name, *arguments, environment={**known, **(environment or {})})


def call_tests(name, filter_, environment=None, may_fail=False):
    """What tests print that print figures."""
    return call(BIN / name, filter_, environment={"CRSM_DATA": str(DATA), **(environment or {})}, may_fail=may_fail)


@dataclasses.dataclass(frozen=True)
class Run:
    """A log that slam_offline has mapped, and what that came to."""

    summary: dict
    error_m: float       # nan where there is nothing to compare with
    worst_m: float       # of the poses, beside their truth; else nan
    processor_s: float   # of the process and of the kernel for it

    def timing_ms(self, which):
        return self.summary["timings"]["slam_offline"][which]


def run_measured(command):
    """What the system says that a command took, as os.wait4 has it."""
    command = [str(part) for part in command]
    with tempfile.TemporaryFile("w+") as said:
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=said, stderr=subprocess.STDOUT)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            said.seek(0)
            raise Failed(f"exit code {process.returncode}: {' '.join(command)}\n{said.read()}")
    return usage


def map_log(source, flags, relations=None, laser_x_m=0.0, align_truth=False):
    """Maps a log in a folder that goes afterwards. The error is that of the relations, or of the path from its truth."""
    with tempfile.TemporaryDirectory(prefix="crsm_results_") as out:
        usage = run_measured([BIN / "slam_offline", source, "--out", out, "--force", *flags])
        error_m = worst_m = float("nan")
        if relations:
            error_m = json.loads(call(BIN / "slam_eval", "relations", out, relations, "--laser-x-m", laser_x_m,
                                      "--json"))["translation_m"]["mean"]
        elif align_truth:
            errors = json.loads(call(BIN / "slam_eval", "trajectory", out, "--align", "--json"))
            error_m, worst_m = errors["rmse_m"], errors["max_m"]
        return Run(json.loads((pathlib.Path(out) / "summary.json").read_text()), error_m, worst_m, usage.ru_utime + usage.ru_stime)


def map_radish(name, flags, log=None, odometry=False):
    """A log of the Radish repository, whole or another copy of it, and the error of its relations."""
    return map_log(log or DATA / radish(name), [*SICK, *([] if odometry else ["--no-odometry"]), *flags], DATA / f"radish/{name}.relations",
                   -0.04 if name == "fr079" else 0.0)


def map_all(title, jobs):
    """Does jobs on all cores. jobs: by a key, what to call. Returns what each came to, by the key."""
    results = {}
    lock = threading.Lock()
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        def do(key, job):
            result = job()
            with lock:
                results[key] = result
                if len(results) % max(1, len(jobs) // 10) == 0:
                    progress(f"{title}: {len(results)} of {len(jobs)}")

        futures = [pool.submit(do, key, job) for key, job in jobs.items()]
        try:
            for future in concurrent.futures.as_completed(futures):
                future.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return results


def median(values):
    return statistics.median(values)
