"""The page of results: its sections, each of which is written as a whole."""

import os
import pathlib
import re
import tempfile

HEAD = """# Results

What the READMEs quote, and more, each figure beside the command that measured it and wrote it here. `LOG` is a log of
`$CRSM_DATA`, or `../shared/data`, and `DIR` a folder of results; `N` is a seed.

A section *measured before the last change* is older than the algorithm of today. Its command may give other figures now.
"""


def read(path):
    """What stands before the first section, and the sections by their titles."""
    text = path.read_text() if path.exists() else HEAD
    head, *parts = re.split(r"^## (.*)\n", text, flags=re.MULTILINE)
    return head, dict(zip(parts[::2], parts[1::2]))


def write(path, head, sections, order):
    """All sections, those of `order` first and in its order. The file is the old one or the new one at any moment."""
    titles = [title for title in order if title in sections] + [title for title in sections if title not in order]
    text = "\n".join([head.strip() + "\n", *(f"## {title}\n\n{sections[title].strip()}\n" for title in titles)])
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    with os.fdopen(handle, "w") as file:
        file.write(text)
    os.chmod(name, 0o644)
    pathlib.Path(name).replace(path)


def table(head, rows):
    """Lines of a table of Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(map(str, line))} |" for line in lines)
