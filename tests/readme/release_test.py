#!/usr/bin/env python3
"""Whether the READMEs call the files of a release as the workflow calls them, and whether .ci/run runs what they tell."""

import fnmatch
import os
import pathlib
import re
import subprocess
import tempfile
import textwrap
import unittest

from blocks import blocks_of, files_of, in_order

PROJECT = pathlib.Path(__file__).resolve().parents[2]
WORKFLOW = (PROJECT / ".github/workflows/release.yml").read_text()
FILE = re.compile(r"\./([\w.*-]+\.(?:deb|tar\.gz|whl))")


def runs_of(workflow):
    """What the steps of a workflow give to the shell."""
    blocks = re.findall(r"^( +)- run: (?:\|\n((?:\1    .*\n|\n)+)|(.*)\n)", workflow, re.MULTILINE)
    return [textwrap.dedent(block) if block else line for _, block, line in blocks]


def packages_made(suite):
    """As scripts/packages names what it makes in a Debian."""
    table = (PROJECT / "scripts/README.md").read_text()
    debs = [f"{name}_1.2.3_amd64.deb" for name in re.findall(r"^\| `((?:python3-|lib)?crsm-slam[\w-]*)` \|", table, re.MULTILINE)]
    python = {"bookworm": "cp311", "trixie": "cp313"}[suite]
    return [*debs, "crsm-slam-1.2.3-linux-x86_64.tar.gz", f"crsm_slam-1.2.3-{python}-{python}-linux_x86_64.whl"]


def upload(suite, tag="v1"):
    """What the last step of the workflow says to gh."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        made = folder / "out/packages" / suite
        made.mkdir(parents=True)
        for file in packages_made(suite):
            (made / file).touch()
        (folder / "gh").write_text("#!/bin/sh\nprintf '%s\\n' \"$@\"\n")
        (folder / "gh").chmod(0o755)
        environment = {"PATH": f"{folder}:{os.environ['PATH']}", "SUITE": suite, "TAG": tag}
        return subprocess.run(["bash", "-ec", runs_of(WORKFLOW)[-1]], cwd=folder, env=environment, check=True,
                              capture_output=True, text=True).stdout.splitlines()


class Release(unittest.TestCase):
    def test_files_that_the_readmes_name_are_those_of_a_release_one_of_each_debian(self):
        released = [file for suite in ("bookworm", "trixie") for file in upload(suite)[3:]]
        self.assertEqual(len(set(released)), 12)
        named = {file: name for name in in_order(files_of(PROJECT)) for file in FILE.findall((PROJECT / name).read_text())}
        self.assertIn("README.md", named.values())
        for pattern, name in named.items():
            self.assertTrue(fnmatch.filter(released, pattern), f"{name}: a release has no {pattern}, but {released}")

    def test_a_tag_is_no_command(self):
        self.assertEqual(upload("bookworm", "v1;touch x$(touch y)")[:3], ["release", "upload", "v1;touch x$(touch y)"])
        self.assertEqual(len(runs_of(WORKFLOW)), 2)
        for run in runs_of(WORKFLOW):
            self.assertNotIn("${{", run)


class Tests(unittest.TestCase):
    def test_the_readme_begins_with_the_demo_and_the_tests_and_a_change_goes_in_by_the_same_tests(self):
        first = blocks_of("README.md", (PROJECT / "README.md").read_text())[0]
        self.assertEqual([command.text for command in first], ["scripts/demo", "scripts/test"])
        self.assertIn('"$scripts/test"', (PROJECT / ".ci/run").read_text().splitlines())


if __name__ == "__main__":
    unittest.main()
