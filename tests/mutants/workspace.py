"""A private copy of the project, where mutants are built and put away again."""

import contextlib
import os
import pathlib
import re
import shutil
import subprocess

BUILD_TIMEOUT_S = 3600


class Stopped(Exception):
    """The user wants to end."""


class Commands:
    """Starts commands in process groups of their own, which end with the user's Ctrl-C and with a time limit."""

    def __init__(self):
        self.stopping = False
        self.running = set()

    def run(self, command, log, timeout_s, cwd, environment=None):
        """The exit code, None if the time was over. What the command prints goes to the file `log`."""
        if self.stopping:
            raise Stopped
        with open(log, "wb") as output:
            process = subprocess.Popen(command, cwd=cwd, env={**os.environ, **(environment or {})}, stdout=output,
                                       stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, start_new_session=True)
            self.running.add(process)
            try:
                if self.stopping:
                    _kill(process)
                return process.wait(timeout_s)
            except subprocess.TimeoutExpired:
                return None
            finally:
                _kill(process)
                self.running.discard(process)
                if self.stopping:
                    raise Stopped

    def stop(self):
        self.stopping = True
        for process in list(self.running):
            _kill(process)


def _kill(process):
    """Ends a process and all of its group that is left."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, 9)
    process.wait()


def mirror(source, names, copy):
    """Makes `copy` hold these files of `source`, and no others but in a folder `build`. Equal files stay untouched."""
    for name in names:
        target = copy / name
        content = (source / name).read_bytes()
        if target.is_file() and target.read_bytes() == content:
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content)
        shutil.copymode(source / name, target)
    wanted = set(names)
    for path in _files(copy):
        name = path.relative_to(copy).as_posix()
        if name not in wanted and not name.startswith("build/"):
            path.unlink()


def restore(pristine, folder):
    """Makes `folder` equal to `pristine`, times included: ninja takes it for built."""
    known = set()
    for path in _files(pristine):
        target = folder / path.relative_to(pristine)
        known.add(target)
        if not _is_same(path, target):
            target.parent.mkdir(parents=True, exist_ok=True)
            target.unlink(missing_ok=True)  # no copy goes into what a link leads to
            shutil.copy2(path, target, follow_symlinks=False)
    for path in _files(folder):
        if path not in known:
            path.unlink()


def _files(folder):
    for root, _, names in os.walk(folder):
        for name in names:
            yield pathlib.Path(root, name)


def _is_same(path, other):
    if path.is_symlink() or other.is_symlink():
        return path.is_symlink() and other.is_symlink() and os.readlink(path) == os.readlink(other)
    if not other.is_file():
        return False
    one, two = path.stat(), other.stat()
    return one.st_size == two.st_size and one.st_mtime_ns == two.st_mtime_ns


class Workspace:
    """`source` holds the copy and its build folder, `pristine` the build folder of the source without a fault."""

    def __init__(self, folder, commands, num_jobs):
        self.folder = folder
        self.commands = commands
        self.num_jobs = num_jobs
        self.source = folder / "source"
        self.build_folder = self.source / "build"
        self.pristine = folder / "pristine"
        self.log = folder / "build.txt"
        self.environment = {}

    def prepare(self, project, names):
        """Copies the project and configures it. Returns whether that worked."""
        self.source.mkdir(parents=True, exist_ok=True)
        if self.pristine.is_dir():  # what a run left that was killed
            restore(self.pristine, self.build_folder)
        mirror(project, names, self.source)
        code = self.commands.run(["cmake", "--preset", "release"], self.log, BUILD_TIMEOUT_S, self.source)
        return code == 0

    def keep_pristine(self):
        """Call it when all that is needed is built."""
        self.pristine.mkdir(exist_ok=True)
        restore(self.build_folder, self.pristine)
        self.environment = {"CCACHE_DISABLE": "1"}  # a mutant is not built twice

    def build(self, target):
        command = ["ninja", "-C", self.build_folder, "-j", str(self.num_jobs), target]
        return self.commands.run(command, self.log, BUILD_TIMEOUT_S, self.source, self.environment) == 0

    def has_target(self, target):
        return re.search(rf"^build {target}: phony", (self.build_folder / "build.ninja").read_text(), re.M) is not None

    @contextlib.contextmanager
    def with_mutant(self, mutant):
        path = self.source / mutant.file
        content, times = path.read_text(), path.stat()
        try:
            path.write_text(mutant.apply(content))
            yield
        finally:
            path.write_text(content)
            os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
            restore(self.pristine, self.build_folder)
