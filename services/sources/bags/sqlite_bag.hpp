#pragma once

#include <memory>

#include "services/sources/bags/bag_reader.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace crsm {

/// A file of rosbag2's SQLite storage (.db3), read in the order in which its messages were recorded. The file is not
/// written to, nor anything beside it unless the recorder has left a write-ahead log there.
class SqliteBag : public BagReader {
 public:
  static bool Is(std::string_view start);

  /// Throws std::runtime_error if the file cannot be opened, or is another database.
  SqliteBag(const std::string& path, const WantTopic& want);
  ~SqliteBag() override;

  std::optional<std::vector<BagTopic>> ListedTopics() override { return topics_; }
  std::optional<BagMessage> Next() override;
  double Progress() const override { return progress_; }
  BagDamage damage() const override { return damage_; }

 private:
  using Statement = std::unique_ptr<sqlite3_stmt, int (*)(sqlite3_stmt*)>;

  void Open();
  void OpenFile(bool has_log);
  void OpenUnpacked();
  Statement Prepare(const std::string& query) const;
  void CheckTables() const;
  int Count(const std::string& query) const;
  void ReadTopics(const WantTopic& want);
  [[noreturn]] void Fail() const;

  std::string path_;
  std::shared_ptr<unsigned char> memory_;  ///< of the whole file, where it has no name by which SQLite could open it
  std::unique_ptr<sqlite3, int (*)(sqlite3*)> database_;
  Statement messages_;
  std::vector<BagTopic> topics_;
  std::vector<std::pair<std::int64_t, std::string>> wanted_;  ///< number and name
  std::int64_t first_row_ = 0;
  std::int64_t last_row_ = 0;
  double progress_ = 0.0;
  BagDamage damage_;
};

}  // namespace crsm
