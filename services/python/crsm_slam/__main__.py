"""python3 -m crsm_slam LOG --out DIR: the program slam_offline, of this package or else in the path."""
import os
import pathlib
import shutil
import sys


def main():
    beside = pathlib.Path(__file__).resolve().parent / "bin" / "slam_offline"
    program = str(beside) if beside.exists() else shutil.which("slam_offline")
    if not program:
        sys.exit("crsm_slam: there is no slam_offline in the path: install the package crsm-slam")
    os.execv(program, ["slam_offline", *sys.argv[1:]])


if __name__ == "__main__":
    main()
