"""Cuts C++ into tokens, as far as it takes to find places for faults. It relies on the layout that clang-format makes:
a binary operator stands between blanks, and a template bracket, a pointer's star or a sign does not."""

import bisect
import dataclasses
import re

_PATTERNS = [
    ("comment", r"//(?:[^\n\\]|\\.|\\\n)*|/\*.*?\*/"),
    ("directive", r"^[ \t]*#(?:[^\n\\]|\\\n|\\.)*"),
    ("string", r'(?:u8|[uUL])?R"(?P<delimiter>[^\s()\\]*)\(.*?\)(?P=delimiter)"|(?:u8|[uUL])?"(?:[^"\\\n]|\\.)*"'),
    ("char", r"(?:u8|[uUL])?'(?:[^'\\\n]|\\.)+'"),
    ("number", r"(?:0[xX][0-9a-fA-F']+|0[bB][01']+|(?:\d[\d']*\.?[\d']*|\.\d[\d']*)(?:[eE][+-]?\d+)?)\w*"),
    ("word", r"[A-Za-z_]\w*"),
    ("operator", r"<=>|<<=|>>=|\.\.\.|->\*|::|->|\+\+|--|&&|\|\||[<>=!+\-*/%&|^]=|<<|>>|[^\s\w]"),
]
_TOKEN = re.compile("|".join(f"(?P<{kind}>{pattern})" for kind, pattern in _PATTERNS), re.DOTALL | re.MULTILINE)
_SKIPPED = ("comment", "directive")
_CLOSING = {"(": ")", "[": "]", "{": "}"}


@dataclasses.dataclass(frozen=True)
class Token:
    kind: str  # string, char, number, word or operator
    text: str
    start: int  # offset in the text
    spaced: bool  # whether blanks stand on both sides

    @property
    def end(self):
        return self.start + len(self.text)


def scan(text):
    """All tokens but comments and preprocessor lines."""
    tokens = []
    for match in _TOKEN.finditer(text):
        if match.lastgroup in _SKIPPED:
            continue
        kind = "string" if match.lastgroup == "delimiter" else match.lastgroup
        before, after = text[match.start() - 1:match.start()], text[match.end():match.end() + 1]
        tokens.append(Token(kind, match.group(), match.start(), before.isspace() and after.isspace()))
    return tokens


def match_brackets(tokens):
    """Index of the closing bracket for each opening one, and the other way about; () [] {} only."""
    partner, open_brackets = {}, []
    for i, token in enumerate(tokens):
        if token.kind != "operator":
            continue
        if token.text in _CLOSING:
            open_brackets.append(i)
        elif open_brackets and token.text == _CLOSING[tokens[open_brackets[-1]].text]:
            partner[i] = open_brackets.pop()
            partner[partner[i]] = i
    return partner


def skip_angles(tokens, i):
    """The index after the template bracket that opens at i; i itself if none opens there."""
    if i >= len(tokens) or tokens[i].text != "<" or tokens[i].spaced:
        return i
    depth = 0
    for j in range(i, len(tokens)):
        text = tokens[j].text
        if text == "<":
            depth += 1
        elif text in (">", ">>"):
            depth -= len(text)
        elif text in (";", "{", "}"):
            return i
        if depth <= 0:
            return j + 1
    return i


class Lines:
    """Line and column, from 1, of offsets in a text."""

    def __init__(self, text):
        self.text = text
        self.starts = [0] + [match.end() for match in re.finditer("\n", text)]

    def line(self, offset):
        return bisect.bisect_right(self.starts, offset)

    def column(self, offset):
        return offset - self.starts[self.line(offset) - 1] + 1

    def span(self, start, end):
        """Offsets around all lines that the text between two offsets lies on, without the last newline."""
        last = self.text.find("\n", max(start, end - 1))
        return self.starts[self.line(start) - 1], len(self.text) if last < 0 else last
