"""Judges mutants, several at a time."""

import hashlib
import threading
import time

from results import CAUGHT, EQUIVALENT, NOT_BUILT, SURVIVED
from suites import LEAST_TIMEOUT_S, TIMEOUT_FACTOR, run_suite
from workspace import Stopped

SAME_PROGRAM = "the compiler makes the same program of it"


class BaselineError(Exception):
    """Why the source without a fault cannot be judged."""


class Judge:
    """Builds and tests mutants in one workspace."""

    def __init__(self, workspace, suites, suites_for, command_prefix, program):
        self.workspace = workspace
        self.suites = suites
        self.suites_for = suites_for  # which of them a mutant has to pass
        self.command_prefix = command_prefix
        self.program = program
        self.usual_s = {}  # time that each suite takes
        self.fingerprints = {}  # of what each suite runs

    def fingerprint(self, suite):
        """A digest of the programs that a suite runs."""
        programs = self.workspace.build_folder / "bin"
        names = {suite.target}
        if suite.others:
            names |= {path.name for path in programs.iterdir() if not path.name.endswith("_tests")}
        digest = hashlib.sha256()
        for name in sorted(names):
            digest.update((programs / name).read_bytes())
        return digest.hexdigest()

    def build_baseline(self):
        """Builds the source without a fault."""
        for suite in self.suites:
            if not self.workspace.build(suite.target):
                raise BaselineError(f"{suite.target} cannot be built, see {self.workspace.log}")
            self.fingerprints[suite.name] = self.fingerprint(suite)
        self.workspace.keep_pristine()

    def test_baseline(self):
        """Tests the source without a fault, and takes the time."""
        for suite in self.suites:
            begin = time.monotonic()
            outcome = self._run(suite, 3600)
            self.usual_s[suite.name] = time.monotonic() - begin
            if not outcome.passed:
                raise BaselineError(f"{suite.target} fails without any fault: {outcome.test}")

    def judge(self, mutant):
        """The record of a mutant."""
        begin = time.monotonic()
        with self.workspace.with_mutant(mutant):
            verdict, test, passed = self._test(mutant)
        return {"program": self.program, "id": mutant.id, "file": mutant.file, "line": mutant.line, "kind": mutant.kind,
                "original": mutant.original, "mutated": mutant.mutated, "verdict": verdict, "test": test,
                "passed": passed, "seconds": round(time.monotonic() - begin, 1)}

    def _test(self, mutant):
        """Verdict, who gave it, and the suites that let the mutant through."""
        passed, same = [], True
        suites = self.suites_for(mutant)
        for suite in suites:
            if not self.workspace.build(suite.target):
                return NOT_BUILT, "", passed
            if self.fingerprint(suite) != self.fingerprints[suite.name]:
                same = False
                outcome = self._run(suite, max(LEAST_TIMEOUT_S, TIMEOUT_FACTOR * self.usual_s[suite.name]))
                if not outcome.passed:
                    return CAUGHT, f"{suite.name}: {outcome.test}", passed
            passed.append(suite.name)
        if same and any(suite.others for suite in suites):
            return EQUIVALENT, SAME_PROGRAM, passed
        return SURVIVED, "", passed

    def _run(self, suite, timeout_s):
        for _ in range(suite.tries):
            outcome = run_suite(self.workspace, suite, self.command_prefix, timeout_s)
            if outcome.passed:
                break
        return outcome


class Campaign:
    """Hands out mutants in their order until `num` of them were built, and collects the records in this order."""

    def __init__(self, mutants, num, find_record, report):
        self.mutants = mutants
        self.num = num
        self.find_record = find_record  # of a mutant that was judged before
        self.report = report  # called with each new record and this campaign
        self.changed = threading.Condition()
        self.next = 0
        self.in_work = 0
        self.stopping = False
        self.by_index = {}
        self.error = None

    def records(self):
        return [self.by_index[i] for i in sorted(self.by_index)]

    def num_built(self):
        return sum(record["verdict"] != NOT_BUILT for record in self.by_index.values())

    def _take(self):
        """Index of the next mutant to judge; None when there is nothing left to do."""
        with self.changed:
            while not self.stopping:
                if self.num_built() + self.in_work < self.num and self.next < len(self.mutants):
                    index = self.next
                    self.next += 1
                    record = self.find_record(self.mutants[index])
                    if record:
                        self.by_index[index] = record
                        continue
                    self.in_work += 1
                    return index
                if self.in_work == 0:
                    return None
                self.changed.wait()  # one of those in work may not build
            return None

    def work(self, judge):
        """Judges mutants until there are no more: one thread for each judge."""
        while (index := self._take()) is not None:
            record = error = None
            try:
                record = judge.judge(self.mutants[index])
            except Stopped:
                self.stopping = True
            except Exception as failure:  # shown by the main thread
                self.stopping = True
                error = failure
            with self.changed:
                self.in_work -= 1
                self.error = self.error or error
                if record:
                    self.by_index[index] = record
                    self.report(record, self)
                self.changed.notify_all()
        with self.changed:
            self.changed.notify_all()
