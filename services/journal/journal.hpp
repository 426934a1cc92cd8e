#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/graph/keyframe_graph.hpp"
#include "common/marks/mark.hpp"
#include "common/parameters.hpp"
#include "common/scan/critical_rays.hpp"
#include "common/scan/scan_match.hpp"
#include "services/base/identity.hpp"
#include "services/journal/journal_file.hpp"
#include "services/wire/wire.hpp"

namespace crsm {

/// Parameters by their keys, each as a flag says it.
using ParameterTexts = std::vector<std::pair<std::string, std::string>>;
ParameterTexts ListTexts(const Parameters& parameters, const std::vector<ParameterGroup>& groups);

/// The parameters that a map is made with: which readings are measurements and where they point, and how they are
/// drawn. How poses are searched is none of them, and may change from session to session.
ParameterTexts ListMapParameters(const Parameters& parameters);

/// A parameter that two lists have with different values.
struct ParameterDifference {
  std::string key;
  std::string found;
  std::string wanted;
};
/// All of them, in the order of `wanted`.
std::vector<ParameterDifference> FindDifferences(const ParameterTexts& found, const ParameterTexts& wanted);

/// What a journal is to be of; one of something else is refused.
struct JournalSubject {
  bool finished_map = false;  ///< localization on the map of another journal; else the map is made of this one
  ParameterTexts parameters;  ///< of the map: ListMapParameters
  /// Of a localization: which map it is on, as of NameMap. Empty where that is not to be compared, and in a journal of
  /// version 0.2.0.
  std::string finished_map_name = {};
};

/// What a journal says of itself at its beginning.
struct JournalHead {
  std::int64_t epoch = 0;
  JournalSubject subject;
};

/// A map as it is now, by its identity and the number of its scans: one that goes on is another one.
std::string NameMap(std::int64_t epoch, std::int64_t num_scans);

/// Called for the entries of a journal, in their order.
struct VisitJournal {
  /// A match; the scan is nullptr where it was not drawn.
  std::function<void(const CriticalRays* scan, const ScanMatch& match)> match;
  /// What loops have brought to the graph, in a journal of a run with loops. False if it does not fit the scans before.
  std::function<bool(const GraphUpdate& update)> update = [](const GraphUpdate&) { return true; };
  /// Loops were searched up to a keyframe. False if there is no such keyframe.
  std::function<bool(KeyframeId keyframe)> searched = [](KeyframeId) { return true; };
  /// What the journal says of itself.
  std::function<void(const JournalHead& head)> head = [](const JournalHead&) {};
  /// A keyframe of a fleet's map. False if the journal is not to be of a fleet, or if it does not fit those before.
  std::function<bool(const fleet_keyframe_t& keyframe)> fleet_keyframe = [](const fleet_keyframe_t&) { return false; };
  /// The places of one of a fleet's maps. False likewise.
  std::function<bool(const fleet_marks_t& marks)> fleet_marks = [](const fleet_marks_t&) { return false; };
  /// A place with a name. False if it does not fit the scans before.
  std::function<bool(const FixedMark& mark)> mark = [](const FixedMark&) { return true; };
};

/// What a journal is refused with where `update` or `searched` is false. Throws std::runtime_error that names it.
[[noreturn]] void ThrowLoopsDoNotFit(const std::filesystem::path& journal);

/// What to do about a journal that is damaged in the middle, by a bad disk say, and not torn at its end by a power cut.
enum class OnDamage {
  kRefuse,
  kTakeWhatIsBefore,
};

/// Everything that a map is made of, on the disk as it happens: FOLDER/journal.lcm, an LCM log that lcm-logplayer and
/// lcm-spy read too. First the head (JOURNAL_HEAD), then for every match the scan (CRITICAL_RAYS) if it was drawn, and
/// the match (SCAN_MATCH), and between them, with loops, what was found, what that has brought to the graph, and up to
/// which keyframe loops were searched (POSE_GRAPH, part by part), and places with names (KEPT_MARK); behind each of
/// these a check (JOURNAL_CHECK) with a checksum of all bytes since the last one. That of a fleet has a keyframe
/// (FLEET_KEYFRAME) in the place of each match, and the places of each robot's map (FLEET_MARKS). A process that is
/// killed loses nothing that was kept, a power cut the last second.
class Journal {
 public:
  /// Begins a new journal, of a new epoch or of that of a map which is there already. Throws std::runtime_error if
  /// there is one already, or if it cannot be written.
  Journal(const std::filesystem::path& folder, const JournalSubject& subject, std::int64_t epoch = DrawIdentity());

  /// Reads the journal in `folder` from its beginning, then goes on writing at its end. What was torn there is cut off;
  /// so is what follows a damage, if that is allowed, and the file as it was is kept beside. Throws std::runtime_error
  /// if there is no journal, if it is damaged, of another subject or of an older version, or if it cannot be written.
  Journal(const std::filesystem::path& folder, const JournalSubject& subject, OnDamage on_damage,
          const VisitJournal& visit);

