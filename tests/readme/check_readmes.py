#!/usr/bin/env python3
"""Looks whether the READMEs are short and plain, whether their links lead somewhere, and whether their figures are those
of tests/RESULTS.md.

usage: tests/readme/check_readmes.py
  README.md has at most 120 lines. Its sentences, and those of all READMEs together, have at most 15 words in the median
  and at most 25 in nine of ten. Each relative link leads to a file or folder of the project, and its anchor to a heading.
  No path of one machine stands in a README or in tests/RESULTS.md. Of a link to a section of tests/RESULTS.md each number
  in its text stands in that section. Of a table whose paragraph before it has such a link, the numbers of each row stand
  in one row of that section that begins with the same cell.
usage: tests/readme/check_readmes.py --stats [--at COMMIT]
  prints the lines, words and figures of each README and how long its sentences are, as they are here or at a commit
usage: tests/readme/check_readmes.py --long [N]
  prints the sentences of more than N words (25), the longest first
tests/readme/prose.py says what counts as a sentence, a word and a figure.
"""

import pathlib
import posixpath
import re
import subprocess
import sys

import prose
from blocks import files_of, in_order
from markdown import links_of, paragraphs_of, sections_of, tables_of

PROJECT = pathlib.Path(__file__).resolve().parents[2]
RESULTS = "tests/RESULTS.md"
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


def read_at(project, commit):
    def git(*arguments):
        return subprocess.run(["git", *arguments], cwd=project, check=True, stdout=subprocess.PIPE, text=True).stdout

    return Pages(git("ls-tree", "-r", "-z", "--name-only", commit).split("\0")[:-1],
                 lambda file: git("show", f"{commit}:{file}"))


def resolve(file, link):
    """The file that a link of a README leads to, from the project's folder, and its anchor; None: it leads elsewhere."""
    if re.match(r"[a-z][a-z0-9+.-]*:", link.target):
        return None
    path, _, anchor = link.target.partition("#")
    return (posixpath.normpath(posixpath.join(posixpath.dirname(file), path)) if path else file), anchor


def check_words(pages):
    failures = []
    statistics = {file: prose.count(text) for file, text in pages.readmes.items()}
    if (lines := statistics["README.md"].lines) > MOST_LINES:
        failures.append(f"README.md: {lines} lines, {MOST_LINES} at most")
    for name, counted in (("README.md", statistics["README.md"]), ("all READMEs", prose.add(statistics.values()))):
        for what, words, most in (("the median sentence", counted.median, MOST_WORDS_MEDIAN),
                                  ("one in ten sentences", counted.p90, MOST_WORDS_P90)):
            if words > most:
                failures.append(f"{name}: {what} has {words} words{' or more' if 'ten' in what else ''}, {most} at most")
    return failures


def check_links(pages):
    failures = []
    for file, text in pages.texts.items():
        for link in links_of(text):
            place = f"{file}:{link.line}: {link.target}"
            if (target := resolve(file, link)) is None:
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


def numbers_in(text):
    """The numbers of a text as they are written, but for commas between thousands; none in code or in names."""
    return {number.replace(",", "") for number in prose.NUMBER.findall(prose.plain(text, code="code"))}


def measured(section):
    """What a section says: its prose and its tables, without commands, and without its last lines of when and how."""
    said = [paragraph.text for paragraph in paragraphs_of(section) if not paragraph.text.startswith("Measured ")]
    return said, [row for table in tables_of(section) for row in table.rows]


def results_section(pages, file, link):
    """What the section of the results that a link leads to says; None: it leads elsewhere, or nowhere."""
    path, anchor = resolve(file, link) or ("", "")
    section = pages.sections_in(RESULTS).get(anchor) if path == RESULTS and RESULTS in pages.texts else None
    return None if section is None else measured(section)


def check_figures(pages):
    """That the numbers of links to the results stand there."""
    failures = []
    for file, text in pages.readmes.items():
        for link in links_of(text):
            if (section := results_section(pages, file, link)) is None:
                continue
            said, rows = section
            there = numbers_in(" ".join(said + [cell for row in rows for cell in row.cells]))
            for number in sorted(numbers_in(link.text) - there):
                failures.append(f"{file}:{link.line}: {number} stands nowhere in {link.target}")
    return failures


def title_of(cells):
    return prose.plain(cells[0].replace("`", "")) if cells else ""


def check_tables(pages):
    """That the rows of tables about the results are rows of the results."""
    failures = []
    for file, text in pages.readmes.items():
        for table in tables_of(text):
            sections = [section for link in links_of(table.before) if (section := results_section(pages, file, link))]
            if not sections:
                continue
            for row in table.rows:
                there = [numbers_in(" | ".join(other.cells[1:])) for _, rows in sections for other in rows
                         if title_of(other.cells) == title_of(row.cells)]
                if not any(numbers_in(" | ".join(row.cells[1:])) <= numbers for numbers in there):
                    failures.append(f"{file}:{row.line}: no row of the results begins with \"{title_of(row.cells)}\" and "
                                    f"has all of {', '.join(sorted(numbers_in(' | '.join(row.cells[1:]))))}")
    return failures


CHECKS = (check_words, check_links, check_machine_paths, check_figures, check_tables)


def print_statistics(pages):
    statistics = {file: prose.count(text) for file, text in pages.readmes.items()}
    statistics["all"] = prose.add(statistics.values())
    print(f"{'':<32}{'lines':>7}{'words':>7}{'sentences':>11}{'median':>8}{'90 %':>6}{'figures':>9}{'linked':>8}")
    for name, counted in statistics.items():
        print(f"{name:<32}{counted.lines:>7}{counted.words:>7}{len(counted.sentence_words):>11}{counted.median:>8}"
              f"{counted.p90:>6}{counted.figures:>9}{counted.linked_figures:>8}")


def print_long(pages, least):
    sentences = [(len(prose.words_of(sentence)), f"{file}:{line}", sentence) for file, text in pages.readmes.items()
                 for line, sentence in prose.sentences_of(text)]
    for words, place, sentence in sorted(sentences, reverse=True):
        if words > least:
            print(f"{words:4} {place}: {sentence}")


def main(arguments):
    match arguments:
        case []:
            pages = read_here(PROJECT)
            failures = [failure for check in CHECKS for failure in check(pages)]
            print("\n".join(failures) or f"{len(pages.readmes)} READMEs: all is well")
            return 1 if failures else 0
        case ["--stats"]:
            print_statistics(read_here(PROJECT))
        case ["--stats", "--at", commit]:
            print_statistics(read_at(PROJECT, commit))
        case ["--long"]:
            print_long(read_here(PROJECT), MOST_WORDS_P90)
        case ["--long", number] if number.isdigit():
            print_long(read_here(PROJECT), int(number))
        case _:
            print(__doc__.strip())
            return 0 if arguments == ["--help"] else 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
