"""What pip calls to make a wheel from a clone (PEP 517): CMake builds the module and slam_offline, and they are packed.

As a program it only packs: build_wheel.py PACKAGE FOLDER (scripts/packages).
"""
import base64
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
PROJECT = HERE.parents[1]
NAME = "crsm_slam"


def of_project(pattern):
    return re.search(pattern, (PROJECT / "CMakeLists.txt").read_text()).group(1)


def version():
    return of_project(r"VERSION (\d+\.\d+\.\d+)")


def build(folder):
    """The files of the package, in folder/python/crsm_slam and folder/bin."""
    if not shutil.which("cmake") or not shutil.which("ninja"):
        sys.exit("crsm_slam: building needs CMake, Ninja and more: type scripts/setup --demo --python")
    run = lambda *command: subprocess.run([str(word) for word in command], check=True)
    run("cmake", "-S", PROJECT, "-B", folder, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DCRSM_TESTS=OFF",
        "-DCRSM_VIEWER=OFF", f"-DPython_EXECUTABLE={sys.executable}")
    if "crsm_python" not in subprocess.run(["ninja", "-C", folder, "-t", "targets", "all"], stdout=subprocess.PIPE,
                                           text=True, check=True).stdout:
        sys.exit("crsm_slam: pybind11 or the headers of Python are missing: type scripts/setup --demo --python")
    run("cmake", "--build", folder, "--target", "crsm_python", "slam_offline")


def metadata():
    summary = of_project(r'DESCRIPTION "(.*)"')
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    return (f"Metadata-Version: 2.1\nName: crsm-slam\nVersion: {version()}\nSummary: {summary}\n"
            f"Author: CRSM SLAM authors\nLicense: MIT\nRequires-Python: =={python}.*\nRequires-Dist: numpy\n"
            f"Description-Content-Type: text/markdown\n\n{(PROJECT / 'README.md').read_text()}")


def write_wheel(files, folder, platform):
    """files: contents by path in the package crsm_slam. Returns the name of the wheel."""
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{python}-{python}-{platform}"
    name = f"{NAME}-{version()}-{tag}.whl"
    info = f"{NAME}-{version()}.dist-info"
    entries = {f"{NAME}/{path}": data for path, data in files.items()}
    entries[f"{info}/METADATA"] = metadata().encode()
    entries[f"{info}/LICENSE"] = (PROJECT / "LICENSE").read_bytes()
    entries[f"{info}/entry_points.txt"] = b"[console_scripts]\nslam_offline = crsm_slam.__main__:main\n"
    entries[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: {NAME}\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    with zipfile.ZipFile(pathlib.Path(folder) / name, "w", zipfile.ZIP_DEFLATED) as wheel:
        record = []
        for path, data in sorted(entries.items()):
            entry = zipfile.ZipInfo(path)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o100755 if "/bin/" in path or path.endswith(".so") else 0o100644) << 16
            wheel.writestr(entry, data)
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            record.append(f"{path},sha256={digest},{len(data)}")
        wheel.writestr(f"{info}/RECORD", "\n".join([*record, f"{info}/RECORD,,", ""]))
    return name


def files_in(package):
    """Contents by path in the package."""
    return {str(path.relative_to(package)): path.read_bytes() for path in package.rglob("*")
            if path.is_file() and "__pycache__" not in path.parts}


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """A wheel for this system, whose libraries it uses."""
    with tempfile.TemporaryDirectory(prefix="crsm_wheel_") as temporary:
        folder = pathlib.Path(os.environ.get("CRSM_WHEEL_BUILD", temporary))
        build(folder)
        files = files_in(folder / "python" / NAME)
        files["bin/slam_offline"] = (folder / "bin/slam_offline").read_bytes()
    return write_wheel(files, wheel_directory, sysconfig.get_platform().replace("-", "_").replace(".", "_"))


def pack_wheel(package, wheel_directory):
    """A wheel of a package that has all its libraries in it, for any Linux whose C library is no older (PEP 600)."""
    glibc = os.confstr("CS_GNU_LIBC_VERSION").split()[1].replace(".", "_")
    return write_wheel(files_in(pathlib.Path(package)), wheel_directory, f"manylinux_{glibc}_{os.uname().machine}")


if __name__ == "__main__":
    print(pack_wheel(*sys.argv[1:]))
