"""What the READMEs quote from tests/RESULTS.md: the figures in the text of a link to one of its sections, and the tables
whose paragraph before them has such a link. Where a section says that it was measured before the last change of the
algorithm, the same stands behind each link that quotes it."""

import posixpath
import re
import textwrap

import prose
from markdown import LINK, links_of, paragraphs_of, sections_of, tables_of

RESULTS = "tests/RESULTS.md"
BEFORE = "measured before the last change"
WIDTH = 120
LINK_AND_MARK = re.compile(rf"({LINK.pattern})(\s+\({BEFORE}\))?".replace(" ", r"\s+"))


def wrap(text, indent=0):
    return textwrap.fill(text, WIDTH, subsequent_indent=" " * indent, break_long_words=False, break_on_hyphens=False)


def resolve(file, target):
    """The file that a link of a README leads to, from the project's folder, and its anchor; None: it leads elsewhere."""
    if re.match(r"[a-z][a-z0-9+.-]*:", target):
        return None
    path, _, anchor = target.partition("#")
    return (posixpath.normpath(posixpath.join(posixpath.dirname(file), path)) if path else file), anchor


def anchor_in_results(file, target):
    """The section of the results that a link leads to; None: it leads elsewhere."""
    path, anchor = resolve(file, target) or ("", "")
    return anchor if path == RESULTS and anchor else None


def numbers_in(text):
    """The numbers of a text as they are written, but for commas between thousands; none in code or in names."""
    return {number.replace(",", "") for number in prose.NUMBER.findall(prose.plain(text, code="code"))}


def title_of(cells):
    return prose.plain(cells[0].replace("`", "")) if cells else ""


def old_sections(results):
    """Of the page of results: the anchors of the sections that say that they are older than the algorithm."""
    return {anchor for anchor, text in sections_of(results).items()
            if any(paragraph.text.startswith(BEFORE.capitalize()) for paragraph in paragraphs_of(text))}


def columns_in(results, anchor):
    """Of a section's tables: by the title of a row, the cells of its columns. Titles may come more than once."""
    return [(title_of(row.cells), dict(zip(table.head[1:], row.cells[1:])))
            for table in tables_of(sections_of(results).get(anchor, "")) for row in table.rows]


def quoted_tables(file, text):
    """The tables of a README that quote, each with the sections that it quotes."""
    for table in tables_of(text):
        anchors = [anchor for link in links_of(table.before) if (anchor := anchor_in_results(file, link.target))]
        if anchors:
            yield table, anchors


def with_marks(file, text, old):
    """A README with the mark behind each link that quotes an old section, and behind no other."""
    lines = text.splitlines()
    before_tables = {table.before for table, _ in quoted_tables(file, text)}
    for paragraph in reversed(paragraphs_of(text)):
        def marked(found, is_before_table=paragraph.text in before_tables):
            link, _, words, target, _ = found.groups()
            is_marked = anchor_in_results(file, target) in old and (is_before_table or numbers_in(words))
            return f"{link} ({BEFORE})" if is_marked else link

        source = "\n".join(lines[paragraph.line - 1:paragraph.end])
        if (new := LINK_AND_MARK.sub(marked, source)) != source:
            item = re.match(r"\s*(?:[-*+] |\d+[.)] )?", new)[0]
            joined = " ".join(line.strip() for line in new.splitlines())
            lines[paragraph.line - 1:paragraph.end] = wrap(item + joined[len(item.strip()):].strip(), len(item)).splitlines()
    return "\n".join(lines) + "\n"


def with_figures(file, text, results):
    """A README whose quoted tables have what the results have in the row and the column of that name."""
    lines = text.splitlines()
    for table, anchors in quoted_tables(file, text):
        there = {title: columns for anchor in anchors for title, columns in columns_in(results, anchor)}
        for row in table.rows:
            columns = there.get(title_of(row.cells), {})
            cells = [columns.get(name, cell) for name, cell in zip(table.head, row.cells)]
            lines[row.line - 1] = f"| {' | '.join(cells)} |"
    return "\n".join(lines) + "\n"


def with_quotes(file, text, results):
    """A README as it has to be beside these results, but for the figures in the text of links."""
    return with_figures(file, with_marks(file, text, old_sections(results)), results)
