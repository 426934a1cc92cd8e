"""The commands of the README: what stands in its indented blocks, in its order."""

import dataclasses
import re

COMMAND = re.compile(r"    (?:(?:scripts|build/bin)/\w|(?:sudo|ip|sysctl|export|parallel) )")


@dataclasses.dataclass(frozen=True)
class Command:
    line: int  # of the README, from 1
    text: str  # what is typed
    comment: str  # what stands behind the #

    @property
    def is_interrupted(self):
        return "Ctrl-C" in self.comment or self.text.startswith("scripts/run_stack live ")


def blocks_of(readme):
    """The blocks that begin with a command, each a list of its commands. Settings and the folder tree are none."""
    blocks = []
    for number, line in enumerate(readme.splitlines(), start=1):
        if not line.startswith("    "):
            blocks.append([])
        elif COMMAND.match(line):
            text, comment = re.fullmatch(r"(.*?)(?:\s+#\s+(.*))?", line[4:]).groups()
            blocks[-1].append(Command(number, text, comment or ""))
        elif blocks[-1]:
            raise ValueError(f"README.md:{number}: among commands, and looks like none: {line}")
    return [block for block in blocks if block]
