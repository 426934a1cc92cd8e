#include "services/sources/parts_source.hpp"

#include <fmt/core.h>
#include <glob.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <exception>
#include <functional>
#include <set>
#include <stdexcept>
#include <utility>

#include "services/sources/unpacked_file.hpp"

namespace crsm {
namespace {

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

/// Letters by their order, numbers by their size.
bool ComesBefore(const std::string& a, const std::string& b) {
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (IsDigit(a[i]) && IsDigit(b[j])) {
      const auto EndOf = [](const std::string& text, std::size_t at) {
        while (at < text.size() && IsDigit(text[at])) ++at;
        return at;
      };
      const auto Strip = [](std::string digits) {
        return digits.erase(0, std::min(digits.find_first_not_of('0'), digits.size()));
      };
      const std::size_t i_end = EndOf(a, i);
      const std::size_t j_end = EndOf(b, j);
      const std::string of_a = Strip(a.substr(i, i_end - i));
      const std::string of_b = Strip(b.substr(j, j_end - j));
      if (of_a != of_b) return std::pair(of_a.size(), of_a) < std::pair(of_b.size(), of_b);
      i = i_end;
      j = j_end;
    } else if (a[i] != b[j]) {
      return a[i] < b[j];
    } else {
      ++i;
      ++j;
    }
  }
  return a.size() - i < b.size() - j;
}

/// In the place of a part that cannot be read.
class NoScans : public LaserSource {
 public:
  std::optional<LaserScan> Next() override { return std::nullopt; }
  double Progress() const override { return 1.0; }
  std::map<std::string, std::int64_t> Counts() const override { return {}; }
};

}  // namespace

bool IsPattern(const std::string& path) { return path.find_first_of("*?") != std::string::npos; }

std::vector<std::string> FindParts(const std::string& pattern) {
  std::string escaped;  // only * and ? stand for others
  for (const char c : pattern) escaped += c == '[' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  glob_t found{};
  const int code = glob(escaped.c_str(), GLOB_NOSORT, nullptr, &found);
  std::vector<std::string> paths;
  for (std::size_t i = 0; code == 0 && i < found.gl_pathc; ++i) paths.emplace_back(found.gl_pathv[i]);
  globfree(&found);
  if (paths.empty()) throw std::runtime_error(fmt::format("there is no file {}", pattern));
  std::ranges::sort(paths, ComesBefore);
  std::set<std::pair<dev_t, ino_t>> files;  // each once: a link may name the newest
  std::erase_if(paths, [&](const std::string& path) {
    struct stat status {};
    return stat(path.c_str(), &status) == 0 && !files.emplace(status.st_dev, status.st_ino).second;
  });
  const std::set<std::string> names(paths.begin(), paths.end());
  std::erase_if(paths, [&](const std::string& path) {  // run.lcm.gz beside run.lcm
    constexpr std::array kEndings{".bz2", ".gz", ".lz4", ".xz", ".zst", ".zstd"};
    return std::ranges::any_of(kEndings, [&](const std::string& ending) {
      return path.ends_with(ending) && names.count(path.substr(0, path.size() - ending.size())) > 0;
    });
  });
  return paths;
}

PartsSource::PartsSource(std::vector<std::string> paths, Open open)
    : paths_(std::move(paths)), open_(std::move(open)), part_(std::make_unique<NoScans>()) {
  SortByTime();
  OpenNext();
}

void PartsSource::SortByTime() {
  constexpr std::size_t kLooks = 3;
  std::vector<std::int64_t> first_utimes;  // of the first parts that have scans
  std::exception_ptr first_error;
  for (std::size_t i = 0; i < paths_.size() && first_utimes.size() < kLooks; ++i) {
    try {
      if (const auto scan = open_(paths_[i], "")->Next()) first_utimes.push_back(scan->utime);
    } catch (const std::runtime_error&) {
      if (!first_error) first_error = std::current_exception();
    }
  }
  if (first_utimes.empty() && first_error) std::rethrow_exception(first_error);
  if (first_utimes.size() < 2) return;
  const bool falls = std::ranges::adjacent_find(first_utimes, std::less_equal<>()) == first_utimes.end();
  if (!falls) return;
  std::ranges::reverse(paths_);
  complaints_.push_back("the parts are read from the last to the first: their times go that way");
}

/// The last part of a recording that was killed may be none.
void PartsSource::OpenNext() {
  try {
    part_ = open_(paths_[num_opened_], channel_);
    if (channel_.empty()) channel_ = part_->Channel();
    is_upside_down_ = is_upside_down_ || part_->IsUpsideDown();
  } catch (const std::runtime_error& error) {
    counts_["truncated"] = 1;
    complaints_.emplace_back(error.what());
    part_ = std::make_unique<NoScans>();
  }
  ++num_opened_;
}

std::optional<LaserScan> PartsSource::Next() {
  while (true) {
    if (auto scan = part_->Next()) return scan;
    if (num_opened_ == paths_.size()) return std::nullopt;
    counts_ = Counts();
    complaints_ = Complaints();
    ForgetUnpacked(paths_[num_opened_ - 1]);
    OpenNext();
  }
}

double PartsSource::Progress() const {
  const double before = static_cast<double>(num_opened_) - 1.0;
  return (before + part_->Progress()) / static_cast<double>(paths_.size());
}

std::map<std::string, std::int64_t> PartsSource::Counts() const {
  std::map<std::string, std::int64_t> counts = counts_;
  for (const auto& [name, count] : part_->Counts()) counts[name] += count;
  return counts;
}

std::vector<std::string> PartsSource::Complaints() const {
  std::vector<std::string> complaints = complaints_;
  for (const std::string& complaint : part_->Complaints()) {
    complaints.push_back(fmt::format("{}: {}", paths_[num_opened_ - 1], complaint));
  }
  return complaints;
}

}  // namespace crsm
