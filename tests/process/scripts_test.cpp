// What scripts say: which step they are at, and what is missing.

#include <filesystem>
#include <fstream>

#include "catch.hpp"
#include "processes.hpp"

using namespace crsm;

namespace fs = std::filesystem;

namespace {

/// Scripts of the project in a project that has nothing else, and a PATH with the tools of the shell alone.
class ScriptFolder {
 public:
  explicit ScriptFolder(const std::vector<std::string>& scripts) {
    for (const std::string& script : scripts) {
      fs::create_directories((folder_ / "scripts" / script).parent_path());
      fs::copy_file(fs::path(CRSM_SOURCE_DIR) / "scripts" / script, folder_ / "scripts" / script);
    }
    fs::create_directories(folder_ / "bin");
    for (const char* tool : {"awk", "basename", "bash", "chmod", "cp", "dirname", "du", "env", "grep", "gzip", "mkdir",
                             "paste", "rm", "sed", "sort", "cat", "tar", "uname", "xargs"}) {
      fs::create_symlink(fs::path("/usr/bin") / tool, folder_ / "bin" / tool);
    }
  }

  fs::path operator/(const std::string& name) const { return folder_ / name; }

  /// A tool, or a script, that does what a line of the shell says.
  void Write(const std::string& name, const std::string& line) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << "#!/bin/bash\n" << line << '\n';
    fs::permissions(folder_ / name, fs::perms::owner_all);
  }

  Ended Run(const std::string& script, const std::vector<std::string>& arguments) const {
    std::vector<std::string> words{"-i", "PATH=" + (folder_ / "bin").string(), "/bin/bash",
                                   (folder_ / "scripts" / script).string()};
    words.insert(words.end(), arguments.begin(), arguments.end());
    return folder_.Run("/usr/bin/env", words);
  }

  /// In the project's folder.
  Ended RunTool(const std::string& tool, std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"-C", (folder_ / ".").string(), tool});
    return folder_.Run("/usr/bin/env", arguments);
  }

 private:
  TemporaryFolder folder_;
};

}  // namespace

TEST_CASE("scripts/examples/run says which package or build is missing, and runs an example") {
  const ScriptFolder project({"functions.sh", "examples/run", "examples/driver.py"});
  const auto CheckRefused = [&](const std::vector<std::string>& arguments, const std::string& expected) {
    const Ended ended = project.Run("examples/run", arguments);
    CHECK(ended.exit_code == 1);
    CHECK(ended.errors == "run: " + expected + "\n");
  };
  CheckRefused({}, "which example? driver.py, listener.py or ray_selector.py");
  CheckRefused({"nonesuch.py"}, "which example? driver.py, listener.py or ray_selector.py");
  CheckRefused({"driver.py"}, "the Python examples need Python 3: sudo apt-get install python3");
  project.Write("bin/python3", "echo \"$PYTHONPATH runs $*\"");
  CheckRefused({"driver.py"},
               "no Python types in " + (project / "build/python").string() + ": run scripts/build programs");
  fs::create_directories(project / "build/python");
  const Ended ended = project.Run("examples/run", {"driver.py", "7"});
  CHECK(ended.exit_code == 0);
  CHECK(ended.output ==
        (project / "build/python").string() + " runs " + (project / "scripts/examples/driver.py").string() + " 7\n");
}

