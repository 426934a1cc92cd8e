"""Verdicts: how they are kept, counted and gone on with, and how a workspace is put in order again."""

import os
import pathlib
import tempfile
import threading
import time
import unittest

import draw
import results
import workspace
from campaign import Campaign
from results import CAUGHT, EQUIVALENT, NOT_BUILT, SURVIVED, Results
from suites import first_failure

MUTANTS = draw.draw(draw.mutants_of("a.cpp", "".join(f"void f{i}() {{ g{i}(); }}\n" for i in range(12))), 1)


def record_of(mutant, verdict, passed=()):
    return {"program": "p", "id": mutant.id, "file": mutant.file, "original": mutant.original,
            "mutated": mutant.mutated, "verdict": verdict, "test": "", "passed": list(passed), "seconds": 1.0}


class FakeJudge:
    """Says of every third mutant of the draw that it does not build, and that the others are caught."""

    def __init__(self):
        self.judged = []

    def judge(self, mutant):
        self.judged.append(mutant)
        return record_of(mutant, NOT_BUILT if MUTANTS.index(mutant) % 3 == 0 else CAUGHT)


def run(num, store, num_workers=1):
    """The records of a campaign, and the mutants that were judged for it."""
    judges = [FakeJudge() for _ in range(num_workers)]
    campaign = Campaign(MUTANTS, num, lambda mutant: store.find("p", mutant, ["unit"]),
                        lambda record, _: store.add(record))
    threads = [threading.Thread(target=campaign.work, args=(judge,)) for judge in judges]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return campaign.records(), [mutant for judge in judges for mutant in judge.judged]


