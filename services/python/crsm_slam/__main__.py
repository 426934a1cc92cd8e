"""python3 -m crsm_slam LOG --out DIR: the program slam_offline, of this package, or in the path, or of the same build."""
import os
import pathlib
import shutil
import sys


def main():
    package = pathlib.Path(__file__).resolve().parent
    of_package, of_build = (str(folder / "bin" / "slam_offline") for folder in (package, package.parents[1]))
    program = shutil.which(of_package) or shutil.which("slam_offline") or shutil.which(of_build)
    if not program:
        sys.exit("crsm_slam: there is no slam_offline in the path: install the package crsm-slam")
    os.execv(program, ["slam_offline", *sys.argv[1:]])


if __name__ == "__main__":
    main()
