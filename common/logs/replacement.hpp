#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace crsm {

/// Takes the next piece of a file; false after an error, when no more is needed.
using Sink = std::function<bool(std::string_view)>;

/// Files of a folder that take the place of older ones together, once all of them are on the disk: one that fills up
/// leaves the older ones as they were. What was written and not renamed is removed at the end.
class Replacement {
 public:
  explicit Replacement(std::filesystem::path dir) : dir_(std::move(dir)) {}
  Replacement(const Replacement&) = delete;
  ~Replacement();

  /// Throws std::runtime_error that names the path and the reason; so do the others.
  void Write(const std::string& name, std::string_view bytes);

  /// A file that is made piece by piece, so that it need not fit into memory.
  void Write(const std::string& name, const std::function<void(const Sink&)>& produce);

  /// Whether a file was written that Rename has not renamed yet.
  bool Has(const std::string& name) const;

  /// Removes those of the folder's `names` that were not written: they are of an earlier map.
  void RemoveOthers(std::span<const char* const> names) const;

  void Rename();

 private:
  std::filesystem::path Temporary(const std::string& name) const;
  [[noreturn]] void Fail(const std::string& name, int error) const;

  std::filesystem::path dir_;
  std::vector<std::string> names_;  ///< of temporary files
};

/// Removes files of results that a process which was killed while it wrote them (Replacement) has left in a folder.
void RemoveLeftovers(const std::filesystem::path& dir);

/// Writes all the bytes to an open file. False, with errno set, if that fails.
bool WriteAll(int descriptor, std::string_view bytes);

}  // namespace crsm
