#!/usr/bin/env python3
"""Uses the library as programs of others do: installed, found by CMake and by pkg-config, shared and static, and as a part
of another project; its map has to be that of slam_offline, byte for byte.

usage: tests/library/library_test.py BUILD_DIR
"""

import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

PROJECT = pathlib.Path(__file__).resolve().parents[2]
EXAMPLE = PROJECT / "scripts" / "examples" / "library"
BUILD = pathlib.Path()  # main sets it


def run(*command, **options):
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options)
    if done.returncode != 0:
        raise AssertionError(f"{command}: exit code {done.returncode}\n{done.stdout!r}\n{done.stderr!r}")
    return done.stdout


def decode_grey_png(data):
    """The rows of an 8-bit grey PNG from the top, by its specification: width, height and bytes."""
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IHDR":
            width, height = struct.unpack(">II", data[at + 8:at + 16])
        if kind == b"IDAT":
            packed += data[at + 8:at + 8 + size]
        at += size + 12
    raw, above, rows = zlib.decompress(packed), bytes(width), []
    for begin in range(0, len(raw), width + 1):
        row = bytearray(raw[begin + 1:begin + 1 + width])
        for i in range(width):
            left, up, corner = (row[i - 1], above[i], above[i - 1]) if i else (0, above[i], 0)
            nearest = min((left, up, corner), key=lambda value: abs(left + up - corner - value))
            row[i] = (row[i] + (0, left, up, (left + up) // 2, nearest)[raw[begin]]) % 256
        above = bytes(row)
        rows.append(above)
    return width, height, b"".join(rows)


class Library(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="crsm_library_")
        work = cls.work = pathlib.Path(cls.folder.name)
        for component in ("runtime", "development"):
            run("cmake", "--install", BUILD, "--prefix", work / "usr", "--component", component)
        cls.library_folder = next((work / "usr").rglob("libcrsm_slam.so")).parent
        log = run(sys.executable, "-B", PROJECT / "scripts/examples/python/carmen_log.py", PROJECT / "logs/corridor.lcm",
                  env={**os.environ, "PYTHONPATH": str(work / "usr/share/crsm_slam/python")})
        (work / "run.log").write_bytes(log)
        run(BUILD / "bin/slam_offline", work / "run.log", "--preset", "sick", "--out", work / "offline")
        run(BUILD / "bin/slam_offline", PROJECT / "logs/corridor.lcm", "--preset", "sick", "--out", work / "lcm")
        width, height, rows = decode_grey_png((work / "offline/map.png").read_bytes())
        cls.wanted = b"P5\n%d %d\n255\n" % (width, height) + rows

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def check_map(self, program):
        with open(self.work / "run.log", "rb") as log:
            made = run(program, "sick", stdin=log, env={**os.environ, "LD_LIBRARY_PATH": str(self.library_folder)})
        self.assertTrue(made == self.wanted, "the map is another one than slam_offline's")

    def configure_and_build(self, source, *options):
        build = tempfile.mkdtemp(dir=self.work)
        run("cmake", "-G", "Ninja", "-S", source, "-B", build, "-DCMAKE_BUILD_TYPE=Release", *options)
        return self.build(pathlib.Path(build))

    def build(self, folder):
        begin = time.monotonic()
        run("cmake", "--build", folder, "-j2")
        print(f"{self.id().split('.')[-1]}: built in {time.monotonic() - begin:.1f} s, its program has "
              f"{(folder / 'map_log').stat().st_size / 1e3:.0f} kB", flush=True)
        return folder

    def test_the_log_that_python_wrote_has_the_scans_of_the_lcm_log(self):
        for name in ("map.png", "trajectory.tum"):
            self.assertTrue((self.work / "offline" / name).read_bytes() == (self.work / "lcm" / name).read_bytes(), name)

    def test_find_package(self):
        self.check_map(self.configure_and_build(EXAMPLE, f"-DCMAKE_PREFIX_PATH={self.work / 'usr'}") / "map_log")

    def test_find_package_static(self):
        source = self.work / "static"
        shutil.copytree(EXAMPLE, source)
        lists = source / "CMakeLists.txt"
        lists.write_text(lists.read_text().replace("crsm_slam::crsm_slam", "crsm_slam::crsm_slam_static"))
        program = self.configure_and_build(source, f"-DCMAKE_PREFIX_PATH={self.work / 'usr'}") / "map_log"
        self.check_map(program)
        self.assertNotIn(b"crsm_slam", run("ldd", program))

    def test_find_package_refuses_another_minor_version(self):
        source = self.work / "another"
        shutil.copytree(EXAMPLE, source)
        lists = source / "CMakeLists.txt"
        lists.write_text(lists.read_text().replace("crsm_slam 0.3", "crsm_slam 0.2"))
        with self.assertRaisesRegex(AssertionError, "0.2"):
            self.configure_and_build(source, f"-DCMAKE_PREFIX_PATH={self.work / 'usr'}")

    def test_pkg_config(self):
        environment = {**os.environ, "PKG_CONFIG_PATH": str(self.library_folder / "pkgconfig")}
        # The files name the prefix of the build, for which they were not installed here.
        prefix = f"--define-variable=prefix={self.work / 'usr'}"
        flags = run("pkg-config", prefix, "--cflags", "--libs", "crsm_slam", env=environment, text=True).split()
        run("c++", "-std=c++20", EXAMPLE / "map_log.cpp", "-o", self.work / "by_pkg_config", *flags)
        self.check_map(self.work / "by_pkg_config")

    def test_a_part_of_another_project(self):
        source = self.work / "whole"
        source.mkdir()
        (source / "CMakeLists.txt").write_text(f"""
            cmake_minimum_required(VERSION 3.22)
            project(whole LANGUAGES CXX)
            include(FetchContent)
            FetchContent_Declare(crsm_slam SOURCE_DIR {PROJECT})
            FetchContent_MakeAvailable(crsm_slam)
            add_executable(map_log {EXAMPLE}/map_log.cpp)
            target_link_libraries(map_log PRIVATE crsm_slam::crsm_slam)
            get_property(targets DIRECTORY {PROJECT} PROPERTY BUILDSYSTEM_TARGETS)
            get_property(tests DIRECTORY {PROJECT} PROPERTY TESTS)
            get_target_property(options map_log COMPILE_OPTIONS)
            message(STATUS "it has (${{targets}}) (${{tests}}) (${{options}}) (${{CMAKE_CXX_STANDARD}})")
            """)
        build = self.work / "whole_build"
        said = run("cmake", "-S", source, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                   "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG", text=True)
        self.assertIn("it has (crsm_lcmtypes_gen;crsm_lcmtypes;crsm_algorithm;crsm_slam_objects;crsm_slam) () (options-NOTFOUND) ()", said)
        self.check_map(self.build(build) / "map_log")
        prefix = self.work / "nothing"
        run("cmake", "--install", build, "--prefix", prefix)
        self.assertFalse(prefix.exists() and any(prefix.rglob("*crsm*")))

    def test_the_shared_library_shows_its_header_alone_and_needs_the_c_library_alone(self):
        library = self.library_folder / "libcrsm_slam.so"
        symbols = run("nm", "--dynamic", "--defined-only", "--demangle", library, text=True).splitlines()
        names = {line.split(" ", 2)[2] for line in symbols}
        self.assertTrue(names)
        self.assertEqual({name for name in names if not name.startswith("crsm_slam::")}, set())
        self.assertEqual({name for name in names if "Impl" in name}, set())
        needed = {line.split("[")[1].split(".so")[0] for line in run("readelf", "-d", library, text=True).splitlines()
                  if "(NEEDED)" in line}
        self.assertLessEqual(needed, {"libstdc++", "libm", "libgcc_s", "libc", "ld-linux-x86-64"})

    def test_the_types_are_installed(self):
        installed = {path.name for path in (self.work / "usr/share/crsm_slam/lcmtypes").iterdir()}
        self.assertEqual(installed, {path.name for path in (PROJECT / "lcmtypes").glob("*.lcm")})


if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[1] == "--help":
        print(__doc__.strip())
        sys.exit(0 if len(sys.argv) > 1 else 2)
    BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main()
