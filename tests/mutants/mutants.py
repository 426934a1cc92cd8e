"""The mutation test: its flags, and its course. `scripts/mutants --help` says what it does."""

import argparse
import json
import os
import pathlib
import sys
import threading

import draw
import sources
from campaign import BaselineError, Campaign, Judge
from report import Progress, print_list, print_summary
from results import EquivalentError, Results, read_equivalents, unused_equivalents
from suites import SUITES, sandbox
from workspace import Commands, Stopped, Workspace

PROJECT = pathlib.Path(__file__).resolve().parents[2]
INTERRUPTED = 130  # exit code
NOT_BUILT_OR_TESTED = ("tests/mutants/", "scripts/mutants", "README.md", ".github/")  # the baseline is good without


def parse():
    parser = argparse.ArgumentParser(prog="mutants", usage="see --help")
    parser.add_argument("--num", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=pathlib.Path, default=PROJECT / "out/mutants")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--process", choices=("all", "services", "none"), default="all")
    parser.add_argument("--least", type=float, default=85.0)
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--only", nargs="+")
    parser.add_argument("--rerun-survivors", action="store_true")
    arguments = parser.parse_args()
    for name in ("num", "workers"):
        if getattr(arguments, name) < 1:
            parser.error(f"--{name} must be at least 1")
    return arguments


def choose(arguments, mutants, results):
    """The mutants to judge in their order, how many of them, and whether earlier verdicts count."""
    if arguments.only:
        chosen = []
        for name in arguments.only:
            fitting = [mutant for mutant in mutants if f"{mutant.id} ".startswith((f"{name}:", f"{name} "))]
            if not fitting:
                raise sources.SourceError(f"--only {name}: there is no such mutant, see --list")
            chosen += [mutant for mutant in fitting if mutant not in chosen]
        return chosen, len(chosen), False
    drawn = draw.draw(mutants, arguments.seed)
    if arguments.rerun_survivors:
        survivors = results.survivors()
        chosen = [mutant for mutant in drawn if mutant.key in survivors]
        gone = len(survivors - {mutant.key for mutant in chosen})
        print(f"{len(chosen)} survivors to judge again" + (f"; {gone} are not in the source any more" if gone else ""))
        return chosen, len(chosen), False
    return drawn, arguments.num, True


def prepare(judges, program, tree, stop):
    """Builds and tests the source without a fault in all workspaces at the same time, unless that was done before."""
    errors = []

    def run(judge):
        known = judge.workspace.folder / "baseline.json"
        state = {"tree": tree, "program": program, "suites": [suite.name for suite in judge.suites]}
        try:
            judge.build_baseline()
            before = json.loads(known.read_text()) if known.exists() else {}
            if {**before, "usual_s": None} == {**state, "usual_s": None}:
                judge.usual_s = before["usual_s"]
                return
            judge.test_baseline()
            known.write_text(json.dumps({**state, "usual_s": judge.usual_s}))
        except (BaselineError, Stopped) as error:
            errors.append(error)

    in_threads(run, judges, stop)
    for error in errors:
        raise error


def in_threads(function, items, stop):
    """Calls a function with each item in a thread of its own. After a Ctrl-C, `stop` is called to end them."""
    threads = [threading.Thread(target=function, args=(item,)) for item in items]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        try:
            for thread in threads:
                thread.join(0.2)
        except KeyboardInterrupt:
            print("\nstopped: the same command goes on from here", flush=True)
            stop()


def make_workspaces(arguments, commands):
    """The private copies, configured, and a digest of what they hold."""
    names = [name for name in sources.project_files(PROJECT) if not name.startswith(NOT_BUILT_OR_TESTED)]
    num_jobs = max(1, (os.cpu_count() or 1) // arguments.workers)
    workspaces = []
    for number in range(1, arguments.workers + 1):
        workspace = Workspace(arguments.out / f"worker{number}", commands, num_jobs)
        if not workspace.prepare(PROJECT, names):
            raise BaselineError(f"cmake fails, see {workspace.log}")
        workspaces.append(workspace)
    return workspaces, sources.hash_files(PROJECT, names)


def judge_all(arguments, mutants, results, progress):
    """The records of the mutants that were chosen, and whether all were judged."""
    chosen, num, go_on = choose(arguments, mutants, results)
    command_prefix = sandbox()
    if command_prefix is None:
        raise BaselineError("a mutant needs a sandbox, which the kernel does not allow: needs root, or user namespaces")
    commands = Commands()
    workspaces, tree = make_workspaces(arguments, commands)
    program = sources.program_hash(PROJECT)
    suites = [suite for suite in SUITES if workspaces[0].has_target(suite.target)]
    suites = [suite for suite in suites if arguments.process != "none" or not suite.others]

    def suites_for(mutant):
        with_processes = arguments.process == "all" or mutant.file.startswith("services/")
        return [suite for suite in suites if with_processes or not suite.others]

    def find_record(mutant):
        return results.find(program, mutant, [suite.name for suite in suites_for(mutant)]) if go_on else None

    def report(record, so_far):
        results.add(record)
        progress(record, so_far)

    judges = [Judge(workspace, suites, suites_for, command_prefix, program) for workspace in workspaces]
    print("building and testing the source without a fault", flush=True)
    prepare(judges, program, tree, commands.stop)
    print("green: " + ", ".join(f"{name} {took_s:.0f} s" for name, took_s in judges[0].usual_s.items()), flush=True)
    campaign = Campaign(chosen, num, find_record, report)
    in_threads(campaign.work, judges, commands.stop)
    if campaign.error:
        raise campaign.error
    return campaign.records(), not commands.stopping


def main():
    arguments = parse()
    arguments.out = arguments.out.resolve()
    try:
        mutants = draw.all_mutants(PROJECT, sources.find_sources(PROJECT))
        equivalents = read_equivalents(pathlib.Path(__file__).with_name("equivalent.txt"))
        results = Results(arguments.out / "results.jsonl")
        if arguments.list:
            chosen, num, _ = choose(arguments, mutants, results)
            print_list(chosen[:num])
            return 0
        arguments.out.mkdir(parents=True, exist_ok=True)
        records, finished = judge_all(arguments, mutants, results, Progress(equivalents))
    except (sources.SourceError, EquivalentError, BaselineError) as error:
        print(f"mutants: {error}", file=sys.stderr)
        return 1
    except (KeyboardInterrupt, Stopped):
        return INTERRUPTED
    percent = print_summary(records, equivalents, unused_equivalents(equivalents, mutants))
    if not finished:
        return INTERRUPTED
    return 0 if percent >= arguments.least else 1


if __name__ == "__main__":
    sys.exit(main())
