"""What a page of Markdown is made of, as far as the READMEs use it: lines by kind, paragraphs, headings, links, tables."""

import dataclasses
import re

from blocks import COMMAND

ITEM = re.compile(r"\s*(?:[-*+]|\d+[.)])\s+")
CODE_SPAN = re.compile(r"(`+)(?!`)(.+?)(?<!`)\1(?!`)", re.DOTALL)
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\[\]]*\])*)\]\(([^()\s]+)(?:\s+\"[^\"]*\")?\)")


@dataclasses.dataclass(frozen=True)
class Paragraph:
    line: int  # the first, from 1
    end: int   # the last
    text: str


@dataclasses.dataclass(frozen=True)
class Link:
    line: int
    text: str
    target: str


@dataclasses.dataclass(frozen=True)
class Row:
    line: int
    cells: list


@dataclasses.dataclass(frozen=True)
class Table:
    before: str  # the paragraph before it, or nothing
    head: list   # the names of its columns
    rows: list   # without the two lines of its head


def kinds_of(text):
    """Of each line: blank, code, heading, table, picture (and nothing else), item (its first line) or prose."""
    kinds = []
    fenced = in_list = commented = False
    for line in text.splitlines():
        stripped = line.strip()
        before = kinds[-1] if kinds else "blank"
        if fenced or stripped.startswith("```"):
            fenced ^= stripped.startswith("```")
            kind = "code"
        elif commented or stripped.startswith("<!--"):
            commented = "-->" not in stripped
            kind = "code"
        elif not stripped:
            kind = "blank"
        elif line.startswith("    ") and before in ("blank", "code", "heading") and (not in_list or COMMAND.match(line)):
            kind = "code"
        elif stripped.startswith("#") and re.match(r"#{1,6} ", stripped):
            kind = "heading"
        elif stripped.startswith("|"):
            kind = "table"
        elif ITEM.match(line):
            kind = "item"
        elif re.fullmatch(r"!\[[^\]]*\]\([^)]*\)", stripped):
            kind = "picture"
        else:
            kind = "prose"
        if kind == "item":
            in_list = True
        elif kind in ("heading", "table") or kind == "prose" and before == "blank" and not line.startswith(" "):
            in_list = False
        kinds.append(kind)
    return kinds


def paragraphs_of(text):
    """The prose: paragraphs, and the items of lists, each one by itself."""
    paragraphs = []
    before = None
    for number, (line, kind) in enumerate(zip(text.splitlines(), kinds_of(text)), start=1):
        if kind == "item" or kind == "prose" and before not in ("item", "prose"):
            paragraphs.append(Paragraph(number, number, ITEM.sub("", line, count=1) if kind == "item" else line.strip("> ")))
        elif kind == "prose":
            paragraphs[-1] = Paragraph(paragraphs[-1].line, number, f"{paragraphs[-1].text} {line.strip('> ')}")
        before = kind
    return paragraphs


def headings_of(text):
    """The line, level and title of each."""
    return [(number, len(line) - len(line.lstrip("#")), line.lstrip("#").strip())
            for number, (line, kind) in enumerate(zip(text.splitlines(), kinds_of(text)), start=1) if kind == "heading"]


def anchor_of(title):
    """As GitHub makes it."""
    title = LINK.sub(r"\2", title).replace("`", "").lower()
    return re.sub(r"[^\w\- ]", "", title).replace(" ", "-")


def sections_of(text):
    """The lines below each heading, by its anchor: up to the next one that is no deeper."""
    lines = text.splitlines()
    headings = headings_of(text)
    sections = {}
    for index, (number, level, title) in enumerate(headings):
        end = next((other - 1 for other, depth, _ in headings[index + 1:] if depth <= level), len(lines))
        anchor, count = anchor_of(title), 1
        while anchor in sections:
            anchor, count = f"{anchor_of(title)}-{count}", count + 1
        sections[anchor] = "\n".join(lines[number:end])
    return sections


def links_of(text):
    """The links and pictures, without those in code."""
    lines = [" " * len(line) if kind == "code" else line for line, kind in zip(text.splitlines(), kinds_of(text))]
    blanked = CODE_SPAN.sub(lambda span: re.sub(r"[^\n]", "x", span[0]), "\n".join(lines))
    shown = "\n".join(lines)

    def find(begin, end):
        for match in LINK.finditer(blanked, begin, end):
            yield Link(blanked.count("\n", 0, match.start()) + 1, shown[match.start(2):match.end(2)],
                       shown[match.start(3):match.end(3)])
            yield from find(match.start(2), match.end(2))

    return list(find(0, len(blanked)))


def tables_of(text):
    """The tables, each with the paragraph before it."""
    tables = []
    paragraphs = {paragraph.line: paragraph.text for paragraph in paragraphs_of(text)}
    latest = ""
    before = None
    for number, (line, kind) in enumerate(zip(text.splitlines(), kinds_of(text)), start=1):
        latest = paragraphs.get(number, "" if kind in ("heading", "code") else latest)
        if kind == "table":
            if before != "table":
                tables.append(Table(latest, [], []))
                latest = ""
            tables[-1].rows.append(Row(number, cells_of(line)))
        before = kind
    return [Table(table.before, table.rows[0].cells, table.rows[2:]) for table in tables]


def cells_of(line):
    """What stands between the bars of a line, without those in code or behind a backslash."""
    blanked = CODE_SPAN.sub(lambda span: "x" * len(span[0]), line.replace("\\|", "xx"))
    bars = [at for at, sign in enumerate(blanked) if sign == "|"]
    return [line[begin + 1:end].strip() for begin, end in zip(bars, bars[1:])]
