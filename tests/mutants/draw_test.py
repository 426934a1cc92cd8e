"""The draw, and the table of files."""

import collections
import pathlib
import tempfile
import unittest

import draw
import sources

SOURCE = "void f() {\n  a = b < 1 && c > 2 && d < 3;\n  g();\n  h();\n}\n"


class Draw(unittest.TestCase):
    def test_the_same_seed_gives_the_same_draw_and_another_seed_another(self):
        mutants = draw.mutants_of("a.cpp", SOURCE)
        self.assertEqual(draw.draw(mutants, 1), draw.draw(list(reversed(mutants)), 1))
        self.assertNotEqual(draw.draw(mutants, 1), draw.draw(mutants, 2))

    def test_every_line_has_its_turn_before_one_has_a_second(self):
        mutants = draw.mutants_of("a.cpp", SOURCE)
        self.assertEqual({mutant.line for mutant in draw.draw(mutants, 1)[:3]}, {2, 3, 4})
        self.assertCountEqual(draw.draw(mutants, 1), mutants)

    def test_a_line_is_as_likely_as_any_other_to_come_first(self):
        mutants = draw.mutants_of("a.cpp", SOURCE)
        first = collections.Counter(draw.draw(mutants, seed)[0].line for seed in range(600))
        for line in (2, 3, 4):
            self.assertLess(abs(first[line] - 200), 58)  # five standard deviations

    def test_what_did_not_change_is_drawn_as_before_when_lines_move(self):
        def mutated(source):
            return [mutant.key for mutant in draw.draw(draw.mutants_of("a.cpp", source), 1)]
        self.assertEqual(mutated("// new\n\n" + SOURCE), mutated(SOURCE))

    def test_a_mutant_says_where_it_is_and_what_it_is(self):
        mutant = next(one for one in draw.mutants_of("a.cpp", SOURCE) if one.line == 3)
        self.assertEqual(mutant.id, "a.cpp:3:3 statement: 'g();' -> '{}'")
        self.assertEqual((mutant.original, mutant.mutated), ("g();", "{}"))
        self.assertEqual(mutant.apply(SOURCE), SOURCE.replace("g();", "{}"))

    def test_all_ids_differ(self):
        mutants = draw.mutants_of("a.cpp", SOURCE)
        self.assertEqual(len({mutant.id for mutant in mutants}), len(mutants))


class Table(unittest.TestCase):
    def test_a_glob_that_matches_nothing_is_an_error_that_names_it(self):
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "a.cpp").touch()
            self.assertEqual(sources.find_sources(pathlib.Path(folder), ["*.cpp"]), ["a.cpp"])
            with self.assertRaisesRegex(sources.SourceError, "'b.cpp'.*matches no file"):
                sources.find_sources(pathlib.Path(folder), ["*.cpp", "b.cpp"])

    def test_the_table_fits_the_project(self):
        project = pathlib.Path(__file__).resolve().parents[2]
        self.assertTrue(draw.all_mutants(project, sources.find_sources(project)))


if __name__ == "__main__":
    unittest.main()
