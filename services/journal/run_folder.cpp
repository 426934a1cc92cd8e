#include "services/journal/run_folder.hpp"

#include "common/math/parse_number.hpp"
#include "services/journal/journal.hpp"

namespace crsm {

RunFolder FindRun(const std::filesystem::path& results) {
  std::filesystem::path path = std::filesystem::absolute(results).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();  // "a/b/" has none
  const auto number = ParseNumber<int>(path.filename().string());
  const bool is_piece = number && *number > 1 && path.parent_path().filename() == "pieces";
  if (!is_piece || std::filesystem::exists(JournalPath(JournalFolder(path)))) return {results, 1};
  return {path.parent_path().parent_path(), *number};
}

}  // namespace crsm
