"""Sentences, words and figures of a page.

Sentences are those of prose: of paragraphs and of the items of lists. Headings, tables, code blocks and pictures have
none. A sentence ends behind . ! or ? where a space and then a capital, a digit, a quote, a bracket or code follow, and at
the end of a paragraph or an item; so an item is at least one sentence. No sentence ends at a colon, a semicolon, an
initial, or at e.g., i.e., et al., etc., vs. or cf.

A word is what stands between spaces and has a letter or a digit. Code between backticks is one word, and so is an address.
Of a link its text counts.

A figure is a number in prose or in a table, outside of code and headings, with a decimal point, or with one of UNITS
behind it. Numbers with several points, as of versions, are none.
"""

import dataclasses
import math
import re

from markdown import CODE_SPAN, LINK, cells_of, headings_of, kinds_of, links_of, paragraphs_of

UNITS = ("%|mm|cm|km|m|px2|ms|us|s|min|h|seconds?|minutes?|hours?|times|[kKMG]B(?:/s)?|k?Hz|rad(?:/s)?|m/s|deg|degrees?")
NUMBER = re.compile(r"(?<![\w.])\d+(?:,\d{3})*(?:\.\d+)?(?!\w|\.\d)")
FIGURE = re.compile(rf"(?<![\w.])\d+(?:,\d{{3}})*(?:\.\d+(?!\w|\.\d)|(?!\w|\.\d) ?(?:{UNITS})(?!\w))")
SENTENCE_END = re.compile(r"(?<=[.!?])[)\"'*]*\s+(?=[A-Z0-9\"'(\[*])")
NO_END = re.compile(r"\b(e\.g|i\.e|et al|etc|vs|cf|[A-Z])\.")


@dataclasses.dataclass(frozen=True)
class Statistics:
    lines: int
    words: int
    sentence_words: list  # of each sentence
    figures: int
    linked_figures: int   # of those: in the text of a link to the results

    @property
    def median(self):
        return percentile(self.sentence_words, 0.5)

    @property
    def p90(self):
        return percentile(self.sentence_words, 0.9)


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
    """Of a page: the sentences, each with the line on which its paragraph begins."""
    sentences = []
    for paragraph in paragraphs_of(text):
        prose = NO_END.sub(r"\1", plain(paragraph.text))
        sentences += [(paragraph.line, sentence) for sentence in SENTENCE_END.split(prose) if words_of(sentence)]
    return sentences


def figures_of(text):
    return FIGURE.findall(plain(text, code="code"))


def count(text):
    """The statistics of a page."""
    lengths = [len(words_of(sentence)) for _, sentence in sentences_of(text)]
    cells = [cell for line, kind in zip(text.splitlines(), kinds_of(text)) if kind == "table" for cell in cells_of(line)]
    others = [plain(cell) for cell in cells] + [plain(title) for _, _, title in headings_of(text)]
    figures = sum(len(figures_of(part)) for part in cells + [paragraph.text for paragraph in paragraphs_of(text)])
    linked = sum(len(figures_of(link.text)) for link in links_of(text) if "RESULTS.md" in link.target)
    return Statistics(len(text.splitlines()), sum(lengths) + sum(len(words_of(part)) for part in others), lengths, figures,
                      linked)


def add(all_of_them):
    """The statistics of several pages as those of one."""
    return Statistics(sum(one.lines for one in all_of_them), sum(one.words for one in all_of_them),
                      [length for one in all_of_them for length in one.sentence_words],
                      sum(one.figures for one in all_of_them), sum(one.linked_figures for one in all_of_them))
