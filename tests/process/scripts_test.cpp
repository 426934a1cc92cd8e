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
    for (const char* tool : {"awk", "basename", "bash", "chmod", "cp", "dirname", "du", "grep", "gzip", "mkdir", "rm",
                             "sed", "sort", "tar", "uname", "xargs"}) {
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
