"""What pip calls to make a wheel from a clone (PEP 517): CMake builds the module and slam_offline, and they are packed."""
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


def tag():
    abi = f"cp{sys.version_info.major}{sys.version_info.minor}"
    return f"{abi}-{abi}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"


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
    return (f"Metadata-Version: 2.1\nName: crsm-slam\nVersion: {version()}\nSummary: {summary}\n"
            "License: MIT\nRequires-Python: >=3.8\nRequires-Dist: numpy\n")


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    name = f"{NAME}-{version()}-{tag()}.whl"
    with tempfile.TemporaryDirectory(prefix="crsm_wheel_") as temporary:
        folder = pathlib.Path(os.environ.get("CRSM_WHEEL_BUILD", temporary))
        build(folder)
        info = f"{NAME}-{version()}.dist-info"
        files = {f"{NAME}/{path.name}": path.read_bytes() for path in (folder / "python" / NAME).iterdir()
                 if path.is_file()}
        files[f"{NAME}/bin/slam_offline"] = (folder / "bin/slam_offline").read_bytes()
        files[f"{info}/METADATA"] = metadata().encode()
        files[f"{info}/LICENSE"] = (PROJECT / "LICENSE").read_bytes()
        files[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: {NAME}\nRoot-Is-Purelib: false\nTag: {tag()}\n".encode()
    with zipfile.ZipFile(pathlib.Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as wheel:
        record = []
        for path, data in sorted(files.items()):
            entry = zipfile.ZipInfo(path)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o100755 if "/bin/" in path or path.endswith(".so") else 0o100644) << 16
            wheel.writestr(entry, data)
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            record.append(f"{path},sha256={digest},{len(data)}")
        wheel.writestr(f"{info}/RECORD", "\n".join([*record, f"{info}/RECORD,,", ""]))
    return name
