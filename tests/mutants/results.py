"""Verdicts on mutants, kept in a file of JSON lines, and the mutants that are known to change nothing."""

import json

CAUGHT, SURVIVED, EQUIVALENT, NOT_BUILT = "caught", "survived", "equivalent", "does not build"


class Results:
    """All verdicts of a file; the last one on a mutant counts."""

    def __init__(self, path):
        self.path = path
        self.records = []
        if path.exists():
            for line in path.read_text().splitlines():
                try:
                    self.records.append(json.loads(line))
                except json.JSONDecodeError:
                    pass  # the last line of a run that was killed
        self.by_id = {(record["program"], record["id"]): record for record in self.records}

    def add(self, record):
        self.records.append(record)
        self.by_id[record["program"], record["id"]] = record
        begin = "\n" if self.path.exists() and not self.path.read_bytes().endswith(b"\n") else ""
        with self.path.open("a") as file:
            file.write((begin if self.path.stat().st_size else "") + json.dumps(record) + "\n")

    def find(self, program, mutant, suites):
        """The verdict on a mutant of this program. A survivor that some of these suites have not seen has none."""
        record = self.by_id.get((program, mutant.id))
        if record and record["verdict"] == SURVIVED and not set(suites) <= set(record["passed"]):
            return None
        return record

    def survivors(self):
        """Keys of mutants, of this program or of earlier ones, whose last verdict is that they survived."""
        last = {(record["file"], record["original"], record["mutated"]): record["verdict"] for record in self.records}
        return {key for key, verdict in last.items() if verdict == SURVIVED}


class EquivalentError(Exception):
    """What is wrong in the file of equivalent mutants."""


def read_equivalents(path):
    """Reason by key of a mutant. Each entry of the file, after an empty line, is

    path/of/the/file
    - the original line
    + the mutated line
    the reason, on one line or more

    Lines that begin with # are skipped, and blanks count as one.
    """
    equivalents = {}
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    for entry in "\n".join(lines).split("\n\n"):
        parts = [" ".join(line.split()) for line in entry.strip().splitlines()]
        if not parts:
            continue
        if len(parts) < 4 or parts[1][:2] != "- " or parts[2][:2] != "+ ":
            raise EquivalentError(f"{path}: '{parts[0]}' is not followed by '- original', '+ mutated' and a reason")
        equivalents[parts[0], parts[1][2:], parts[2][2:]] = " ".join(parts[3:])
    return equivalents


def unused_equivalents(equivalents, mutants):
    """Keys of entries that no mutant of the source has any more."""
    known = {mutant.key for mutant in mutants}
    return [key for key in equivalents if key not in known]


def with_equivalents(records, equivalents):
    """The records, in which survivors that are named in the file are equivalent."""
    judged = []
    for record in records:
        reason = equivalents.get((record["file"], record["original"], record["mutated"]))
        if record["verdict"] == SURVIVED and reason:
            record = {**record, "verdict": EQUIVALENT, "test": reason}
        judged.append(record)
    return judged


def count(records):
    counts = dict.fromkeys((CAUGHT, SURVIVED, EQUIVALENT, NOT_BUILT), 0)
    for record in records:
        counts[record["verdict"]] += 1
    return counts


def score(records):
    """Share of those caught among those that change something, in percent; 100 if there are none."""
    counts = count(records)
    num = counts[CAUGHT] + counts[SURVIVED]
    return 100.0 * counts[CAUGHT] / num if num else 100.0