  /// Does what Finish does, if that was not called; what goes wrong then is said on stderr.
  ~Journal();

  /// Writes through to the disk, and that the session ended in order. Nothing can be appended afterwards. Throws
  /// std::runtime_error if it cannot be written.
  void Finish();

  /// Of the map: drawn by who began the journal.
  std::int64_t epoch() const { return epoch_; }

  /// In one line, what was wrong with the journal that was read; empty if nothing was.
  const std::string& notice() const { return notice_; }

  /// Keeps one match, and its scan where it was drawn (else nullptr), handed to the operating system when this returns:
  /// it survives the end of the process, and within a second also a power cut. Throws std::runtime_error if it cannot
  /// be written.
  void Append(const CriticalRays* scan, const ScanMatch& match);

  /// Keeps what loops have brought to the graph, in the same way: it was known before the next match. utime: of its
  /// keyframe.
  void Append(const GraphUpdate& update, std::int64_t utime);

  /// Keeps a place with a name, in the same way.
  void Append(const FixedMark& mark);

  /// Keeps a keyframe of a fleet's map, in the same way: its scan as well.
  void Append(const fleet_keyframe_t& keyframe);

  /// Keeps the places of one of a fleet's maps, in the same way.
  void Append(const fleet_marks_t& marks);

  /// Keeps that loops were searched up to a keyframe, and that nothing was found since the update of `last_update`. It
  /// is written where the session ends, and before that for every tenth drawn scan: if the process is killed, those
  /// that came since are searched once more. utime: of the keyframe.
  void AppendSearched(KeyframeId keyframe, std::optional<KeyframeId> last_update, std::int64_t utime);

 private:
  template <class Message>
  void AddEvent(const char* channel, const Message& message);
  void AddHead(std::int64_t utime);
  /// A message that has a stretch of its own.
  template <class Message>
  void AppendAlone(const char* channel, const Message& message);
  void WriteSearched();
  void WriteStretch(std::int64_t utime);

  JournalSubject subject_;
  std::int64_t epoch_;
  bool head_written_ = false;
  bool appended_ = false;  ///< in this session
  bool finished_ = false;
  std::optional<KeyframeId> searched_;      ///< of it and those before it no more is to be kept
  std::optional<pose_graph_t> to_be_kept_;  ///< says so
  int num_drawn_ = 0;                       ///< scans, since that was written
  std::int64_t num_events_ = 0;
  std::int64_t last_utime_ = 0;
  std::string notice_;
  std::string stretch_;  ///< bytes that are to be written at once
  std::unique_ptr<JournalFile> file_;
};

/// Reads a journal and leaves it as it is. Returns what Journal::notice would say. Throws as the second constructor.
std::string ReadJournal(const std::filesystem::path& folder, const JournalSubject& subject, OnDamage on_damage,
                        const VisitJournal& visit);

/// The head of the journal in `folder`; nothing if the journal is empty, or torn before its first scan was kept. Throws
/// std::runtime_error if there is no such file, or if it is no journal.
std::optional<JournalHead> ReadHead(const std::filesystem::path& folder);

/// Whether the journal in `folder` is of another map than that of this identity, as of FormatIdentity, or is no journal
/// that can be read. False where there is none, or an empty one.
bool IsOfAnotherMap(const std::filesystem::path& folder, const std::string& identity);

/// Throws std::runtime_error that names the folder of results where its summary.json is of another map than the journal
/// beside it: results of two places were mixed.
void CheckAreOfOneMap(const std::filesystem::path& results);

/// Whether the journal in `folder` is of the map of that epoch, and has nothing but the first of its matches, in their
/// order. Not where there is none, or where a byte of it cannot be read.
bool IsCovered(const std::filesystem::path& folder, std::int64_t epoch, std::span<const ScanMatch> matches);

/// Where run_stack and slam_offline keep the journal of a folder of results.
inline std::filesystem::path JournalFolder(const std::filesystem::path& out) { return out / "journal"; }

/// The journal in its folder.
inline std::filesystem::path JournalPath(const std::filesystem::path& folder) { return folder / "journal.lcm"; }

/// Makes `out` the folder in which the map of `earlier` goes on: its journal is copied, unless they are the same
/// folder. Throws std::runtime_error if there is none, or if it cannot be copied.
void TakeOverJournal(const std::filesystem::path& earlier, const std::filesystem::path& out);

/// Makes room for a new journal in a folder of results.
void RemoveJournal(const std::filesystem::path& out);

/// The folder of a journal that is written for a folder of results as a whole, and takes the place of that which is
/// there when it is done.
inline std::filesystem::path HalfJournalFolder(const std::filesystem::path& out) { return out / "journal.tmp"; }

/// Removes what is there, of a process that was killed.
void RemoveHalfJournal(const std::filesystem::path& out);

}  // namespace crsm
