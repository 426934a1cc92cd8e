// Databases and folders of rosbag2.

#include <sqlite3.h>

#include "bag_bytes.hpp"
#include "catch.hpp"
#include "packed.hpp"
#include "services/sources/bags/bag_source.hpp"
#include "services/sources/open_laser_source.hpp"
#include "source_helpers.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

std::string OneScan(std::uint32_t sec) {
  return McapBytes(McapChannel(1, "/scan") + McapMessage(1, LaserMessage{.sec = sec}.Cdr()));
}

std::vector<std::int64_t> SecondsOf(LaserSource& source) {
  std::vector<std::int64_t> seconds;
  while (const auto scan = source.Next()) seconds.push_back(scan->utime / 1'000'000);
  return seconds;
}
using Seconds = std::vector<std::int64_t>;

Seconds SecondsOf(const ScratchFolder& folder) { return SecondsOf(*OpenLaserSource(folder.path(), {})); }
std::string RefusalOf(const ScratchFolder& folder) {
  return ErrorOf([&] { OpenLaserSource(folder.path(), {}); });
}

/// A database that SQL makes.
class Database {
 public:
  explicit Database(const std::string& sql) {
    fs::remove(file_.path());
    sqlite3* database = nullptr;
    REQUIRE(sqlite3_open(file_.path().c_str(), &database) == SQLITE_OK);
    REQUIRE(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK);
    sqlite3_close(database);
  }
  std::string path() const { return file_.path(); }

 private:
  ScratchFile file_{""};
};

const std::string kTopics =
    "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);"
    "INSERT INTO topics VALUES (1, '/scan', 'sensor_msgs/msg/LaserScan', 'cdr');";
const std::string kMessages =
    "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);";

std::string Insert(int row, const std::string& data) {
  std::string hex;
  for (const char byte : data) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    hex += {kDigits[static_cast<unsigned char>(byte) >> 4], kDigits[byte & 15]};
  }
  return "INSERT INTO messages VALUES (" + std::to_string(row) + ", 1, " + std::to_string(-row) + ", x'" + hex + "');";
}

}  // namespace

TEST_CASE("the files of a folder are read in the order of its metadata.yaml") {
  const ScratchFolder folder;
  folder.Write("run_0.mcap", OneScan(1));
  folder.Write("run_1.mcap", OneScan(2));
  folder.Write("left_over.mcap", OneScan(3));
  folder.Write("metadata.yaml",
               "info:\n  relative_file_paths:\n    - \"run_1.mcap\"\n    - old_name/run_0.mcap\n  files:\n    - a\n");
  CHECK(SecondsOf(folder) == Seconds{2, 1});
}

TEST_CASE("without metadata.yaml the files of a folder go by their numbers") {
  const ScratchFolder folder;
  folder.Write("run_10.mcap", OneScan(10));
  folder.Write("run_9.mcap", OneScan(9));
  folder.Write("notes.txt", "none");
  CHECK(SecondsOf(folder) == Seconds{9, 10});
  folder.Write("other_1.mcap", OneScan(1));
  CHECK(RefusalOf(folder).ends_with("has 2 recordings and no metadata.yaml: give the file of one recording"));
}

TEST_CASE("the last file of a folder may be empty, which is said") {
  const ScratchFolder folder;
  folder.Write("run_0.mcap", OneScan(1));
  folder.Write("run_1.mcap", "");
  const auto source = OpenLaserSource(folder.path(), {});
  CHECK(SecondsOf(*source) == Seconds{1});
  CHECK(source->Progress() == 1.0);
  CHECK(DescribeCut("run", *source).find("(truncated)") != std::string::npos);
}

