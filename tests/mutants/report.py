"""What the mutation test prints."""

import time

from results import CAUGHT, EQUIVALENT, NOT_BUILT, SURVIVED, count, score, with_equivalents


def print_list(mutants):
    for mutant in mutants:
        print(f"{mutant.id}\n  - {mutant.original}\n  + {mutant.mutated}")


class Progress:
    """A line for each mutant, with the score so far and the time that is left."""

    def __init__(self, equivalents):
        self.equivalents = equivalents
        self.begin = None  # of the first mutant
        self.num_new = 0  # built in this run

    def __call__(self, record, campaign):
        built = campaign.num_built()
        self.num_new += record["verdict"] != NOT_BUILT
        self.begin = self.begin or time.monotonic() - record["seconds"]
        elapsed_s = time.monotonic() - self.begin
        left_s = elapsed_s / max(1, self.num_new) * max(0, campaign.num - built)
        judged = with_equivalents([record], self.equivalents)[0]
        so_far = score(with_equivalents(campaign.records(), self.equivalents))
        says = f" by {judged['test']}" if judged["verdict"] == CAUGHT else ""
        print(f"[{built}/{campaign.num}] {judged['verdict']}: {record['id']}{says} ({record['seconds']:.0f} s; score "
              f"{so_far:.0f} %, {left_s / 60:.0f} min left)", flush=True)


def _print_record(record):
    print(f"  {record['id']}\n    - {record['original']}\n    + {record['mutated']}")


def print_summary(records, equivalents, unused):
    """Prints what came of the mutants, and returns the score in percent."""
    records = with_equivalents(records, equivalents)
    counts = count(records)
    for verdict, title in ((EQUIVALENT, "change nothing that a test could see:"), (SURVIVED, "SURVIVED:")):
        if counts[verdict]:
            print(f"\n{counts[verdict]} {title}")
        for record in records:
            if record["verdict"] == verdict:
                _print_record(record)
                if verdict == EQUIVALENT:
                    print(f"    {record['test']}")
    if unused:
        print(f"\n{len(unused)} entries of tests/mutants/equivalent.txt fit no mutant any more:")
        for file, original, mutated in unused:
            print(f"  {file}\n    - {original}\n    + {mutated}")
    built = sum(counts.values()) - counts[NOT_BUILT]
    percent = score(records)
    print(f"\n{built} mutants: {counts[CAUGHT]} caught, {counts[SURVIVED]} survived, {counts[EQUIVALENT]} equivalent; "
          f"{counts[NOT_BUILT]} more did not build. Score {percent:.1f} %")
    return percent
