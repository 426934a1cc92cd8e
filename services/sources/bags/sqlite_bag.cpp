#include "services/sources/bags/sqlite_bag.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sqlite3.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "common/logs/regular_file.hpp"
#include "common/logs/stop_request.hpp"
#include "common/logs/temporary_file.hpp"
#include "services/base/file_window.hpp"
#include "services/wire/lcm_event_log.hpp"

namespace crsm {
namespace {

std::string TextAt(sqlite3_stmt* row, int column) {
  const unsigned char* text = sqlite3_column_text(row, column);
  return text ? std::string(reinterpret_cast<const char*>(text),
                            static_cast<std::size_t>(sqlite3_column_bytes(row, column)))
              : std::string();
}

/// A path as SQLite's URIs want it.
std::string Escape(const std::string& path) {
  std::string escaped;
  for (const char c : path) {
    const bool is_special = c == '%' || c == '?' || c == '#';
    escaped += is_special ? fmt::format("%{:02x}", c) : std::string(1, c);
  }
  return escaped;
}

/// Whether a database ends before the pages do that its header counts.
bool IsCut(const std::string& path) {
  constexpr std::size_t kHeaderBytes = 100;
  FileWindow file(path);
  const std::string_view header = file.At(0, kHeaderBytes);
  if (header.size() < kHeaderBytes) return true;
  const auto number_at = [&](std::size_t at, std::size_t count) { return ReadBigEndian(header, at, count); };
  const std::uint64_t page_bytes = number_at(16, 2) == 1 ? 65536 : number_at(16, 2);
  const bool is_count_valid = number_at(24, 4) == number_at(92, 4);
  return is_count_valid && file.size() < page_bytes * number_at(28, 4);
}

}  // namespace

bool SqliteBag::Is(std::string_view start) { return start.starts_with(std::string_view("SQLite format 3\0", 16)); }

SqliteBag::SqliteBag(const std::string& path, const WantTopic& want)
    : path_(path), database_(nullptr, sqlite3_close), messages_(nullptr, sqlite3_finalize) {
  Open();
  CheckTables();
  ReadTopics(want);
}

SqliteBag::~SqliteBag() = default;

void SqliteBag::Open() {
  // Nobody writes to a finished recording: then neither locks nor files beside it are needed. One that was killed may
  // have its last messages in a write-ahead log.
  const bool has_log = std::filesystem::exists(path_ + "-wal");
  damage_.truncated = !has_log && IsCut(path_);
  if (TemporaryFile::IsPath(path_)) {
    OpenUnpacked();
  } else {
    OpenFile(has_log);
  }
  sqlite3* const database = database_.get();
  sqlite3_limit(database, SQLITE_LIMIT_LENGTH, 16 << 20);
  constexpr int kInstructions = 100'000;  // of SQLite's, a millisecond's worth
  sqlite3_progress_handler(
      database, kInstructions, [](void*) { return StopRequested() ? 1 : 0; }, nullptr);
  sqlite3_db_config(database, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);  // its views and triggers run nothing
  // Without it SQLite refuses all of a file that is cut short. Nothing can be written all the same.
  sqlite3_db_config(database, SQLITE_DBCONFIG_WRITABLE_SCHEMA, 1, nullptr);
}

void SqliteBag::OpenFile(bool has_log) {
  const std::string uri = fmt::format("file:{}?{}", Escape(path_), has_log ? "mode=ro" : "immutable=1");
  sqlite3* database = nullptr;
  const int code =
      sqlite3_open_v2(uri.c_str(), &database, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX, nullptr);
  database_.reset(database);
  if (code != SQLITE_OK) Fail();
}

/// SQLite follows a path to the name of the file, which a temporary one has not. It is given the bytes instead; the
/// kernel reads those that it looks at.
void SqliteBag::OpenUnpacked() {
  constexpr std::size_t kFormatVersions = 18;  // 2 and 2: there may be a write-ahead log, which memory cannot have
  const int descriptor = OpenRegularFile(path_, O_RDONLY);
  const auto size = static_cast<std::size_t>(std::max<off_t>(0, lseek(descriptor, 0, SEEK_END)));
  void* const bytes = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_NORESERVE, descriptor, 0);
  close(descriptor);
  if (bytes == MAP_FAILED) throw std::runtime_error(fmt::format("cannot read {}: {}", path_, std::strerror(errno)));
  memory_ = {static_cast<unsigned char*>(bytes), [size](unsigned char* begin) { munmap(begin, size); }};
  if (size > kFormatVersions + 1) memory_.get()[kFormatVersions] = memory_.get()[kFormatVersions + 1] = 1;
  sqlite3* database = nullptr;
  int code = sqlite3_open_v2(":memory:", &database, SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX, nullptr);
  database_.reset(database);
  const auto count = static_cast<sqlite3_int64>(size);
  if (code == SQLITE_OK)
    code = sqlite3_deserialize(database, "main", memory_.get(), count, count, SQLITE_DESERIALIZE_READONLY);
  if (code != SQLITE_OK) Fail();
}