TEST_CASE("the files of a folder may be compressed, and metadata.yaml need not know it") {
  for (const bool is_told : {false, true}) {
    const ScratchFolder folder;
    folder.Write("run_0.mcap.zstd", Pack("zstd", OneScan(1)));
    folder.Write("run_1.mcap", OneScan(2));
    folder.Write("run_2.mcap.xz", Pack("xz", OneScan(3)));
    if (is_told)
      folder.Write("metadata.yaml", "relative_file_paths:\n  - run_0.mcap\n  - run_1.mcap.zstd\n  - run_2.mcap.xz\n");
    CHECK(SecondsOf(folder) == Seconds{1, 2, 3});
  }
}

TEST_CASE("a folder whose files are missing is refused, with what mends it") {
  const ScratchFolder folder;
  const auto RefusalOfOne = [&](const std::string& file) {
    folder.Write("metadata.yaml", "relative_file_paths:\n  - " + file + "\n");
    return RefusalOf(folder);
  };
  CHECK(RefusalOfOne("run_0.mcap").find("/run_0.mcap is missing, but ") != std::string::npos);
  folder.Write("metadata.yaml", "nothing");
  CHECK(RefusalOf(folder).ends_with("has no .db3 or .mcap file of rosbag2"));
  folder.Write("run_0.mcap", "no bag, though it is called one");
  CHECK(RefusalOf(folder).ends_with("/run_0.mcap is neither a ROS 1 bag, nor MCAP, nor a database of rosbag2"));
}

TEST_CASE("messages of a database come in the order of their recording, not of their times") {
  const Database database(kTopics + kMessages + Insert(2, LaserMessage{.sec = 2}.Cdr()) +
                          Insert(1, LaserMessage{.sec = 1}.Cdr()) + Insert(3, std::string(2 << 20, 'x')) +
                          "INSERT INTO messages VALUES (4, 1, 0, NULL);" + Insert(5, LaserMessage{.sec = 5}.Cdr()));
  BagSource source(database.path(), {});
  CHECK(SecondsOf(source) == Seconds{1, 2, 5});
  CHECK(source.Counts() == std::map<std::string, std::int64_t>{{"bad_chunk", 0}, {"bad_message", 2}, {"truncated", 0}});
}

TEST_CASE("a database that is none of rosbag2, or that computes without end, is refused") {
  const auto error_of = [](const std::string& sql) {
    const Database database(sql);
    return ErrorOf([&] { BagSource(database.path(), {}); });
  };
  for (const std::string& sql : {std::string("CREATE TABLE t(a);"), kTopics,
                                 kTopics + "CREATE VIEW messages AS WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL SELECT "
                                           "id + 1 FROM n) SELECT id, 1 AS topic_id, x'' AS data FROM n;"}) {
    CHECK(error_of(sql).ends_with("not of rosbag2: it has no tables topics and messages"));
  }
  CHECK(error_of("CREATE TABLE topics(a); CREATE TABLE messages(b);").ends_with("no such column: id"));
}

TEST_CASE("a database with special characters in its name is read, and nothing is left beside it") {
  const ScratchFolder folder;
  folder.Write("a?b#c%20d.db3", DataBytes("run.db3"));
  CHECK(OpenLaserSource(folder / "a?b#c%20d.db3", {})->Next()->utime == 1'000'000);
  CHECK(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()) == 1);
}

TEST_CASE("what a recorder that was killed has left in a write-ahead log is read") {
  const ScratchFolder folder;
  const std::string path = folder / "run.db3";
  sqlite3* database = nullptr;
  REQUIRE(sqlite3_open(path.c_str(), &database) == SQLITE_OK);
  const std::string sql = "PRAGMA journal_mode = WAL;" + kTopics + kMessages + Insert(1, LaserMessage{.sec = 1}.Cdr());
  REQUIRE(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK);
  const ScratchFolder left;
  for (const std::string suffix : {"", "-wal"}) fs::copy(path + suffix, left / ("run.db3" + suffix));
  sqlite3_close(database);
  CHECK(SecondsOf(*OpenLaserSource(left / "run.db3", {})) == Seconds{1});
}

}  // namespace crsm
