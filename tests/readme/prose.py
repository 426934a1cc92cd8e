"""Sentences and words of a page.

Sentences are those of prose: of paragraphs and of the items of lists. Headings, tables, code blocks and pictures have
none. A sentence ends behind . ! or ? where a space and then a capital, a digit, a quote, a bracket or code follow, and at
the end of a paragraph or an item; so an item is at least one sentence. No sentence ends at a colon, a semicolon, an
initial, or at e.g., i.e., et al., etc., vs. or cf.

A word is what stands between spaces and has a letter or a digit. Code between backticks is one word, and so is an address.
Of a link its text counts.
"""

import math
import re

from markdown import CODE_SPAN, LINK, paragraphs_of

NUMBER = re.compile(r"(?<![\w.])\d+(?:,\d{3})*(?:\.\d+)?(?!\w|\.\d)")
SENTENCE_END = re.compile(r"(?<=[.!?])[)\"'*]*\s+(?=[A-Z0-9\"'(\[*])")
NO_END = re.compile(r"\b(e\.g|i\.e|et al|etc|vs|cf|[A-Z])\.")


def percentile(values, share):
    """The least value that so large a share of all reaches at most; 0 of none."""
    return sorted(values)[max(0, math.ceil(share * len(values)) - 1)] if values else 0


def plain(text, code="Code"):
    """Prose without its marks: a word in place of code and of an address, the text of a link."""
    text = CODE_SPAN.sub(code, text)
    text = LINK.sub(lambda link: "" if link[1] else link[2], text)
    text = re.sub(r"<?https?://[^\s>)]*[^\s>).,;:]>?", "Address", text)
    return re.sub(r"\*+|(?<!\w)_+|_+(?!\w)", "", text)


def words_of(text):
    return [word for word in text.split() if re.search(r"\w", word)]


def sentences_of(text):
    sentences = []
    for paragraph in paragraphs_of(text):
        prose = NO_END.sub(r"\1", plain(paragraph.text))
        sentences += [sentence for sentence in SENTENCE_END.split(prose) if words_of(sentence)]
    return sentences


def lengths_of(text):
    """The words of each sentence of a page."""
    return [len(words_of(sentence)) for sentence in sentences_of(text)]
