"""Which files get faults, and which files make up the project."""

import hashlib
import pathlib
import subprocess

# Globs of the files that get faults. One that matches nothing is an error, so that none is forgotten when files move.
SOURCES = [
    # the algorithm
    "common/math/*.?pp",
    "common/scan/*.?pp",
    "common/map/*.?pp",
    "common/match/*.?pp",
    "common/match/*/*.?pp",
    "common/slam.?pp",
    # the checks of what comes over the wire
    "services/wire/wire*.?pp",
    # the replica of the map, what waits for it, and who answers its requests
    "services/replica/map_replica.?pp",
    "services/replica/map_follower.?pp",
    "services/base/held_by_utime.hpp",
    "services/stages/scan_queue.hpp",
    "services/map_updater/delta_parts.?pp",
    "services/map_updater/pages.?pp",
    # the journal
    "services/journal/journal.?pp",
    "services/wire/lcm_event_log.?pp",
]

# What the verdict on a mutant depends on besides the tests. When one of these changes, all mutants are judged anew.
PROGRAM = ("CMakeLists.txt", "common/", "services/", "lcmtypes/")


class SourceError(Exception):
    """What is wrong with the table above, or with the source tree."""


def find_sources(project, globs=None):
    """The files that get faults, as paths relative to the project, sorted."""
    found = set()
    for glob in SOURCES if globs is None else globs:
        files = [path for path in project.glob(glob) if path.is_file()]
        if not files:
            raise SourceError(f"'{glob}' in tests/mutants/sources.py matches no file: has it moved?")
        found.update(path.relative_to(project).as_posix() for path in files)
    return sorted(found)


def project_files(project):
    """All files that git knows or would add, as paths relative to the project, sorted."""
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=project,
                            check=True, capture_output=True, text=True).stdout
    return sorted({name for name in listed.split("\0") if name and (project / name).is_file()})


def hash_files(project, names):
    """A digest of names and contents."""
    digest = hashlib.sha256()
    for name in names:
        content = pathlib.Path(project, name).read_bytes()
        digest.update(f"{name}\0{len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest()[:16]


def program_hash(project):
    return hash_files(project, [name for name in project_files(project) if name.startswith(PROGRAM)])