TEST_CASE("scripts/packages names each of its steps, and shows how far the compiler is") {
  const ScriptFolder project({"functions.sh", "packages"});
  project.Write("scripts/setup", "echo setup $*");
  project.Write("bin/git", "echo 1700000000");
  project.Write("bin/cmake",
                "[[ $1 == --build ]] && echo '[1/2] Building CXX object' || { "
                "mkdir -p build-packages/bin build-packages/python/crsm_slam; "
                "echo >build-packages/bin/slam_offline; echo >build-packages/python/crsm_slam/_crsm_slam.so; }");
  project.Write("bin/strip", "[[ $1 != -o ]] || cp \"$3\" \"$2\"");
  project.Write("bin/python3", "printf '%s\\n' \"$2\"/* \"$2\"/*/* >\"$3/crsm_slam.whl\"");
  project.Write("bin/ldd", "echo \"libfmt.so => $PWD/scripts/packages (0x0)\"");
  project.Write("bin/patchelf", "true");
  project.Write("bin/dpkg", "echo \"dpkg:amd64: $2\"");
  project.Write("CMakeLists.txt", "  VERSION 1.2.3");
  project.Write("LICENSE", "MIT");
  project.Write("bin/cpack", "echo package >\"$2/crsm-slam.deb\"");
  project.Write("bin/lintian", "echo lintian $*");
  const Ended ended = project.Run("packages", {});
  INFO(ended.errors);
  CHECK(ended.exit_code == 0);
  std::size_t last = 0;
  for (const char* text : {"packages: 1 of 7: installing what is missing\nsetup --packages\n",
                           "packages: 2 of 7: configuring", "packages: 3 of 7: compiling\n[1/2] Building CXX object\n",
                           "packages: 4 of 7: making the packages\npackages: 5 of 7: making the tarball\npackages: 6 "
                           "of 7: making the wheel\n",
                           "packages: 7 of 7: checking the packages with lintian\nlintian --fail-on error,warning "
                           "out/packages/crsm-slam.deb\n",
                           "\tout/packages/crsm-slam.deb\n"}) {
    CAPTURE(text);
    const std::size_t at = ended.output.find(text);
    REQUIRE(at != std::string::npos);
    CHECK(at >= last);
    last = at;
  }
  const Ended listed = project.RunTool("tar", {"-tzf", "out/packages/crsm-slam-1.2.3-linux-x86_64.tar.gz"});
  CHECK(listed.output.find("/bin/slam_offline") != std::string::npos);
  CHECK(listed.output.find("/lib/packages") != std::string::npos);
  const std::string wheel = ReadFile(project / "out/packages/crsm_slam.whl");
  for (const char* file : {"/crsm_slam/_crsm_slam.so\n", "/crsm_slam/bin/slam_offline\n", "/crsm_slam/lib/packages\n",
                           "/crsm_slam/licenses/dpkg\n"}) {
    CHECK(wheel.find(file) != std::string::npos);
  }
}

TEST_CASE("scripts/setup says which packages it installs, and how much they are to download and on the disk") {
  const ScriptFolder project({"functions.sh", "setup"});
  project.Write("bin/dpkg-query", "exit 1");
  project.Write("bin/sudo", "exec \"$@\"");
  project.Write("bin/ip", "true");
  project.Write(
      "bin/apt-get",
      "[[ $* != *--print-uris* ]] || "
      "echo $'Need to get 150 MB of archives.\\nAfter this operation, 610 MB of additional disk space will be used.'");
  project.Write("bin/apt-cache", "for package in \"${@:2}\"; do echo \"$package | 1.0 | http://a\"; done");
  const auto Installs = [&](const std::vector<std::string>& flags) {
    const Ended ended = project.Run("setup", flags);
    INFO(ended.errors);
    CHECK(ended.exit_code == 0);
    const std::string size = ": 150 MB to download, 610 MB on the disk, which takes some minutes\n";
    REQUIRE(ended.output.ends_with(size));
    REQUIRE(ended.output.starts_with("setup: installing g++ "));
    return ended.output.substr(0, ended.output.size() - size.size()) + " ";
  };
  const std::string for_tests = Installs({"--tests"});
  for (const char* package : {" catch2 ", " python3 ", " default-jre ", " xvfb ", " chromium ", " python3-rosbag ",
                              " spin ", " doxygen ", " python3-numpy ", " python3-venv "}) {
    CAPTURE(package);
    CHECK(for_tests.find(package) != std::string::npos);
  }
  CHECK(for_tests.find(" npm ") == std::string::npos);  // not from Debian alone
  CHECK(Installs({"--demo"}).find(" python3 ") == std::string::npos);
  CHECK(Installs({"--npm"}).find(" npm ") != std::string::npos);
  project.Write("bin/npm", "true");
  CHECK(Installs({"--npm"}).find(" npm ") == std::string::npos);
  project.Write("bin/apt-cache", "echo 'spin | 1.0 | http://a'");  // what building needs is never left out
  CHECK(Installs({"--protocol", "--docs"}).find(" spin ") != std::string::npos);
  CHECK(Installs({"--protocol", "--docs"}).find(" doxygen ") == std::string::npos);
  CHECK(project.Run("setup", {"--docs"}).errors == "setup: this system has no package doxygen: goes on without it\n");
}

