"""The READMEs of the project, and their commands: what stands in their indented blocks, in its order."""

import dataclasses
import re
import subprocess

ORDER = ("README.md", "services/run_stack/README.md", "services/diagnosis/README.md", "services/README.md",
         "services/map_viewer/README.md", "services/sources/README.md", "scripts/README.md", "scripts/systemd/README.md", "common/README.md",
         "lcmtypes/README.md", "logs/README.md", "tests/README.md", "scripts/examples/README.md")
COMMAND = re.compile(r"    (?:[A-Z_]+=\S+ )*(?:(?:scripts|build/bin|out/venv)/\w|"
                     r"(?:sudo|ip|sysctl|export|parallel|cp|echo|python3) )")


SKIPPED = 77  # the exit code of a test that cannot run here


class WithoutGit(Exception):
    pass


@dataclasses.dataclass(frozen=True)
class Command:
    file: str  # the README, from the project's folder
    line: int  # of it, from 1
    text: str  # what is typed
    comment: str  # what stands behind the #

    @property
    def place(self):
        return f"{self.file}:{self.line}"

    @property
    def is_interrupted(self):
        return "Ctrl-C" in self.comment or self.text.startswith("scripts/run_stack live ")


def files_of(project):
    """All files of the project, from its folder: those of git, and those that are not committed yet."""
    try:
        listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=project,
                                check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout
    except (OSError, subprocess.CalledProcessError):
        raise WithoutGit(f"{project}: git does not say which files are the project's: is it a clone?") from None
    return sorted(set(listed.split("\0")[:-1]))


def in_order(files):
    """The READMEs among some files: first those of ORDER, then the others by name."""
    readmes = [file for file in files if file.rsplit("/", 1)[-1] == "README.md"]
    return sorted(readmes, key=lambda file: (ORDER.index(file) if file in ORDER else len(ORDER), file))


def blocks_of(file, text):
    """The blocks that begin with a command, each a list of its commands. Other text that is indented is none."""
    blocks = [[]]
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.startswith("    "):
            blocks.append([])
        elif COMMAND.match(line):
            typed, comment = re.fullmatch(r"(.*?)(?:\s+#\s+(.*))?", line[4:]).groups()
            blocks[-1].append(Command(file, number, typed, comment or ""))
        elif blocks[-1]:
            raise ValueError(f"{file}:{number}: among commands, and looks like none: {line}")
    return [block for block in blocks if block]

