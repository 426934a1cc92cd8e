"""Finds the small faults that can be put into a C++ text."""

import dataclasses

from scanner import match_brackets, scan, skip_angles
from statements import find_statements

_OPERATORS = {
    "<": ("<=", ">"), "<=": ("<", ">="), ">": (">=", "<"), ">=": (">", "<="), "==": ("!=",), "!=": ("==",),
    "&&": ("||",), "||": ("&&",), "+": ("-",), "-": ("+",), "*": ("/",), "/": ("*",),
    "++": ("--",), "--": ("++",), "+=": ("-=",), "-=": ("+=",), "*=": ("/=",), "/=": ("*=",),
}
_NEED_BLANKS = set("< <= > >= == != && || + - * / += -= *= /=".split())
_COMPARISONS = set("< <= > >= !=".split())
_BEFORE_OPERAND = set("= += -= *= /= return + - * / < <= > >= ==".split())
_BEFORE_CONDITION = set("= += -= *= /= return ( [ { } ; , ? :".split())
_NO_NUMBERS = set("true false nullptr nullopt this new move make_unique optional string vector".split())


@dataclasses.dataclass(frozen=True)
class Fault:
    kind: str  # operator, sign, off by one, constant, condition or statement
    start: int  # offsets of what is replaced
    end: int
    text: str  # what stands there instead


class _Finder:
    def __init__(self, text):
        self.text = text
        self.tokens = scan(text)
        self.partner = match_brackets(self.tokens)
        self.skipped = self._find_skipped()
        self.faults = []

    def _find_skipped(self):
        """Tokens where a fault could only break the build."""
        skipped = set()
        for i, token in enumerate(self.tokens):
            if token.text == "template":
                skipped.update(range(i, skip_angles(self.tokens, i + 1)))
            elif token.text == "static_assert":
                skipped.update(range(i, self.partner.get(i + 1, i) + 1))
            elif token.text == "operator":
                skipped.update((i, i + 1))
        return skipped

    def add(self, kind, start, end, text):
        if self.text[start:end] != text:
            self.faults.append(Fault(kind, start, end, text))

    def find(self):
        for i, token in enumerate(self.tokens):
            if i in self.skipped:
                continue
            if token.kind == "operator":
                self._operator(i, token)
            elif token.kind == "number":
                self._number(token)
            if token.kind in ("number", "word"):
                self._sign(i, token)
            if token.kind == "word":
                self._head(i, token)
        for first, end in find_statements(self.tokens):
            self.add("statement", self.tokens[first].start, self.tokens[end].end, "{}")
        unique = {(fault.start, fault.end, fault.text): fault for fault in reversed(self.faults)}
        return sorted(unique.values(), key=lambda fault: (fault.start, fault.end, fault.kind, fault.text))

    def _operator(self, i, token):
        if token.text in _OPERATORS and (token.spaced or token.text not in _NEED_BLANKS):
            for other in _OPERATORS[token.text]:
                self.add("operator", token.start, token.end, other)
        elif token.text == "-" and not self.text[token.end].isspace():
            self.add("sign", token.start, token.end, "")
        elif token.text == "!":
            self.add("condition", token.start, token.end, "")
        elif token.text == "?":
            self._negate(self._start_of_condition(i), i)

    def _start_of_condition(self, i):
        """The first token of what stands before a question mark."""
        i -= 1
        while i >= 0 and self.tokens[i].text not in _BEFORE_CONDITION:
            i = self.partner[i] - 1 if self.tokens[i].text in (")", "]") and i in self.partner else i - 1
        return i + 1

    def _negate(self, first, end):
        if first < end:
            start, stop = self.tokens[first].start, self.tokens[end - 1].end
            self.add("condition", start, stop, f"!({self.text[start:stop]})")

    def _number(self, token):
        for kind, text in _changed_numbers(token.text):
            self.add(kind, token.start, token.end, text)

    def _sign(self, i, token):
        """A minus before an operand."""
        before = self.tokens[i - 1] if i > 0 else None
        name = i + 2 if self.text.startswith("std::", token.start) else i
        if before is None or i - 1 in self.skipped or self.tokens[name].text in _NO_NUMBERS:
            return
        if token.kind == "number":
            operand = before.text in _BEFORE_OPERAND | {"(", ","} and float_value(token.text) != 0.0
        else:
            of_bool = before.text == "=" and i > 2 and self.tokens[i - 3].text == "bool"
            operand = before.text in _BEFORE_OPERAND - {"return"} and not of_bool
        if operand and (before.spaced or before.text in ("return", "(", ",")):
            self.add("sign", token.start, token.start, "-")

    def _head(self, i, token):
        """The condition of an if or a loop."""
        begin = i + 2 if token.text == "if" and self.tokens[i + 1].text == "constexpr" else i + 1
        if token.text not in ("if", "while", "for") or begin not in self.partner:
            return
        end = self.partner[begin]
        ends = [j for j in self._level(begin, end) if self.tokens[j].text == ";"]
        if token.text != "for":
            self._negate(ends[-1] + 1 if ends else begin + 1, end)
        elif len(ends) == 2:
            self._negate(ends[0] + 1, ends[1])
            condition = {self.tokens[j].text for j in self._level(ends[0], ends[1])}
            if condition & _COMPARISONS and not condition & {"&&", "||"}:
                stop = self.tokens[ends[1]].start
                self.add("off by one", stop, stop, " - 1")
                self.add("off by one", stop, stop, " + 1")

    def _level(self, begin, end):
        """Indices between two tokens, without what stands in brackets."""
        i = begin + 1
        while i < end:
            yield i
            i = self.partner[i] + 1 if self.tokens[i].text in ("(", "[", "{") and i in self.partner else i + 1


def _split_number(text):
    """Value and suffix. The value is an int or a float."""
    digits = text.replace("'", "")
    prefix = digits[:2].lower()
    if prefix in ("0x", "0b"):
        body = digits.rstrip("uUlLzZ")
        return int(body, 0), digits[len(body):]
    body = digits.rstrip("uUlLfFzZ")
    if any(c in body for c in ".eE"):
        return float(body), digits[len(body):]
    return int(body, 8 if len(body) > 1 and body[0] == "0" else 10), digits[len(body):]


def float_value(text):
    try:
        return float(_split_number(text)[0])
    except ValueError:
        return 0.0


def _changed_numbers(text):
    """Kind and text of the numbers that may stand there instead."""
    try:
        value, suffix = _split_number(text)
    except ValueError:
        return []  # a literal of the user's own kind
    if isinstance(value, float):
        return [("constant", f"{factor * value!r}{suffix}") for factor in (0, 10) if value != 0.0]
    changed = [("off by one", value + 1), ("off by one", value - 1)]
    if value != 0:
        changed += [("constant", 0), ("constant", 10 * value)]
    return [(kind, f"{number}{suffix}") for kind, number in changed if number >= 0 or "u" not in suffix.lower()]


def find_faults(text):
    """All faults that can be put into a text, from its beginning to its end."""
    return _Finder(text).find()
