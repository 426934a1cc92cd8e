#!/usr/bin/env python3
"""Whether the page of results is kept whole, and whether what stands on it is what scripts/results writes."""

import pathlib
import sys
import tempfile
import unittest

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
            self.assertIn("\nMeasured at ", text)


if __name__ == "__main__":
    unittest.main()
