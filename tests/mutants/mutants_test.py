"""Which faults are found in C++, and in which order they are drawn."""

import unittest

import mutants

SOURCE = "void f() {\n  a = b < 1 && c;\n  g();\n  return h();\n}\n"


def mutated(source):
    return {source[:start] + text + source[end:] for start, end, text in mutants.find_faults(source)}


class Faults(unittest.TestCase):
    def test_each_kind(self):
        for source, expected in (
                ("x = a < b", {"x = a <= b", "x = a > b"}), ("++n", {"--n"}), ("f(8u)", {"f(9u)", "f(7u)", "f(80u)"}),
                ("f(0.5f)", {"f(0.0f)", "f(5.0f)"}), ("while (f(a)) b", {"while (!(f(a))) b"}),
                ("if (int a = f(); a) b", {"if (int a = f(); !(a)) b"}),
                ("{ g(a.b); c->d(); int e; }", {"{ {} c->d(); int e; }", "{ g(a.b); {} int e; }"}),
                ("\n  v[i] = b;", {"\n  {}"}), ("return g();", set())):
            self.assertEqual(mutated(source), expected, source)

    def test_comments_strings_and_templates_have_none(self):
        self.assertEqual(mutated('#if X < 4\n// a < 1\nf("1 < 2", \'3\', std::vector<T>& b, const T* c)'), set())


class Draw(unittest.TestCase):
    def test_every_line_has_its_turn_before_one_has_a_second(self):
        found = mutants.mutants_of("a.cpp", SOURCE)
        drawn = mutants.draw(found, 1)
        self.assertEqual({mutant.line for mutant in drawn[:2]}, {2, 3})
        self.assertCountEqual(drawn, found)
        self.assertEqual(drawn, mutants.draw(reversed(found), 1))

    def test_the_table_of_files_fits_the_project(self):
        self.assertTrue(mutants.all_mutants())


if __name__ == "__main__":
    unittest.main()
