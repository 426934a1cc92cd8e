"""Whether a section of tests/RESULTS.md is of today's algorithm, and the mark that it has where it is older.

A section names the algorithm that it measured by a checksum of its source. So a copy without git, or of the latest commits
alone, knows as well what is old, and a commit that was given another name is no other algorithm."""

import hashlib
import re
import sys

import page
from measure import PROJECT

sys.path.insert(0, str(PROJECT / "tests/readme"))
from blocks import files_of, in_order
from quotes import BEFORE, with_quotes, wrap

ALGORITHM = ("diagnosis", "graph", "map", "match", "math", "scan", "parameters.cpp", "parameters.hpp", "slam.cpp", "slam.hpp")


def algorithm_of(project=PROJECT):
    """The first digits of a checksum of all that decides a map, but for lines of comments alone and empty ones."""
    checksum = hashlib.sha256()
    named = [project / "common" / name for name in ALGORITHM]
    for path in sorted(file for path in named for file in (path.rglob("*.[ch]pp") if path.is_dir() else [path])):
        lines = [line.strip() for line in path.read_text().splitlines()]
        code = [line for line in lines if line and not line.startswith("//")]
        checksum.update("\n".join([str(path.relative_to(project)), *code, ""]).encode())
    return checksum.hexdigest()[:8]


def with_age(text, algorithm):
    """A section whose last paragraph says whether it was measured before that algorithm."""
    said, when = text.strip().rsplit("\n\n", 1)
    when = re.sub(rf"^Measured at |^{BEFORE.capitalize()}, at ", "Measured at ", " ".join(when.split()))
    if f"(algorithm {algorithm})" not in when:
        when = when.replace("Measured at ", f"{BEFORE.capitalize()}, at ", 1)
    return f"{said}\n\n{wrap(when)}\n"


def marked_sections(path, sections):
    """The sections of a page as they have to be beside today's algorithm, of those that it decides."""
    head, there = page.read(path)
    titles = {section.title for section in sections if section.is_of_algorithm}
    algorithm = algorithm_of()
    return head, {title: with_age(text, algorithm) if title in titles else text for title, text in there.items()}


def mark(path, sections):
    """Writes the marks on the page, and the READMEs that quote it. Returns the files that changed."""
    before = path.read_text()
    page.write(path, *marked_sections(path, sections), [section.title for section in sections])
    results = path.read_text()
    changed = [path] if results != before else []
    for name in in_order(files_of(PROJECT)):
        readme = PROJECT / name
        text = readme.read_text()
        if (quoted := with_quotes(name, text, results)) != text:
            readme.write_text(quoted)
            changed.append(readme)
    return [str(file.relative_to(PROJECT)) for file in changed]
