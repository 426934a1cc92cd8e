#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

#include "common/graph/g2o.hpp"
#include "common/logs/replacement.hpp"
#include "common/results/map_edits.hpp"
#include "common/results/mark_files.hpp"
#include "common/results/result_files.hpp"
#include "services/base/version.hpp"
#include "services/journal/journal_file.hpp"
#include "services/journal/move_aside.hpp"
#include "services/journal/results_lock.hpp"
#include "services/library/impl.hpp"
#include "services/library/overview.hpp"
#include "services/library/plain_png.hpp"

namespace crsm_slam {

/// As slam_offline keeps it, from what is known of the scans.
void Slam::Impl::WriteJournal(const std::filesystem::path& folder) const {
  crsm::Journal journal(folder, {false, crsm::ListMapParameters(parameters)}, epoch);
  std::size_t num_drawn = 0;
  auto update = found.begin();
  for (std::size_t scan = 0; scan < matched.size(); ++scan) {
    for (; update != found.end() && std::cmp_less_equal(update->first, scan); ++update) Append(update->second, journal);
    crsm::CriticalRays rays_of_scan;
    rays_of_scan.utime = matched[scan].utime;
    if (drawn[scan]) rays_of_scan.rays = rays[num_drawn++].Unpack();
    journal.Append(drawn[scan] ? &rays_of_scan : nullptr, matched[scan]);
  }
  for (; update != found.end(); ++update) Append(update->second, journal);
  if (const auto searched = slam.mapper().searched()) {
    journal.AppendSearched(*searched, slam.mapper().last_update(), slam.graph().keyframe(*searched).utime);
  }
  for (const crsm::FixedMark& mark : marks) journal.Append(mark);
  journal.Finish();
}

void Slam::Impl::Append(const crsm::GraphUpdate& of_loop, crsm::Journal& journal) const {
  journal.Append(of_loop, slam.graph().keyframe(of_loop.keyframe).utime);
}

crsm::MatchSequence Slam::Impl::Matches() const {
  return crsm::MatchSequence([this](const crsm::MatchSequence::Visit& visit) {
    for (std::int64_t scan = 0; scan < std::ssize(matched); ++scan) visit(BestMatch(scan));
  });
}

/// What slam_offline would write, but for what only a program knows: times, counts of a log, true poses.
crsm::Results Slam::Impl::MakeResults(const std::filesystem::path& folder) {
  crsm::Results results;
  results.matches = Matches();
  results.pieces = FindPieces();
  results.last_scan = last_scan;
  results.marks = book.Place(slam.mapper());
  results.name = crsm::NameOfRun(folder);
  const auto Describe = [&](const crsm::ByteMap& map) {
    results.grid = map.ToDenseGrid();
    crsm::Summary summary;
    summary.explored_area_m2 = crsm::ComputeExploredArea(results.grid);
    summary.verdict = Judge(map, results.pieces);
    summary.values = summary.verdict->values;
    return summary;
  };
  crsm::Summary summary = WithMap(Describe);
  summary.version = crsm::kVersion;
  summary.identity = crsm::FormatIdentity(epoch);
  summary.parameters["crsm_slam"] = crsm::ListParameters(parameters);
  summary.map_version = slam.map_version();
  summary.wheels = slam.tracking().wheels().Learned();
  summary.counts["scan_cut"] = slam.num_scans_cut();
  if (slam.closes_loops()) {
    summary.pieces = results.pieces;
    results.loops = slam.mapper().PlaceLoops();
    results.graph_g2o = crsm::FormatG2o(slam.MakeBestGraph().MakePoseGraph());
  }
  results.summary = std::move(summary);
  return results;
}

void Slam::Impl::WritePieces(const std::filesystem::path& folder, const crsm::MapPieces& pieces) const {
  crsm::RemovePieces(folder);
  for (const int number : pieces.OthersWithMap()) {
    const crsm::MatchSequence matches([&](const crsm::MatchSequence::Visit& visit) {
      for (const auto& [first, end] : slam.mapper().FindScans(slam.mapper().FindComponent(number))) {
        for (std::int64_t scan = first; scan < end; ++scan) visit(BestMatch(scan));
      }
    });
    crsm::WritePiece(folder, number, slam.DrawPiece(number).ToDenseGrid(), matches, crsm::EncodePlainMap);
  }
}

void Slam::Save(const std::string& folder) const {
  if (impl_->finished) throw std::logic_error("Save: the map is finished: it can only be saved before that");
  impl_->Await();
  namespace fs = std::filesystem;
  const fs::path journal = crsm::JournalFolder(folder);
  const fs::path half = crsm::HalfJournalFolder(folder);
  crsm::MakeFolder(folder);
  const crsm::ResultsLock lock("Save:", folder);
  crsm::RemoveLeftovers(folder);
  crsm::RemoveHalfJournal(folder);
  impl_->WriteJournal(half);
  const crsm::Results results = impl_->MakeResults(folder);
  crsm::Replacement files(folder);
  crsm::AddResults(results, {crsm::EncodePlainMap, OverviewEncoder()}, files);

  // Nothing has changed so far. From here on the folder is of this map alone, whenever the process ends.
  if (crsm::HoldsResults(folder) && !crsm::IsCovered(journal, impl_->epoch, impl_->matched)) {
    const fs::path place = crsm::MoveAside(folder);
    impl_->load_notice = "the results of another map in " + folder + " are now in " + place.string();
  }
  crsm::MakeFolder(journal);
  std::error_code error;
  fs::rename(crsm::JournalPath(half), crsm::JournalPath(journal), error);
  if (error) throw std::runtime_error("Save: cannot write " + journal.string() + ": " + error.message());
  crsm::SyncFolder(journal.string());
  crsm::RemoveHalfJournal(folder);
  files.RemoveOthers(crsm::kMarkFiles);
  files.RemoveOthers(crsm::kEditedFiles);
  crsm::FreeMapPicture(folder);
  files.Rename();
  impl_->WritePieces(folder, results.pieces);
  crsm::RemoveOldPictures(folder);
}

std::string Slam::LoadNotice() const { return impl_->load_notice; }

Slam Slam::Load(const std::string& folder, const Settings& settings, const std::optional<Pose>& T_map_laser) {
  const std::filesystem::path journal = crsm::JournalFolder(folder);
  if (!std::filesystem::exists(crsm::JournalPath(journal))) {
    throw std::runtime_error("there is no saved map in " + folder + ": it has no journal");
  }
  crsm::CheckAreOfOneMap(folder);
  const auto head = crsm::ReadHead(journal);
  if (!head) throw std::runtime_error(folder + ": there is no scan in its journal");
  crsm::Parameters parameters = CheckedParameters(settings, head->subject.parameters);
  parameters.match.start = FromPublic(T_map_laser, "T_map_laser");
  const auto differences = crsm::FindDifferences(head->subject.parameters, crsm::ListMapParameters(parameters));
  for (const auto& [key, other, text] : differences) {
    throw std::invalid_argument(key + ": the map in " + folder + " was made with " + other + ", not with " + text);
  }
  auto impl = std::make_unique<Impl>(parameters);
  impl->epoch = head->epoch;
  const auto Restore = [&](const crsm::CriticalRays* scan, const crsm::ScanMatch& match) {
    impl->slam.Restore(scan, match);
    impl->Add(match, scan != nullptr);
    impl->utimes.insert(match.utime);
    if (!scan) return;
    impl->statistics.Add(scan->utime, scan->rays);
    impl->last_scan = *scan;
    impl->KeepRays(*scan, match.twist);
  };
  const auto Update = [&](const crsm::GraphUpdate& update) {
    if (!impl->slam.Restore(update)) return false;
    impl->found.push_back({std::ssize(impl->matched), update});
    return true;
  };
  const auto Searched = [&](crsm::KeyframeId keyframe) { return impl->slam.RestoreSearched(keyframe); };
  crsm::VisitJournal visit{Restore, Update, Searched};
  visit.mark = [&](const crsm::FixedMark& mark) {
    impl->marks.push_back(mark);
    return impl->book.Add(mark, impl->slam.mapper());
  };
  impl->load_notice = crsm::ReadJournal(journal, {false, head->subject.parameters}, crsm::OnDamage::kRefuse, visit);
  impl->Await();
  impl->slam.Resume(parameters.match.start);
  Slam loaded;
  loaded.impl_ = std::move(impl);
  return loaded;
}

}  // namespace crsm_slam
