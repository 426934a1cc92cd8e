#!/usr/bin/env python3
"""Whether what looks at the READMEs sees what is wrong with them."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

import check_flags
import check_readmes
import prose
from blocks import blocks_of, in_order
from check_readmes import check_figures, check_links, check_machine_paths, check_marks, check_tables, check_words
from markdown import kinds_of, links_of, sections_of, tables_of
from quotes import with_quotes

RESULTS = """# Results

## Logs

Twenty seeds of each log.

    scripts/results logs

| log | error, median [m] | path [km] |
|---|---|---|
| fr079 | 0.031 | 0.4 |
| `intel` | 0.014 | 0.5 |

Measured at 883d7f2, 2026-11-25.

## Costs

It takes 1,093 tiles.
"""


def pages(readme, **others):
    texts = {"README.md": readme, "tests/RESULTS.md": RESULTS, "common/slam.cpp": "", **others}
    return check_readmes.Pages(texts, texts.get)


def texts_of(block):
    return [command.text for command in block]


class Blocks(unittest.TestCase):
    def test_commands_of_an_indented_block_with_their_lines(self):
        block, = blocks_of("a/README.md", "Text.\n\n    scripts/demo      # try it\n    sudo ip link\n\nText.\n")
        self.assertEqual(texts_of(block), ["scripts/demo", "sudo ip link"])
        self.assertEqual(block[1].place, "a/README.md:4")
        self.assertEqual(block[0].comment, "try it")

    def test_other_text_in_a_block_of_its_own_is_none(self):
        self.assertEqual(blocks_of("README.md", "    [Service]\n    A=b\n\nscripts/demo\n"), [])

    def test_other_text_among_commands_is_refused_with_its_place(self):
        with self.assertRaisesRegex(ValueError, "^a/README.md:2: "):
            blocks_of("a/README.md", "    scripts/demo\n    make\n")



class Words(unittest.TestCase):
    def lengths(self, text):
        return prose.lengths_of(text)

    def test_a_sentence_may_go_over_lines_and_ends_before_code_or_a_capital(self):
        self.assertEqual(self.lengths("One two\nthree. `a b c` five! (Six.) 7 eight"), [3, 2, 1, 2])

    def test_initials_abbreviations_and_decimal_points_end_none(self):
        self.assertEqual(self.lengths("By D. Haehnel et al. In 0.5 m, e.g. Here."), [10])

    def test_items_are_sentences_and_headings_tables_code_and_pictures_are_none(self):
        self.assertEqual(self.lengths("# A b\n\n- one\n- two three\n  four\n\n| a | b |\n\n    code here\n\n![x y](z)\n"), [1, 3])

    def test_a_link_counts_by_its_text(self):
        self.assertEqual(self.lengths("See [the `code` there](a/b.md) now."), [5])

    def test_a_long_page_and_long_sentences_are_refused(self):
        self.assertEqual(check_words(pages("Short is good.\n" * 120)), [])
        self.assertIn("121 lines", check_words(pages("Short is good.\n" * 121))[0])
        self.assertIn("median", check_words(pages("A " * 16))[0])
        self.assertIn("one in ten", check_words(pages("A.\n\n" * 8 + "A " * 26 + "\n\n" + "A " * 26))[0])


class Links(unittest.TestCase):
    def test_files_folders_and_headings_of_the_project(self):
        self.assertEqual(check_links(pages("# A `b` c\n[x](#a-b-c) [x](common/slam.cpp) [x](common) [x](tests/RESULTS.md#costs)"
                                           " [x](https://x.y) `[x](y)`\n\n    [x](y)\n")), [])

    def test_what_is_not_there(self):
        failures = check_links(pages("A\n[x\ny](common/no.cpp) [x](#b) [![x](no.png)](tests/RESULTS.md#no)"))
        self.assertEqual([failure.rsplit(": ", 2)[-2] for failure in failures],
                         ["common/no.cpp", "#b", "tests/RESULTS.md#no", "no.png"])

    def test_links_of_a_folder_lead_from_there(self):
        self.assertEqual(check_links(pages("", **{"common/README.md": "[x](slam.cpp) [y](../README.md)"})), [])
        self.assertEqual(len(check_links(pages("", **{"common/README.md": "[x](common/slam.cpp)"}))), 1)

    def test_paths_of_one_machine(self):
        self.assertEqual(check_machine_paths(pages("/dev/ttyUSB0, /usr/share, ./%s/x, a/%s/b\n" % ("home", "work"))), [])
        self.assertEqual(len(check_machine_paths(pages("in /home/me/x and\n`/srv/clone`\n"))), 2)

    def test_the_sections_of_a_page_end_before_the_next_of_their_level(self):
        self.assertEqual(sections_of("# A\na\n## B\nb\n# C\nc"), {"a": "a\n## B\nb", "b": "b", "c": "c"})

    def test_code_below_a_list_and_a_list_below_code(self):
        self.assertEqual(kinds_of("- a\n    b\n\n    c\n\nd\n\n    e\n\n    - f\n"),
                         ["item", "prose", "blank", "prose", "blank", "prose", "blank", "code", "blank", "code"])



class Figures(unittest.TestCase):
    def test_a_part_of_a_number_another_section_or_the_day_will_not_do(self):
        for link in ("[0.03](tests/RESULTS.md#logs)", "[0.014](tests/RESULTS.md#costs)", "[25](tests/RESULTS.md#logs)"):
            self.assertEqual(len(check_figures(pages(link))), 1, link)

    def table(self, *rows):
        head = "See [the results](tests/RESULTS.md#logs).\n\n| log | path [km] | error, median [m] |\n|---|---|---|\n"
        return pages(head + "".join(f"{row}\n" for row in rows))

    def test_rows_of_a_table_are_rows_of_the_section(self):
        self.assertEqual(check_tables(self.table("| fr079 | 0.4 | 0.031 |", "| intel | 0.5 | 0.014 |")), [])

    def test_numbers_of_another_row_or_column_and_unknown_rows_are_refused(self):
        failures = check_tables(self.table("| fr079 | 0.4 | 0.014 |", "| intel | 0.014 | 0.5 |", "| aces | 0.4 | 0.031 |"))
        self.assertEqual([failure.split(": ")[0] for failure in failures], ["README.md:5", "README.md:6", "README.md:7"])

    def test_a_table_takes_its_figures_from_the_row_and_column_of_that_name(self):
        wrong = self.table("| fr079 | 0.5 | 0.014 |", "| intel | 0.1 | 0.2 |").texts["README.md"]
        self.assertEqual(with_quotes("README.md", wrong, RESULTS),
                         self.table("| fr079 | 0.4 | 0.031 |", "| intel | 0.5 | 0.014 |").texts["README.md"])




class Marks(unittest.TestCase):
    OLD = RESULTS.replace("Measured at", "Measured before the last change, at")
    MARKED = ("One [0.031](tests/RESULTS.md#logs) (measured before the last change), as it is.\n\n"
              "- two\n- See [it](tests/RESULTS.md#logs), or [1,093](tests/RESULTS.md#costs) tiles.\n")
    BARE = MARKED.replace(" (measured before the last change)", "")

    def test_a_figure_of_an_old_section_is_marked_and_no_other(self):
        self.assertEqual(with_quotes("README.md", self.BARE, self.OLD), self.MARKED)
        self.assertEqual(with_quotes("README.md", self.MARKED, self.OLD), self.MARKED)
        self.assertEqual(with_quotes("README.md", self.MARKED, RESULTS), self.BARE)

    def test_a_figure_without_its_mark_and_one_with_a_mark_too_many_are_refused(self):
        for readme, results, failures in ((self.MARKED, self.OLD, 0), (self.BARE, self.OLD, 1), (self.BARE, RESULTS, 0),
                                          (self.MARKED, RESULTS, 1)):
            self.assertEqual(len(check_marks(pages(readme, **{"tests/RESULTS.md": results}))), failures)

    def test_lines_stay_short_and_items_keep_their_indent(self):
        for begin, indent in (("", ""), ("- ", "  "), ("  1. ", "     ")):
            text = f"{begin}{'word ' * 15}[0.031](tests/RESULTS.md#logs) {'more ' * 30}"
            lines = with_quotes("README.md", text, self.OLD).splitlines()
            self.assertTrue(all(len(line) <= 120 for line in lines), lines)
            self.assertTrue(lines[0].startswith(f"{begin}word"))
            self.assertTrue(all(line.startswith(f"{indent}{line.strip()[0]}") for line in lines[1:]), lines)



class WithoutGit(unittest.TestCase):
    def test_a_folder_without_git_is_skipped_and_that_is_said(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("check_readmes.py", "blocks.py", "markdown.py", "prose.py", "quotes.py"):
                there = pathlib.Path(folder) / "tests/readme" / name
                there.parent.mkdir(parents=True, exist_ok=True)
                there.write_text((check_readmes.PROJECT / "tests/readme" / name).read_text())
            done = subprocess.run([sys.executable, "-B", there.parent / "check_readmes.py"], stdout=subprocess.PIPE, text=True)
        self.assertEqual(done.returncode, 77)
        self.assertRegex(done.stdout, "^skipped: .*: git does not say which files are the project's: is it a clone\\?\n$")
class Flags(unittest.TestCase):
    HELPS = {"slam_offline": {"--out", "--seed"}, "run_stack": {"--view"}, "venv": {"--system-site-packages"}}

    def failures(self, text):
        return [failure.split(": ")[1] for failure in check_flags.check_flags({"README.md": text}, self.HELPS)]

    def test_a_flag_of_the_program_before_it_or_of_any(self):
        self.assertEqual(self.failures("Give `--view` or `slam_offline sim:run_stack --out x`.\n\n"
                                       "    build/bin/slam_offline x --out y      # --no such\n"), [])

    def test_a_flag_of_no_program_of_another_one_or_in_a_block_is_named_with_its_line(self):
        self.assertEqual(self.failures("A\n`--window-rad`\n\n    build/bin/slam_offline x --view\n\n| a | `x/run_stack --out` |\n"),
                         ["slam_offline has no --view", "nothing has --window-rad", "run_stack has no --out"])
        self.assertTrue(check_flags.check_flags({"a": "b\n`--no`"}, self.HELPS)[0].startswith("a:2: "))

    def test_flags_of_other_peoples_programs_are_theirs_alone(self):
        self.assertEqual(self.failures("`python3 -m venv --system-site-packages x`, `--now`"), [])
        self.assertEqual(len(self.failures("`slam_offline --now`")), 1)


if __name__ == "__main__":
    unittest.main()
