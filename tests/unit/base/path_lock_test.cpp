#include "services/base/path_lock.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <optional>

#include "catch.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

class Folder {
 public:
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
  const fs::path path = fs::temp_directory_path() / ("crsm_path_lock_test_" + std::to_string(getpid()));
};

std::string ErrorOf(const fs::path& path) {
  try {
    const PathLock lock("--out", path);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a folder or file that is locked is refused, and free again when the lock ends") {
  const Folder folder;
  std::ofstream(folder.path / "file") << "1";
  for (const fs::path& path : {folder.path, folder.path / "file"}) {
    std::optional<PathLock> lock(std::in_place, "--journal", path);
    CHECK(ErrorOf(path).find("--out " + path.string() + ": ") == 0);
    CHECK(ErrorOf(path).find(" writes there") != std::string::npos);
    lock.reset();
    CHECK(ErrorOf(path).empty());
  }
}

TEST_CASE("what is no folder and no file is refused, and is not waited for") {
  const Folder folder;
  const fs::path fifo = folder.path / "fifo";
  REQUIRE(mkfifo(fifo.c_str(), 0600) == 0);
  CHECK(ErrorOf(fifo) == "--out " + fifo.string() + ": is neither a folder nor a file");
  CHECK(ErrorOf(folder.path / "nothing").find("cannot be read: No such file") != std::string::npos);
}

TEST_CASE("a lock knows when its folder is no longer in its place") {
  const Folder folder;
  const fs::path path = folder.path / "out";
  fs::create_directory(path);
  const PathLock lock("--out", path);
  CHECK(lock.IsInPlace());
  fs::rename(path, folder.path / "moved");
  CHECK_FALSE(lock.IsInPlace());
  fs::create_directory(path);
  CHECK_FALSE(lock.IsInPlace());
  fs::remove(path);
  fs::rename(folder.path / "moved", path);
  CHECK(lock.IsInPlace());
}

}  // namespace crsm