class WithFolder(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        self.store = self.folder / "results.jsonl"


class Campaigns(WithFolder):
    def test_mutants_that_do_not_build_are_replaced_by_the_next_of_the_draw(self):
        records, judged = run(4, Results(self.store))
        self.assertEqual(results.count(records), {CAUGHT: 4, NOT_BUILT: 2, SURVIVED: 0, EQUIVALENT: 0})
        self.assertEqual(judged, MUTANTS[:6])

    def test_two_workers_judge_the_same_mutants_as_one(self):
        alone, _ = run(5, Results(self.folder / "alone.jsonl"))
        self.assertEqual(run(5, Results(self.store), num_workers=2)[0], alone)

    def test_a_rerun_goes_on_where_the_last_one_stopped(self):
        run(2, Results(self.store))
        records, judged = run(4, Results(self.store))
        self.assertEqual(len(records), 6)
        self.assertEqual(judged, MUTANTS[3:6])
        self.assertEqual(run(4, Results(self.store)), (records, []))

    def test_it_ends_when_the_draw_does(self):
        self.assertEqual(len(run(100, Results(self.store), num_workers=2)[0]), len(MUTANTS))


class Verdicts(WithFolder):
    def test_a_line_that_was_cut_short_is_judged_again(self):
        Results(self.store).add(record_of(MUTANTS[0], CAUGHT))
        with self.store.open("a") as file:
            file.write('{"program": "p", "id"')
        Results(self.store).add(record_of(MUTANTS[1], CAUGHT))
        self.assertEqual([record["id"] for record in Results(self.store).records], [MUTANTS[0].id, MUTANTS[1].id])

    def test_verdicts_on_another_program_and_survivors_that_a_suite_has_not_seen_do_not_count(self):
        store = Results(self.store)
        store.add(record_of(MUTANTS[0], SURVIVED, ["unit"]))
        self.assertIsNotNone(store.find("p", MUTANTS[0], ["unit"]))
        self.assertIsNone(store.find("p", MUTANTS[0], ["unit", "process"]))
        self.assertIsNone(store.find("other", MUTANTS[0], ["unit"]))

    def test_survivors_are_those_of_the_last_verdict(self):
        store = Results(self.store)
        for mutant, verdict in ((MUTANTS[0], SURVIVED), (MUTANTS[1], SURVIVED), (MUTANTS[0], CAUGHT)):
            store.add(record_of(mutant, verdict))
        self.assertEqual(store.survivors(), {MUTANTS[1].key})

    def test_survivors_that_are_named_equivalent_do_not_lower_the_score(self):
        path = self.folder / "equivalent.txt"
        path.write_text(f"# why\n\na.cpp\n- {MUTANTS[0].original}\n+ {MUTANTS[0].mutated}\nit is\nthe same\n\n"
                        "a.cpp\n- gone\n+ away\nwas the same\n")
        equivalents = results.read_equivalents(path)
        records = [record_of(mutant, verdict) for mutant, verdict in zip(MUTANTS, (SURVIVED, SURVIVED, CAUGHT))]
        self.assertAlmostEqual(results.score(records), 100 / 3)
        judged = results.with_equivalents(records, equivalents)
        self.assertEqual((judged[0]["verdict"], judged[0]["test"]), (EQUIVALENT, "it is the same"))
        self.assertEqual(results.score(judged), 50)
        self.assertEqual(results.unused_equivalents(equivalents, MUTANTS), [("a.cpp", "gone", "away")])

    def test_an_entry_without_a_reason_is_an_error(self):
        path = self.folder / "equivalent.txt"
        path.write_text("a.cpp\n- a\n+ b\n")
        with self.assertRaisesRegex(results.EquivalentError, "a.cpp"):
            results.read_equivalents(path)


class Workspaces(WithFolder):
    def test_a_copy_holds_what_the_project_does_and_leaves_equal_files_alone(self):
        source, copy = self.folder / "source", self.folder / "copy"
        for path, text in ((source / "a", "1"), (source / "d/b", "2"), (copy / "a", "1"), (copy / "old", "3"),
                           (copy / "build/c", "4")):
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        before = (copy / "a").stat().st_mtime_ns
        workspace.mirror(source, ["a", "d/b"], copy)
        self.assertEqual({path.relative_to(copy).as_posix() for path in copy.rglob("*") if path.is_file()},
                         {"a", "d/b", "build/c"})
        self.assertEqual((copy / "a").stat().st_mtime_ns, before)

    def test_a_build_folder_becomes_as_it_was_also_where_links_lead_to_files_that_changed(self):
        pristine, folder = self.folder / "pristine", self.folder / "build"
        for place in (pristine, folder):
            place.mkdir()
            (place / "all").write_text("1")
            (place / "z_link").symlink_to("all")
        (folder / "all").write_text("22")
        (folder / "new").write_text("3")
        (folder / "a_link").symlink_to("new")
        workspace.restore(pristine, folder)
        workspace.restore(pristine, folder)  # nothing is left to do
        self.assertEqual({path.name: path.read_text() for path in folder.iterdir()}, {"all": "1", "z_link": "1"})
        self.assertEqual(os.readlink(folder / "z_link"), "all")
        (folder / "z_link").unlink()
        (folder / "z_link").write_text("1")
        (folder / "all").unlink()
        (folder / "all").symlink_to("z_link")
        workspace.restore(pristine, folder)
        self.assertEqual(os.readlink(folder / "z_link"), "all")
        self.assertFalse((folder / "all").is_symlink())

    def test_a_command_that_takes_too_long_is_killed_with_its_children(self):
        commands = workspace.Commands()
        log = self.folder / "log"
        self.assertIsNone(commands.run(["sh", "-c", "sleep 60 & echo $!; wait"], log, 2, self.folder))
        child = pathlib.Path(f"/proc/{int(log.read_text())}/cmdline")
        give_up = time.monotonic() + 30
        while child.exists() and child.read_bytes() and time.monotonic() < give_up:  # a zombie's is empty
            time.sleep(0.01)
        self.assertLess(time.monotonic(), give_up)


class Failures(unittest.TestCase):
    LINE = "-" * 79

    def test_the_test_is_named_that_failed_and_not_one_that_warned(self):
        output = (f"{self.LINE}\nwarned\n{self.LINE}\na.cpp:1\n....\n\na.cpp:2: warning:\n  skipped\n\n"
                  f"{self.LINE}\nfails in\nsome way\n  section\n{self.LINE}\na.cpp:3\n....\n\n"
                  "a.cpp:4: FAILED:\n  CHECK( x )\n")
        self.assertEqual(first_failure(output), "fails in some way section")

    def test_without_a_test_the_last_words_stand(self):
        self.assertEqual(first_failure("one\ntwo\n\n"), "two")
        self.assertEqual(first_failure(""), "it says nothing")


if __name__ == "__main__":
    unittest.main()
