#!/usr/bin/env python3
"""Looks whether the READMEs are short and plain, whether their links lead somewhere, and whether their figures are those
of tests/RESULTS.md.

usage: tests/readme/check_readmes.py
  README.md has at most 120 lines. Its sentences, and those of all READMEs together, have at most 15 words in the median
  and at most 25 in nine of ten. Each relative link leads to a file or folder of the project, and its anchor to a heading.
  No path of one machine stands in a README or in tests/RESULTS.md. Of a link to a section of tests/RESULTS.md each number
  in its text stands in that section. Of a table whose paragraph before it has such a link, each row stands in that
  section, column by column. Behind such links stands whether the section was measured before the last change.
tests/readme/prose.py says what counts as a sentence and a word.
"""

import pathlib
import re
import sys

import prose
from blocks import SKIPPED, WithoutGit, files_of, in_order
from markdown import links_of, paragraphs_of, sections_of, tables_of
from quotes import (RESULTS, anchor_in_results, columns_in, numbers_in, old_sections, quoted_tables, resolve, title_of,
                    with_marks)

PROJECT = pathlib.Path(__file__).resolve().parents[2]
MOST_LINES = 120
MOST_WORDS_MEDIAN = 15
MOST_WORDS_P90 = 25
MACHINE_PATH = re.compile(r"(?<![\w./:~$}>])/(?:work|home|root|tmp|Users|mnt|srv)\b[^\s`)]*")


class Pages:
    """The texts of the READMEs and of the results, and which files there are."""

    def __init__(self, files, read):
        self.files = set(files)
        self.folders = {str(parent) for file in self.files for parent in pathlib.PurePosixPath(file).parents}
        self.texts = {file: read(file) for file in [*in_order(self.files), *({RESULTS} & self.files)]}
        self.sections = {}

    @property
    def readmes(self):
        return {file: text for file, text in self.texts.items() if file != RESULTS}

    def sections_in(self, file):
        if file not in self.sections:
            self.sections[file] = sections_of(self.texts[file])
        return self.sections[file]


def read_here(project):
    files = [file for file in files_of(project) if (project / file).is_file()]
    return Pages(files, lambda file: (project / file).read_text())


def check_words(pages):
    failures = []
    if (lines := len(pages.texts["README.md"].splitlines())) > MOST_LINES:
        failures.append(f"README.md: {lines} lines, {MOST_LINES} at most")
    for name, texts in (("README.md", [pages.texts["README.md"]]), ("all READMEs", pages.readmes.values())):
        lengths = [length for text in texts for length in prose.lengths_of(text)]
        if (words := prose.percentile(lengths, 0.5)) > MOST_WORDS_MEDIAN:
            failures.append(f"{name}: the median sentence has {words} words, {MOST_WORDS_MEDIAN} at most")
        if (words := prose.percentile(lengths, 0.9)) > MOST_WORDS_P90:
            failures.append(f"{name}: one in ten sentences has {words} words or more, {MOST_WORDS_P90} at most")
    return failures


def check_links(pages):
    failures = []
    for file, text in pages.texts.items():
        for link in links_of(text):
            place = f"{file}:{link.line}: {link.target}"
            if (target := resolve(file, link.target)) is None:
                continue
            path, anchor = target
            if path not in pages.files | pages.folders:
                failures.append(f"{place}: there is no such file")
            elif anchor and path in pages.texts and anchor not in pages.sections_in(path):
                failures.append(f"{place}: there is no such heading")
    return failures


def check_machine_paths(pages):
    return [f"{file}:{number}: a path of one machine: {match[0]}" for file, text in pages.texts.items()
            for number, line in enumerate(text.splitlines(), start=1) for match in MACHINE_PATH.finditer(line)]


def numbers_said(section):
    """The numbers of its prose and its tables, without those of commands, and of its last lines, of when and how."""
    said = [paragraph.text for paragraph in paragraphs_of(section) if not paragraph.text.startswith("Measured ")]
    return numbers_in(" ".join(said + [cell for table in tables_of(section) for row in table.rows for cell in row.cells]))


def check_figures(pages):
    """That the numbers of links to the results stand there."""
    failures = []
    for file, text in pages.readmes.items():
        for link in links_of(text):
            anchor = anchor_in_results(file, link.target)
            if anchor not in pages.sections_in(RESULTS):
                continue
            for number in sorted(numbers_in(link.text) - numbers_said(pages.sections_in(RESULTS)[anchor])):
                failures.append(f"{file}:{link.line}: {number} stands nowhere in {link.target}")
    return failures


def check_tables(pages):
    """That the rows of tables about the results are rows of the results, in the columns of the same names."""
    failures = []
    for file, text in pages.readmes.items():
        for table, anchors in quoted_tables(file, text):
            there = [row for anchor in anchors for row in columns_in(pages.texts[RESULTS], anchor)]
            for row in table.rows:
                columns = dict(zip(table.head[1:], row.cells[1:]))
                if not any(title_of(row.cells) == title and columns.items() <= known.items() for title, known in there):
                    failures.append(f"{file}:{row.line}: no row of the results begins with \"{title_of(row.cells)}\" and has "
                                    f"{', '.join(f'{name}: {cell}' for name, cell in columns.items())}; scripts/results "
                                    "--mark writes what it has")
    return failures


def check_marks(pages):
    """That figures which are older than the algorithm say so wherever they are quoted."""
    old = old_sections(pages.texts.get(RESULTS, ""))
    return [f"{file}: quotes figures of tests/RESULTS.md that were measured before the last change, and does not say so, or "
            "says it of others; scripts/results --mark writes it"
            for file, text in pages.readmes.items() if with_marks(file, text, old) != text]


CHECKS = (check_words, check_links, check_machine_paths, check_figures, check_tables, check_marks)


def main(arguments):
    if arguments:
        print(__doc__.strip())
        return 0 if arguments == ["--help"] else 2
    pages = read_here(PROJECT)
    failures = [failure for check in CHECKS for failure in check(pages)]
    print("\n".join(failures) or f"{len(pages.readmes)} READMEs: all is well")
    return 1 if failures else 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except WithoutGit as error:
        print(f"skipped: {error}")
        sys.exit(SKIPPED)
