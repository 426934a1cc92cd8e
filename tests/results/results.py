"""Measures sections of tests/RESULTS.md and writes them. See scripts/results."""

import argparse
import datetime
import os
import pathlib
import platform
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "ablation"))
import ablate
import accuracy
import age
import bounds
import costs
import endurance
import page
import places
from measure import PROJECT, Failed, progress
from quotes import wrap

SECTIONS = [*accuracy.SECTIONS, *bounds.SECTIONS, *places.SECTIONS, *ablate.SECTIONS, *costs.SECTIONS, *endurance.SECTIONS]
RESULTS = PROJECT / "tests/RESULTS.md"
BUSY_CORES = 0.2  # of other work, from which on a time is said to be measured beside it
LOOK_S = 2.0       # at other work, before and behind a section


def git(*arguments):
    return subprocess.run(["git", *arguments], cwd=PROJECT, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                          text=True).stdout.strip()


def commit():
    """The commit of what was measured; whether the code differs from it."""
    changed = git("status", "--porcelain", "--untracked-files=no", "--", "common", "services", "lcmtypes", "scripts/presets",
                  "CMakeLists.txt")
    return (git("rev-parse", "--short", "HEAD") or "no commit") + (" with changes" if changed else "")


def processor():
    names = [line.partition(":")[2].strip() for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines()
             if line.startswith("model name")] if os.path.exists("/proc/cpuinfo") else []
    return names[0] if names else platform.machine()


def cores_of_other_work():
    """How many cores are busy while nothing of ours runs, on average of some seconds."""
    def ticks():
        fields = [int(field) for field in pathlib.Path("/proc/stat").read_text().splitlines()[0].split()[1:9]]
        return sum(fields), fields[3] + fields[4]  # idle, and idle but for a disk

    (before, idle_before), _, (after, idle_after) = ticks(), time.sleep(LOOK_S), ticks()
    return (os.cpu_count() or 1) * (1.0 - (idle_after - idle_before) / max(1, after - before))


def say_when(section, busy_cores):
    text = f"Measured at {commit()}{f' (algorithm {age.algorithm_of()})' if section.is_of_algorithm else ''}"
    text += f" on {datetime.date.today()}"
    if section.is_timed:
        text += f", on {len(os.sched_getaffinity(0))} cores of {processor()}"
        if busy_cores > BUSY_CORES:
            text += f", beside other work, which kept {busy_cores:.1f} cores busy before or after it"
    return text + "."


def write_section(section, text, busy_cores, path):
    indented = "\n".join(f"    {command}" for command in section.commands)
    body = "\n\n".join([wrap(section.about), f"    scripts/results {section.name}", "It runs", indented, text.strip(),
                        wrap(say_when(section, busy_cores))])
    head, sections = page.read(path)
    page.write(path, head, {**sections, section.title: body}, [other.title for other in SECTIONS])


def print_list():
    for section in SECTIONS:
        missing = ", ".join(section.missing_logs())
        print(f"{section.name:<16} {section.minutes:>4g} min  {section.title}{f'; needs {missing}' if missing else ''}")


def main():
    parser = argparse.ArgumentParser(prog="scripts/results")
    parser.add_argument("sections", nargs="*", metavar="SECTION")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--mark", action="store_true")
    parser.add_argument("--file", type=pathlib.Path, default=RESULTS)
    arguments = parser.parse_args()
    if arguments.list:
        return print_list()
    if arguments.mark:
        print("\n".join(age.mark(RESULTS, SECTIONS)) or "nothing changed")
        return 0
    known = {section.name: section for section in SECTIONS}
    if unknown := [name for name in arguments.sections if name not in known]:
        parser.error(f"no section {unknown[0]}; there are: {', '.join(known)}")
    failed = 0
    for section in [known[name] for name in arguments.sections] or SECTIONS:
        if missing := section.missing_logs():
            progress(f"{section.name}: left as it is: there is no {', '.join(missing)}; CRSM_DATA names the folder of logs")
            continue
        progress(f"{section.name}: about {section.minutes:g} minutes")
        begin, busy_cores = time.monotonic(), cores_of_other_work()
        try:
            text = section.measure()
            write_section(section, text, max(busy_cores, cores_of_other_work()), arguments.file)
            progress(f"{section.name}: written after {(time.monotonic() - begin) / 60:.1f} minutes")
            if arguments.file == RESULTS:
                age.mark(RESULTS, SECTIONS)
        except Failed as failure:
            progress(f"{section.name}: left as it is: {failure}")
            failed = 1
    return failed


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        progress("interrupted: what was measured before is written")
        sys.exit(130)
