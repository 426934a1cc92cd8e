"""Draws mutants: the source with one fault in it."""

import collections
import dataclasses
import hashlib

from faults import find_faults
from scanner import Lines


@dataclasses.dataclass(frozen=True)
class Mutant:
    file: str  # relative to the project
    line: int
    column: int
    kind: str
    start: int  # offsets of what is replaced
    end: int
    text: str  # what stands there instead
    replaced: str  # what stood there
    original: str  # the whole lines, blanks joined
    mutated: str

    @property
    def place(self):
        return f"{self.file}:{self.line}:{self.column}"

    @property
    def id(self):
        return f"{self.place} {self.kind}: {_short(self.replaced)} -> {_short(self.text)}"

    @property
    def key(self):
        """Finds the mutant again when lines have moved."""
        return self.file, self.original, self.mutated

    def apply(self, content):
        return content[:self.start] + self.text + content[self.end:]


def _short(text):
    return "'" + " ".join(text.split()) + "'"


def mutants_of(file, content):
    """All mutants of a file, in its order."""
    lines = Lines(content)
    mutants = []
    for fault in find_faults(content):
        begin, end = lines.span(fault.start, fault.end)
        changed = content[begin:fault.start] + fault.text + content[fault.end:end]
        mutants.append(Mutant(file, lines.line(fault.start), lines.column(fault.start), fault.kind, fault.start,
                              fault.end, fault.text, content[fault.start:fault.end],
                              " ".join(content[begin:end].split()), " ".join(changed.split())))
    return mutants


def all_mutants(project, files):
    return [mutant for file in files for mutant in mutants_of(file, (project / file).read_text())]


def _number(*parts):
    """A random number that is the same for the same parts, whatever else there is to draw from."""
    return hashlib.sha256("\0".join(map(str, parts)).encode()).digest()


def _shuffle(of_line, seed, line):
    """The mutants of a line in a random order in which all kinds come first once, then all once more."""
    of_line = sorted(of_line, key=lambda mutant: _number(seed, *line, mutant.column, mutant.kind, mutant.text))
    seen = collections.Counter()
    turns = {}
    for mutant in of_line:
        turns[mutant] = seen[mutant.kind]
        seen[mutant.kind] += 1
    return sorted(of_line, key=lambda mutant: (turns[mutant], _number(seed, *line, mutant.kind)))


def draw(mutants, seed):
    """All mutants in a random order: first one of each line, then a second one of each line that has two, and so on.

    The order of what did not change stays when other lines change or move.
    """
    by_line = collections.defaultdict(list)
    for mutant in mutants:
        by_line[mutant.file, mutant.line].append(mutant)
    seen = collections.Counter()
    order = []
    for (file, _), of_line in sorted(by_line.items()):
        text = of_line[0].original
        seen[file, text] += 1  # the same text may stand in a file more than once
        line = file, text, seen[file, text]
        order += [((turn, _number(seed, turn, *line)), mutant)
                  for turn, mutant in enumerate(_shuffle(of_line, seed, line))]
    return [mutant for _, mutant in sorted(order, key=lambda entry: entry[0])]
