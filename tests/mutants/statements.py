"""Finds statements that can be left out: expressions, assignments and calls that end in a semicolon."""

from scanner import match_brackets, skip_angles

_NO_EXPRESSION = set(
    "alignas auto break case catch class const constexpr continue default do else enum explicit extern for friend goto "
    "if inline namespace private protected public return static static_assert struct switch template try typedef "
    "typename union using virtual volatile while bool char double float int long short signed unsigned void".split())
_AFTER_HEAD = set("const noexcept override final mutable try do else".split())
_TYPE_SCOPES = set("namespace struct class union enum extern".split())


def _opens_code(tokens, head, brace, parent_is_code):
    """Whether statements stand behind this brace; `head` is the index of the first token after the last statement."""
    if parent_is_code:
        return True
    if brace == head or tokens[brace - 1].text in _AFTER_HEAD or tokens[brace - 1].text in (")", "}"):
        return True
    before = [token.text for token in tokens[head:brace]]
    return not _TYPE_SCOPES.intersection(before) and ")" in before


def _is_expression(tokens, first, end):
    """Whether the statement from `first` to its semicolon at `end` is no declaration."""
    token = tokens[first]
    if token.text in ("throw", "delete", "++", "--", "*", "(", "this"):
        return True
    if token.kind != "word" or token.text in _NO_EXPRESSION:
        return False
    i = first + 1
    while i < end:
        i = skip_angles(tokens, i)
        if tokens[i].text != "::":
            break
        i += 2
    following = tokens[i]
    if following.kind == "word" or i >= end:
        return False  # `Type name ...`, or nothing but a name
    return not (following.text in ("*", "&", "&&") and not following.spaced)  # `Type& name`


def find_statements(tokens):
    """Pairs of indices, first token and semicolon, of all statements that can be left out."""
    partner = match_brackets(tokens)
    found = []
    scopes = [False]  # of each brace that is open: whether statements stand in it
    first = 0  # of the statement that is read
    i = 0
    while i < len(tokens):
        text = tokens[i].text
        if text == "{":
            scopes.append(_opens_code(tokens, first, i, scopes[-1]))
            first = i + 1
        elif text == "}":
            if len(scopes) > 1:
                scopes.pop()
            first = i + 1
        elif text == ";":
            if scopes[-1] and i > first and _is_expression(tokens, first, i):
                found.append((first, i))
            first = i + 1
        elif text == "(" and i in partner and i > 0 and _is_head(tokens, i, first):
            i = partner[i]
            first = i + 1
        elif text in ("else", "do", "try") or (text == ":" and tokens[first].text in ("case", "default")):
            first = i + 1
        i += 1
    return found


def _is_head(tokens, i, first):
    """Whether the bracket at i opens the head of an if, a loop or a switch that begins at `first`."""
    return (tokens[i - 1].text in ("if", "for", "while", "switch") and i - 1 == first) or (
        tokens[i - 1].text == "constexpr" and tokens[i - 2].text == "if" and i - 2 == first)