void SqliteBag::Fail() const {
  throw std::runtime_error(fmt::format("cannot read {}: {}", path_, sqlite3_errmsg(database_.get())));
}

SqliteBag::Statement SqliteBag::Prepare(const std::string& query) const {
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(database_.get(), query.c_str(), -1, &statement, nullptr) != SQLITE_OK) Fail();
  return {statement, sqlite3_finalize};
}

/// Plain tables only, as SQLite itself sees them: a view could make rows without end, and columns that are computed
/// could compute for ever.
void SqliteBag::CheckTables() const {
  if (Count("SELECT count(*) FROM pragma_table_list WHERE schema = 'main' AND type = 'table' AND "
            "name IN ('topics', 'messages')") != 2) {
    throw std::runtime_error(
        fmt::format("{} is an SQLite database, but not of rosbag2: it has no tables topics and messages", path_));
  }
  if (Count("SELECT (SELECT count(*) FROM pragma_table_xinfo('topics') WHERE hidden != 0) + "
            "(SELECT count(*) FROM pragma_table_xinfo('messages') WHERE hidden != 0)") != 0) {
    throw std::runtime_error(
        fmt::format("{} is no recording of rosbag2: its tables have columns that are computed", path_));
  }
}

/// What a query counts.
int SqliteBag::Count(const std::string& query) const {
  const Statement row = Prepare(query);
  if (sqlite3_step(row.get()) != SQLITE_ROW) Fail();
  return sqlite3_column_int(row.get(), 0);
}

void SqliteBag::ReadTopics(const WantTopic& want) {
  constexpr std::size_t kMostTopics = 10000;
  const Statement rows = Prepare(
      "SELECT id, substr(name, 1, 1000), substr(type, 1, 1000), substr(serialization_format, 1, 1000) FROM topics "
      "ORDER BY rowid");
  int code = SQLITE_ROW;
  std::string numbers;
  while ((code = sqlite3_step(rows.get())) == SQLITE_ROW && topics_.size() < kMostTopics) {
    topics_.push_back({TextAt(rows.get(), 1), TextAt(rows.get(), 2), TextAt(rows.get(), 3)});
    if (!want(topics_.back())) continue;
    wanted_.emplace_back(sqlite3_column_int64(rows.get(), 0), topics_.back().name);
    numbers += fmt::format("{}{}", numbers.empty() ? "" : ", ", wanted_.back().first);
  }
  if (code != SQLITE_ROW && code != SQLITE_DONE) Fail();
  messages_ = Prepare(fmt::format(
      "SELECT rowid, topic_id, CASE WHEN length(data) <= {} THEN data END FROM messages WHERE topic_id IN ({}) "
      "ORDER BY rowid",
      kMostMessageBytes, numbers));
  const Statement ends = Prepare("SELECT min(rowid), max(rowid) FROM messages");
  if (sqlite3_step(ends.get()) == SQLITE_ROW) {  // a damaged end is told when it is reached
    first_row_ = sqlite3_column_int64(ends.get(), 0);
    last_row_ = sqlite3_column_int64(ends.get(), 1);
  }
}

std::optional<BagMessage> SqliteBag::Next() {
  if (!messages_) return std::nullopt;
  const int code = sqlite3_step(messages_.get());
  if (code != SQLITE_ROW) {
    if (code == SQLITE_IOERR) Fail();
    damage_.truncated = damage_.truncated || code != SQLITE_DONE;
    progress_ = 1.0;
    messages_.reset();
    return std::nullopt;
  }
  sqlite3_stmt* row = messages_.get();
  const double rows = static_cast<double>(last_row_) - static_cast<double>(first_row_);
  const double done = static_cast<double>(sqlite3_column_int64(row, 0)) - static_cast<double>(first_row_);
  progress_ = rows > 0.0 ? std::clamp(done / rows, 0.0, 1.0) : 0.0;

  const std::int64_t number = sqlite3_column_int64(row, 1);
  const auto topic =
      std::find_if(wanted_.begin(), wanted_.end(), [&](const auto& entry) { return entry.first == number; });
  BagMessage message{topic == wanted_.end() ? "" : topic->second, {}};
  const auto* data = static_cast<const char*>(sqlite3_column_blob(row, 2));
  if (data) message.data = {data, static_cast<std::size_t>(sqlite3_column_bytes(row, 2))};
  return message;
}

}  // namespace crsm
