#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "common/diagnosis/run_statistics.hpp"
#include "common/diagnosis/verdict.hpp"
#include "common/marks/mark_book.hpp"
#include "common/results/results.hpp"
#include "common/scan/deskew.hpp"
#include "common/slam.hpp"
#include "crsm_slam/slam.hpp"
#include "services/base/identity.hpp"
#include "services/journal/journal.hpp"

namespace crsm_slam {

/// made_with: by which an earlier map was made; what is set one by one goes before. Throws std::invalid_argument.
crsm::Parameters CheckedParameters(const Settings& settings, const crsm::ParameterTexts& made_with = {});

/// name: of the argument. Throws std::invalid_argument for a pose that is none.
std::optional<crsm::Pose2> FromPublic(const std::optional<Pose>& pose, const char* name);

struct [[gnu::visibility("hidden")]] Slam::Impl {
  explicit Impl(const crsm::Parameters& of_map) : parameters(of_map), slam(of_map) {}

  void Hear(const std::vector<crsm::GraphUpdate>& updates) {
    for (const crsm::GraphUpdate& update : updates) loop_closed |= !update.closed.empty();
    if (finished) return;
    for (const crsm::GraphUpdate& update : updates) found.push_back({std::ssize(matched), update});
  }

  /// What is asked for is by all that the scans so far can tell.
  crsm::Slam& Await() {
    Hear(slam.AwaitLoops());
    return slam;
  }

  void Add(const crsm::ScanMatch& match, bool is_drawn) {
    matched.push_back(match);
    drawn.push_back(is_drawn);
    statistics.Add(match);
  }

  /// Keyframes have only what may be drawn of them.
  void KeepRays(const crsm::CriticalRays& scan, const crsm::Twist& twist) {
    if (!finished) rays.emplace_back(crsm::Deskew(scan, twist).rays);
  }

  /// What `use` makes of the map.
  template <class Use>
  auto WithMap(Use && use) {
    return Await().closes_loops() ? use(slam.DrawPiece(1)) : use(slam.map());
  }
  crsm::DenseGrid DrawGrid() {
    return WithMap([](const crsm::ByteMap& map) { return map.ToDenseGrid(); });
  }

  /// map: that of WithMap.
  crsm::Verdict Judge(const crsm::ByteMap& map, const crsm::MapPieces& pieces) const {
    crsm::RunStatistics all = statistics;
    all.ForgetMatches();
    for (std::int64_t scan = 0; scan < std::ssize(matched); ++scan) all.Add(BestMatch(scan));
    crsm::Verdict verdict = crsm::Judge(all, map, pieces);
    if (const auto wheels = slam.tracking().wheels().Learned()) crsm::JudgeWheels(*wheels, verdict);
    return verdict;
  }
  crsm::MapPieces FindPieces() const {
    return slam.closes_loops() ? slam.mapper().FindPiecesAndError() : crsm::MapPieces();
  }

  /// By all that is known.
  crsm::ScanMatch BestMatch(std::int64_t scan) const {
    const crsm::ScanMatch& match = matched[static_cast<std::size_t>(scan)];
    return slam.closes_loops() ? slam.mapper().BestMatch(scan, match) : match;
  }

  // ---- marks.cpp
  void Take(crsm::Mark mark);
  std::pair<std::optional<crsm::ScanAt>, std::optional<crsm::ScanAt>> FindScans(std::int64_t utime) const;

  // ---- save.cpp
  void WriteJournal(const std::filesystem::path& folder) const;
  void Append(const crsm::GraphUpdate& of_loop, crsm::Journal& journal) const;
  crsm::MatchSequence Matches() const;
  crsm::Results MakeResults(const std::filesystem::path& folder);
  void WritePieces(const std::filesystem::path& folder, const crsm::MapPieces& pieces) const;

  crsm::Parameters parameters;
  crsm::Slam slam;
  std::vector<crsm::ScanMatch> matched;  ///< as they were matched
  std::vector<bool> drawn;               ///< which of them
  std::vector<crsm::PackedRays> rays;    ///< of those that were drawn, whole
  /// What loops brought, and how many scans there were.
  std::vector<std::pair<std::int64_t, crsm::GraphUpdate>> found;
  crsm::MarkBook book;
  std::vector<crsm::FixedMark> marks;  ///< those in it, as they came
  std::unordered_set<std::int64_t> utimes;
  crsm::RunStatistics statistics;
  crsm::CriticalRays last_scan;
  std::int64_t epoch = crsm::DrawIdentity();  ///< of the map, as its journals have it
  std::string load_notice;                    ///< as of LoadNotice
  bool loop_closed = false;                   ///< and not told yet
  bool finished = false;                      ///< the map

  /// The map as it was told, and since which version each tile is as it is.
  struct Told {
    crsm::TileBytes cells;
    std::int64_t version;
  };
  std::map<crsm::TileIndex, Told> told;
  std::int64_t version = 0;

  void Tell(const crsm::ByteMap& map) {
    std::int64_t newest = version;
    const auto TellTile = [&](crsm::TileIndex index, const crsm::TileBytes& cells) {
      const auto [at, is_new] = told.try_emplace(index, Told{cells, version + 1});
      if (!is_new && at->second.cells == cells) return;
      at->second = {cells, version + 1};
      newest = version + 1;
    };
    for (const auto& [index, tile] : map.tiles().entries()) TellTile(index, tile->cells);
    for (const auto& [index, tile] : told) {
      if (!map.tiles().Find(index)) TellTile(index, crsm::kUnexploredBytes);
    }
    version = newest;
  }
};

}  // namespace crsm_slam