TEST_CASE("scripts/build says before many steps how many there are and how long they take, and shows each") {
  const ScriptFolder project({"functions.sh", "build"});
  project.Write("bin/nproc", "echo 2");
  const auto Says = [&](const std::string& of_ninja) {
    project.Write("bin/cmake", "[[ $1 != --build ]] || printf '" + of_ninja + "'");
    const Ended ended = project.Run("build", {});
    CHECK(ended.exit_code == 0);
    return ended.output;
  };
  CHECK(Says("[0/2] Re-checking globbed directories...\\n[1/302] Building a\\n[2/302] Linking b\\n") ==
        "build: 302 steps, about 6 min on 2 processors\n[1/302] Building a\n[2/302] Linking b\n");
  CHECK(Says("[1/2] Re-running CMake...\\n[1/11] Building a\\n") ==
        "[1/2] Re-running CMake...\nbuild: 11 steps, about 1 min on 2 processors\n[1/11] Building a\n");
  CHECK(Says("[1/2] Building a\\n[2/2] Linking b\\n") == "[1/2] Building a\n[2/2] Linking b\n");
  CHECK(Says("ninja: no work to do.\\n").empty());
}

TEST_CASE(
    "scripts/test runs the tests with the tools that are there, and names what it leaves out, and what was skipped") {
  const ScriptFolder project({"functions.sh", "test"});
  project.Write("scripts/setup", "echo \"setup $*\"; [[ $* != --tests ]]");  // nobody is root
  project.Write("scripts/build", "echo \"build $*\"");
  project.Write("build/Testing/Temporary/LastTest.log", "1/1 Test: old\nskipped: long ago");
  const auto Run = [&](const std::string& log) {
    project.Write("bin/ctest", "echo \"ctest $*\"\n" + log + "\nexit 8");
    return project.Run("test", {"-R", "s"});
  };
  const Ended ended =
      Run("cat >Testing/Temporary/LastTest.log <<END\n"
          "1/4 Testing: spy\n1/4 Test: spy\nskipped: no Java: scripts/setup --spy\nTest Passed.\n"
          "2/4 Test: unit_logs\nskipped: no a.clf\nskipped: no b.clf\nTest Passed.\n"
          "3/4 Test: view\n  skipped: no npm: scripts/setup --npm\n  skipped: no npm: scripts/setup --npm\n"
          "  skipped: no room\nTest Failed.\n4/4 Test: unit\nit skipped: nothing\nTest Passed.\nEND");
  const std::string begin =
      "setup --tests\nsetup \nbuild --preset release\nctest --output-on-failure --parallel 4 -R s\n";
  CHECK(ended.exit_code == 8);
  CHECK(ended.errors == "test: continues with the tools that are installed\n");
  CHECK(ended.output == begin +
                            "skipped: spy: no Java: scripts/setup --spy\n"
                            "skipped: unit_logs: no a.clf\n"
                            "skipped: a part of view: no npm: scripts/setup --npm\n"
                            "skipped: a part of view: no room\n");
  CHECK(Run("").output == begin);
  project.Write("bin/ctest",
                "[[ $* == *--show-only* ]] && printf '  Test  #7: view\\n  Test #12: readme\\n' || echo \"ctest $*\"");
  CHECK(project.Run("test", {}).output ==
        "setup --tests\nsetup \nbuild --preset release\n"
        "test: left out: view readme; --all runs them, too\n"
        "ctest --output-on-failure --parallel 4 --label-exclude long\n");
  CHECK(project.Run("test", {"--all"}).output ==
        "setup --tests\nsetup \nbuild --preset release\nctest --output-on-failure --parallel 4\n");
}
