#include "services/base/path_lock.hpp"

#include <sys/stat.h>

#include <optional>

#include "catch.hpp"
#include "scratch.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

std::string ErrorOfLocking(const fs::path& path) {
  return ErrorOf([&] { PathLock("--out", path); });
}

}  // namespace

TEST_CASE("a folder or file that is locked is refused, and free again when the lock ends") {
  const ScratchFolder folder;
  folder.Write("file", "1");
  for (const fs::path& path : {folder.path(), folder / "file"}) {
    std::optional<PathLock> lock(std::in_place, "--journal", path);
    CHECK(ErrorOfLocking(path).find("--out " + path.string() + ": ") == 0);
    CHECK(ErrorOfLocking(path).find(" writes there") != std::string::npos);
    lock.reset();
    CHECK(ErrorOfLocking(path).empty());
  }
}

TEST_CASE("what is no folder and no file is refused, and is not waited for") {
  const ScratchFolder folder;
  const fs::path fifo = folder / "fifo";
  REQUIRE(mkfifo(fifo.c_str(), 0600) == 0);
  CHECK(ErrorOfLocking(fifo) == "--out " + fifo.string() + ": is neither a folder nor a file");
  CHECK(ErrorOfLocking(folder / "nothing").find("cannot be read: No such file") != std::string::npos);
}

TEST_CASE("a lock knows when its folder is no longer in its place") {
  const ScratchFolder folder;
  const fs::path path = folder / "out";
  fs::create_directory(path);
  const PathLock lock("--out", path);
  CHECK(lock.IsInPlace());
  fs::rename(path, folder / "moved");
  CHECK_FALSE(lock.IsInPlace());
  fs::create_directory(path);
  CHECK_FALSE(lock.IsInPlace());
  fs::remove(path);
  fs::rename(folder / "moved", path);
  CHECK(lock.IsInPlace());
}

}  // namespace crsm
