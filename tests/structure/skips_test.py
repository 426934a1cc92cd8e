#!/usr/bin/env python3
"""Whether every test is there on every machine, and one that lacks a tool says which flag of scripts/setup brings it."""

import pathlib
import re
import subprocess
import unittest

PROJECT = pathlib.Path(__file__).resolve().parents[2]
# What may decide whether a test is there: how the project was compiled, and no tool.
KINDS_OF_BUILD = re.compile(r'CRSM_SANITIZERS|HARDENED|suite STREQUAL|TEST \$\{name\}|name MATCHES "\(\.\+\)_test\$"')


def tests_behind_conditions(text):
    """Each add_test of a CMakeLists.txt, with the conditions around it."""
    conditions = []
    for line in text.splitlines():
        if match := re.match(r"\s*(if|elseif|else|endif|foreach|endforeach)\((.*)\)", line):
            word, condition = match.groups()
            if word in ("elseif", "else", "endif"):
                conditions.pop()
            if word in ("if", "elseif", "else"):
                conditions.append(condition)
        if match := re.search(r"add_test\(NAME (\S+)", line):
            yield match[1], list(conditions)


class Skips(unittest.TestCase):
    def test_no_test_is_left_out_because_a_tool_is_missing(self):
        found = list(tests_behind_conditions((PROJECT / "tests/CMakeLists.txt").read_text()))
        self.assertGreater(len(found), 15)
        for name, conditions in found:
            for condition in conditions:
                self.assertRegex(condition, KINDS_OF_BUILD, f"{name} is left out where {condition} does not hold")

    def test_a_condition_on_a_tool_is_seen(self):
        text = "if(NOT A)\nelse()\nif(SPIN)\n  add_test(NAME protocol COMMAND x)\nendif()\nendif()\nadd_test(NAME b COMMAND y)"
        self.assertEqual(list(tests_behind_conditions(text)), [("protocol", ["", "SPIN"]), ("b", [])])

    def test_flags_of_setup_that_tests_name_are_there(self):
        setup = subprocess.run([PROJECT / "scripts/setup", "--help"], capture_output=True, text=True, check=True).stdout
        there = set(re.findall(r"--[a-z]+", setup))
        named = {}
        for path in (PROJECT / "tests").rglob("*"):
            if path.suffix in (".py", ".cpp", "") and path.is_file():
                for flags in re.findall(r"skip\w*\b[^\n]*scripts/setup((?: --[a-z]+)+)", path.read_text(), re.IGNORECASE):
                    named.update(dict.fromkeys(flags.split(), path))
        self.assertEqual(set(), {"--spy", "--view", "--bags", "--protocol", "--docs", "--python", "--npm"} - set(named))
        self.assertEqual({}, {flag: path for flag, path in named.items() if flag not in there})


if __name__ == "__main__":
    unittest.main()
