"""What the scanner, the statements and the faults see in C++."""

import unittest

from faults import find_faults
from scanner import Lines, scan
from statements import find_statements


def texts(source):
    return [token.text for token in scan(source)]


def mutated(source, kind):
    """The source with each of its faults of a kind."""
    return {source[:fault.start] + fault.text + source[fault.end:]
            for fault in find_faults(source) if fault.kind == kind}


def removable(source):
    tokens = scan(source)
    return [source[tokens[first].start:tokens[end].end] for first, end in find_statements(tokens)]


class Scanner(unittest.TestCase):
    def test_comments_and_preprocessor_lines_are_no_tokens(self):
        self.assertEqual(texts("a // < 1\n/* 2\n3 */ b\n#if X < 4 \\\n  && 5\nc"), ["a", "b", "c"])

    def test_strings_and_characters_are_one_token_whatever_they_hold(self):
        self.assertEqual(texts(r'"a \" < //" ' + "'\"' '\\'' " + 'R"x(a)" < 1)x"'),
                         [r'"a \" < //"', "'\"'", "'\\''", 'R"x(a)" < 1)x"'])

    def test_numbers_keep_exponent_suffix_and_digit_separators(self):
        self.assertEqual(texts("1'000 0xffu 1e-3f .5 2.0"), ["1'000", "0xffu", "1e-3f", ".5", "2.0"])

    def test_lines_and_columns_count_from_one(self):
        lines = Lines("ab\ncd")
        self.assertEqual([(lines.line(at), lines.column(at)) for at in (0, 1, 3, 4)], [(1, 1), (1, 2), (2, 1), (2, 2)])
        self.assertEqual(lines.span(3, 4), (3, 5))


class Statements(unittest.TestCase):
    def test_calls_assignments_and_throws_can_be_left_out(self):
        self.assertEqual(removable("void f() { g(); a.b = 1; ++n; throw X(2); *p = 3; v[0] += 1; n::h<int>(4); }"),
                         ["g();", "a.b = 1;", "++n;", "throw X(2);", "*p = 3;", "v[0] += 1;", "n::h<int>(4);"])

    def test_declarations_and_returns_cannot(self):
        self.assertEqual(removable("int f() { int a = 1; const X b(2); std::vector<int> c; X& d = e; auto g = 1;"
                                   " X h{3}; using namespace x; break; return a; }"), [])

    def test_what_hangs_on_an_if_or_a_loop_can(self):
        self.assertEqual(removable("void f() { if (a) b(); else c(); for (int i = 0; i < 3; ++i) d(i); }"),
                         ["b();", "c();", "d(i);"])

    def test_bodies_of_lambdas_and_methods_are_code_and_those_of_types_are_not(self):
        self.assertEqual(removable("struct S { S(int a); int b = 1; void f() const { g(); } };"
                                   "void h() { auto k = [&] { m(); }; }"), ["g();", "m();"])

    def test_a_case_begins_a_statement(self):
        self.assertEqual(removable("void f() { switch (a) { case k::b: c(); } }"), ["c();"])


class Faults(unittest.TestCase):
    def test_comparisons_move_their_boundary_or_turn_round(self):
        self.assertEqual(mutated("x = a < b;", "operator"), {"x = a <= b;", "x = a > b;"})
        self.assertEqual(mutated("x = a != b;", "operator"), {"x = a == b;"})

    def test_brackets_of_templates_pointers_and_references_are_no_operators(self):
        self.assertEqual(mutated("std::vector<int>& f(const X* a, Y&& b); template <class T> T c;", "operator"), set())

    def test_signs_go_and_come(self):
        self.assertEqual(mutated("x = -a;", "sign"), {"x = a;"})
        self.assertEqual(mutated("x = a * 2.0;", "sign"), {"x = -a * 2.0;", "x = a * -2.0;"})
        self.assertEqual(mutated("x = std::nullopt; y = true; const bool z = a; w = 0;", "sign"), set())

    def test_numbers_change(self):
        self.assertEqual(mutated("f(8u);", "off by one"), {"f(9u);", "f(7u);"})
        self.assertEqual(mutated("f(8u);", "constant"), {"f(0u);", "f(80u);"})
        self.assertEqual(mutated("f(0.5f);", "constant"), {"f(0.0f);", "f(5.0f);"})
        self.assertEqual(mutated("f(0u);", "off by one"), {"f(1u);"})
        self.assertEqual(mutated("f(0x10);", "off by one"), {"f(17);", "f(15);"})

    def test_loops_end_one_earlier_or_later(self):
        self.assertEqual(mutated("void f() { for (int i = 0; i < n; ++i) {} }", "off by one") -
                         mutated("void f() { for (int i = 0;", "off by one"),
                         {f"void f() {{ for (int i = {i}; i < n{by}; ++i) {{}} }}"
                          for i, by in ((0, " - 1"), (0, " + 1"), (1, ""), (-1, ""))})

    def test_conditions_are_negated(self):
        self.assertEqual(mutated("if (int a = f(); a) {}", "condition"), {"if (int a = f(); !(a)) {}"})
        self.assertEqual(mutated("x = f(a, b) ? 1 : 2;", "condition"), {"x = !(f(a, b)) ? 1 : 2;"})
        self.assertEqual(mutated("x = !a;", "condition"), {"x = a;"})

    def test_what_could_only_break_the_build_gets_none(self):
        self.assertEqual(find_faults('#include "a"\nstatic_assert(a < 3); template <int N = 3> T& operator+(T& a);'),
                         [])


if __name__ == "__main__":
    unittest.main()
