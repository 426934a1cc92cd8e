#!/usr/bin/env python3
"""Whether the page of results is kept whole, and whether what stands on it is what scripts/results writes."""

import pathlib
import sys
import tempfile
import unittest

import age
import page
import results
from measure import PROJECT, Section

sys.path.insert(0, str(PROJECT / "tests/readme"))
from markdown import anchor_of


class Page(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.file = pathlib.Path(self.folder.name) / "RESULTS.md"

    def tearDown(self):
        self.folder.cleanup()

    def write(self, **sections):
        page.write(self.file, "# Results\n", sections, ["B", "A"])

    def test_a_page_comes_back_as_it_was_written(self):
        self.write(A="one\n\n### Part\n\n| a |", B="two")
        head, sections = page.read(self.file)
        self.assertEqual(head.strip(), "# Results")
        self.assertEqual({title: text.strip() for title, text in sections.items()}, {"A": "one\n\n### Part\n\n| a |", "B": "two"})
        before = self.file.read_text()
        page.write(self.file, head, sections, ["B", "A"])
        self.assertEqual(self.file.read_text(), before)

    def test_sections_stand_in_their_order_and_unknown_ones_behind(self):
        self.write(Z="z", A="a", B="b")
        self.assertEqual(list(page.read(self.file)[1]), ["B", "A", "Z"])

    def test_a_page_that_is_not_there_begins_with_its_head(self):
        head, sections = page.read(self.file)
        self.assertTrue(head.startswith("# Results"))
        self.assertEqual(sections, {})

    def test_one_section_is_written_and_no_other_changes(self):
        self.write(A="a", Z="z")
        section = Section("New one", 1, "Says what.", ["build/bin/slam_eval"], None)
        results.write_section(section, "| x |", 0.0, self.file)
        sections = page.read(self.file)[1]
        self.assertEqual((sections["A"].strip(), sections["Z"].strip()), ("a", "z"))
        self.assertRegex(sections["New one"],
                         r"^\nSays what\.\n\n    scripts/results new-one\n\nIt runs\n\n    build/bin/slam_eval\n\n\| x \|\n\n"
                         r"Measured at .* on \d{4}-\d\d-\d\d\.\n$")
        self.assertEqual([path.name for path in self.file.parent.iterdir()], ["RESULTS.md"])

    def test_a_time_says_on_what_it_was_measured_and_beside_what(self):
        section = Section("Time", 1, "Says what.", [], None, is_timed=True)
        self.assertRegex(results.say_when(section, 0.1), r" on \d+ cores of .*[^:]\.$")
        self.assertIn("beside other work, which kept 1.5 cores busy", results.say_when(section, 1.5))

    def test_a_table_has_a_line_a_row(self):
        self.assertEqual(page.table(["a", "b"], [[1, "x"]]), "| a | b |\n| --- | --- |\n| 1 | x |")


class Sections(unittest.TestCase):
    def test_names_are_the_anchors_of_their_headings(self):
        for section in results.SECTIONS:
            self.assertEqual(section.name, anchor_of(section.title))

    def test_what_stands_in_the_file_is_what_the_script_writes(self):
        known = {section.title: section for section in results.SECTIONS}
        for title, text in page.read(PROJECT / "tests/RESULTS.md")[1].items():
            self.assertIn(title, known)
            self.assertTrue(text.strip().startswith(results.wrap(known[title].about)), title)
            for command in [f"scripts/results {known[title].name}", *known[title].commands]:
                self.assertIn(f"\n    {command}\n", text)
            self.assertRegex(text, "\nMeasured (at|before the last change, at) ")

    def test_what_is_older_than_the_algorithm_says_so(self):
        written = page.read(results.RESULTS)
        for title, text in age.marked_sections(results.RESULTS, results.SECTIONS)[1].items():
            self.assertEqual(written[1][title].strip(), text.strip(), f"{title}: scripts/results --mark writes how old it is")
        self.assertEqual(written[0].strip(), page.HEAD.strip())


class Age(unittest.TestCase):
    SECTION = "Says what.\n\n| x |\n\nMeasured at 883d7f2 (algorithm 01234567) on 2026-11-25, on 2 cores.\n"
    OLD = SECTION.replace("Measured at", "Measured before the last change, at")

    def test_a_section_of_another_algorithm_is_marked_and_one_of_the_same_is_not(self):
        for text in (self.SECTION, self.OLD):
            self.assertEqual(age.with_age(text, "01234567"), self.SECTION)
            self.assertEqual(age.with_age(text, "76543210"), self.OLD)

    def test_a_section_that_names_no_algorithm_is_old(self):
        self.assertIn("Measured before the last change, at", age.with_age("A.\n\nMeasured at 1 with changes on 2", "01234567"))

    def test_a_section_that_is_measured_anew_is_of_the_algorithm_of_today(self):
        text = f"A.\n\n{results.say_when(Section('New one', 1, 'A.', [], None), 0.0)}\n"
        self.assertEqual(age.with_age(text, age.algorithm_of()), text)

    def test_code_makes_another_algorithm_and_comments_do_not(self):
        with tempfile.TemporaryDirectory() as folder:
            common = pathlib.Path(folder) / "common"
            for name in age.ALGORITHM:
                (common / name).parent.mkdir(parents=True, exist_ok=True)
                (common / name).write_text("") if "." in name else (common / name).mkdir()
            file = common / "match/a.cpp"
            known = []
            for text in ("a = 1;\n", "a = 2;\n", "// Why.\n\n  a = 1;\n"):
                file.write_text(text)
                known.append(age.algorithm_of(pathlib.Path(folder)))
            self.assertEqual((known[0] == known[1], known[0] == known[2]), (False, True))
            file.rename(common / "graph/a.cpp")
            self.assertNotEqual(age.algorithm_of(pathlib.Path(folder)), known[2])
            (common / "graph/README.md").write_text("No code.")
            file.write_text(text)
            (common / "graph/a.cpp").unlink()
            self.assertEqual(age.algorithm_of(pathlib.Path(folder)), known[2])

    def test_every_room_that_decides_a_map_is_there(self):
        self.assertEqual([name for name in age.ALGORITHM if not (PROJECT / "common" / name).exists()], [])


if __name__ == "__main__":
    unittest.main()
