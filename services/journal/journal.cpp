#include "services/journal/journal.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "common/logs/crc32.hpp"
#include "common/logs/regular_file.hpp"
#include "services/base/identity.hpp"
#include "services/base/say.hpp"
#include "services/base/version.hpp"
#include "services/journal/journal_reader.hpp"
#include "services/wire/channels.hpp"
#include "services/wire/conversions.hpp"
#include "services/wire/graph_messages.hpp"
#include "services/wire/lcm_event.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

/// A localization says on which map it is as if that were a parameter.
constexpr const char* kFinishedMapName = "finished_map_name";

JournalHead FromMessage(const journal_head_t& message) {
  JournalHead head{message.epoch, {message.finished_map != 0, {}}};
  for (std::size_t i = 0; i < message.parameter_name.size(); ++i) {
    if (message.parameter_name[i] == kFinishedMapName) {
      head.subject.finished_map_name = message.parameter_value[i];
    } else {
      head.subject.parameters.emplace_back(message.parameter_name[i], message.parameter_value[i]);
    }
  }
  return head;
}

journal_head_t ToMessage(const JournalHead& head, std::int64_t utime) {
  journal_head_t message{};
  message.utime = utime;
  message.epoch = head.epoch;
  message.finished_map = head.subject.finished_map;
  message.version = kVersion;
  ParameterTexts texts = head.subject.parameters;
  if (!head.subject.finished_map_name.empty()) texts.emplace_back(kFinishedMapName, head.subject.finished_map_name);
  message.num_parameters = static_cast<std::int32_t>(texts.size());
  for (const auto& [name, value] : texts) {
    message.parameter_name.push_back(name);
    message.parameter_value.push_back(value);
  }
  return message;
}

void CheckSubject(const std::string& path, const JournalSubject& found, const JournalSubject& wanted) {
  if (found.finished_map != wanted.finished_map) {
    throw std::runtime_error(
        wanted.finished_map
            ? fmt::format(
                  "{} belongs to a run that made a map: choose another folder for the journal of a localization", path)
            : fmt::format("{} belongs to a run that localised on the map of another folder: give that folder", path));
  }
  const std::string& other_map = found.finished_map_name;
  if (!wanted.finished_map_name.empty() && !other_map.empty() && other_map != wanted.finished_map_name) {
    throw std::runtime_error(fmt::format(
        "{}: its run localises on another map ({}) than the one that --localize names now ({}): the map was "
        "replaced, or was continued: begin a new run",
        path, other_map, wanted.finished_map_name));
  }
  for (const auto& [key, other, value] : FindDifferences(found.parameters, wanted.parameters)) {
    throw std::runtime_error(fmt::format("{}: its map was made with {} = {}, not with {}", path, key, other, value));
  }
}

/// Whether the file begins as a journal does: anything else is somebody's other file, and not to be cut.
bool BeginsAsJournal(JournalReader& reader) {
  std::string begin;
  AppendEventHeader({0, 0, kJournalHeadChannel}, 0, begin);
  const std::string_view start = reader.Start(begin.size());
  const auto PartOf = [](std::string_view bytes, std::size_t from, std::size_t to) {
    return bytes.substr(std::min(from, bytes.size()), to - from);
  };
  constexpr std::size_t kNumberEnd = 12;  // sync word and number; then come a time, which may be any, and lengths
  return PartOf(start, 0, kNumberEnd) == std::string_view(begin).substr(0, std::min(start.size(), kNumberEnd)) &&
         PartOf(start, kEventHeaderBytes, begin.size()) ==
             std::string_view(begin).substr(kEventHeaderBytes,
                                            std::max(start.size(), kEventHeaderBytes) - kEventHeaderBytes);
}

/// What was read of a journal besides its entries.
struct Contents {
  std::optional<JournalHead> head;
  std::uint64_t whole_bytes = 0;
  std::int64_t num_events = 0;
  std::int64_t last_utime = 0;
  std::optional<KeyframeId> searched;
  bool keep_beside = false;  ///< what follows the whole bytes has more than a torn end
  std::string notice;
};

/// Says of what follows the whole stretches what is to be said; refuses what may not be passed over.
void JudgeRest(const std::string& path, JournalReader& reader, std::int64_t num_scans, OnDamage on_damage,
               Contents& contents) {
  const std::uint64_t num_bytes = reader.size() - reader.whole_bytes();
  if (num_bytes == 0) {
    if (!reader.ended_in_order()) {
      contents.notice = fmt::format("{}: its last session ended unexpectedly; {} scans are complete", path, num_scans);
    }
    return;
  }
  const JournalReader::Rest rest = reader.ExamineRest();
  const std::string place = fmt::format("at byte {} (event {})", reader.whole_bytes(), reader.num_events());
  if (reader.whole_bytes() == 0 && !rest.all_zero && !rest.was_on_disk && !BeginsAsJournal(reader)) {
    throw std::runtime_error(fmt::format("{} is no journal: choose another folder", path));
  }
  if (rest.is_of_other_types) {
    throw std::runtime_error(
        fmt::format("{}: journal of an older version of the programs: map the log anew, into another folder", path));
  }
  if (rest.was_on_disk && on_damage == OnDamage::kRefuse) {
    throw std::runtime_error(
        fmt::format("{} is damaged {}, after its first {} scans: --until-damage uses these scans, and keeps the "
                    "damaged file or a copy of it",
                    path, place, num_scans));
  }
  contents.keep_beside = rest.was_on_disk || rest.num_stretches > 0;
  contents.notice =
      fmt::format("{}: {} {}: the last {} bytes are left out; {} scans remain", path,
                  rest.was_on_disk ? "damaged" : "torn by a power cut or a kill", place, num_bytes, num_scans);
}

Contents Read(const std::string& path, const JournalSubject& subject, OnDamage on_damage, const VisitJournal& visit) {
  JournalReader reader(path);
  Contents contents;
  std::int64_t num_scans = 0;
  GraphUpdateParts parts;
  while (const auto stretch = reader.Next()) {
    if (stretch->head) {
      contents.head = FromMessage(*stretch->head);
      CheckSubject(path, contents.head->subject, subject);
      visit.head(*contents.head);
    }
    if (stretch->graph) {
      const bool changed = stretch->graph->changed == 1;
      const auto update = changed ? parts.Add(*stretch->graph) : std::nullopt;
      const KeyframeId keyframe = FromMessage(stretch->graph->keyframe);
      if (!changed || update) contents.searched = keyframe;
      if (changed ? update && !visit.update(*update) : !visit.searched(keyframe)) {
        ThrowLoopsDoNotFit(path);
      }
    }
    if (stretch->mark && !visit.mark(FromMessage(*stretch->mark))) {
      throw std::runtime_error(fmt::format("{}: its marks do not fit its scans", path));
    }
    if ((stretch->fleet_keyframe && !visit.fleet_keyframe(*stretch->fleet_keyframe)) ||
        (stretch->fleet_marks && !visit.fleet_marks(*stretch->fleet_marks))) {
      throw std::runtime_error(
          fmt::format("{} is the journal of a fleet, and not of one robot, or its keyframes do not fit each other: "
                      "choose another folder",
                      path));
    }
    if (stretch->fleet_keyframe) ++num_scans;
    if (!stretch->match) continue;
    visit.match(stretch->scan ? &*stretch->scan : nullptr, *stretch->match);
    ++num_scans;
  }
  contents.whole_bytes = reader.whole_bytes();
  contents.num_events = reader.num_events();
  contents.last_utime = reader.last_utime();
  JudgeRest(path, reader, num_scans, on_damage, contents);
  return contents;
}

/// Of the map in a folder of results; empty where its summary.json does not say it.
std::string ReadIdentity(const fs::path& results) {
  try {
    const auto json = nlohmann::json::parse(ReadWholeFile(results / "summary.json"), nullptr, false);
    const auto found = json.is_object() ? json.find("identity") : json.end();
    return found != json.end() && found->is_string() ? found->get<std::string>() : "";
  } catch (const std::runtime_error&) {  // there is none
    return "";
  }
}

/// Copies a file as a whole: a copy that was cut short, by a power cut too, does not bear its name.
void CopyWhole(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::path half = to;
  half += ".tmp";
  fs::create_directories(to.parent_path(), error);
  if (!error) fs::copy_file(from, half, fs::copy_options::overwrite_existing, error);
  if (!error)
    fs::permissions(half, fs::perms::owner_write, fs::perm_options::add, error);  // of a copy of a finished map
  if (!error) JournalFile(half.string(), fs::file_size(half)).Sync();
  if (!error) fs::rename(half, to, error);
  if (error) {
    throw std::runtime_error(fmt::format("{} cannot be copied to {}: {}", from.string(), to.string(), error.message()));
  }
  SyncFolder(to.parent_path().string());
}

/// Keeps a damaged journal under a name that no file has yet, and returns it.
fs::path KeepBeside(const fs::path& path) {
  fs::path beside = path;
  beside += ".damaged";
  for (int number = 2; fs::exists(beside); ++number) beside = path.string() + fmt::format(".damaged{}", number);
  CopyWhole(path, beside);
  return beside;
}

}  // namespace

Journal::Journal(const fs::path& folder, const JournalSubject& subject, std::int64_t epoch)
    : subject_(subject), epoch_(epoch) {
  const fs::path path = JournalPath(folder);
  if (fs::exists(path)) {
    throw std::runtime_error(
        fmt::format("{} exists already: continue it with --resume, or choose another folder", path.string()));
  }
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    throw std::runtime_error(fmt::format("--journal {}: cannot be written: {}", folder.string(), error.message()));
  }
  file_ = std::make_unique<JournalFile>(path.string(), 0);
}

Journal::Journal(const fs::path& folder, const JournalSubject& subject, OnDamage on_damage, const VisitJournal& visit)
    : subject_(subject) {
  const fs::path path = JournalPath(folder);
  const Contents contents = Read(path.string(), subject, on_damage, visit);
  head_written_ = contents.head.has_value();
  epoch_ = head_written_ ? contents.head->epoch : DrawIdentity();
  num_events_ = contents.num_events;
  last_utime_ = contents.last_utime;
  searched_ = contents.searched;
  notice_ = contents.notice;
  if (contents.keep_beside) notice_ += fmt::format("; the original file is now {}", KeepBeside(path).string());
  file_ = std::make_unique<JournalFile>(path.string(), contents.whole_bytes);
}

void Journal::Finish() {
  if (std::exchange(finished_, true)) return;
  if (to_be_kept_) WriteSearched();
  if (!appended_) return;
  file_->Sync();
  WriteStretch(last_utime_);
  file_->Sync();
}

Journal::~Journal() {
  try {
    Finish();
  } catch (const std::runtime_error& error) {
    Say(error.what());
  }
}

template <class Message>
void Journal::AddEvent(const char* channel, const Message& message) {
  const auto num_bytes = static_cast<std::size_t>(message.getEncodedSize());
  AppendEventHeader({num_events_++, last_utime_, channel}, num_bytes, stretch_);
  const std::size_t at = stretch_.size();
  stretch_.resize(at + num_bytes);
  message.encode(stretch_.data(), static_cast<int>(at), static_cast<int>(num_bytes));
}

void Journal::Append(const CriticalRays* scan, const ScanMatch& match) {
  last_utime_ = std::max(last_utime_, match.utime);  // lcm-logplayer does not go back in time
  AddHead(match.utime);
  if (scan) AddEvent(kCriticalRaysChannel, ToMessage(*scan));
  AddEvent(kScanMatchChannel, ToMessage(match));
  WriteStretch(match.utime);
  appended_ = true;
  if (scan) ++num_drawn_;
}

void Journal::AddHead(std::int64_t utime) {
  if (!std::exchange(head_written_, true)) AddEvent(kJournalHeadChannel, ToMessage({epoch_, subject_}, utime));
}

template <class Message>
void Journal::AppendAlone(const char* channel, const Message& message) {
  AddHead(last_utime_);
  AddEvent(channel, message);
  WriteStretch(last_utime_);
  appended_ = true;
}

void Journal::Append(const FixedMark& mark) { AppendAlone(kKeptMarkChannel, ToMessage(mark)); }

void Journal::Append(const fleet_keyframe_t& keyframe) {
  last_utime_ = std::max(last_utime_, keyframe.heard_utime);
  AppendAlone(kFleetKeyframeChannel, keyframe);
}

void Journal::Append(const fleet_marks_t& marks) { AppendAlone(kFleetMarksChannel, marks); }

void Journal::Append(const GraphUpdate& update, std::int64_t utime) {
  for (const pose_graph_t& part : MakeParts(update, utime, epoch_)) {
    AddEvent(kPoseGraphChannel, part);
    WriteStretch(last_utime_);
  }
  appended_ = true;
  searched_ = update.keyframe;
  to_be_kept_.reset();
  num_drawn_ = 0;
}

void Journal::AppendSearched(KeyframeId keyframe, std::optional<KeyframeId> last_update, std::int64_t utime) {
  constexpr int kDrawnBetween = 10;
  if (keyframe <= searched_) return;
  searched_ = keyframe;
  to_be_kept_ = MakeUnchanged(keyframe, last_update, utime, epoch_);
  if (num_drawn_ >= kDrawnBetween) WriteSearched();
}

void Journal::WriteSearched() {
  AddEvent(kPoseGraphChannel, *to_be_kept_);
  WriteStretch(last_utime_);
  appended_ = true;
  to_be_kept_.reset();
  num_drawn_ = 0;
}

/// Writes what was added, with its check.
void Journal::WriteStretch(std::int64_t utime) {
  journal_check_t check{};
  check.utime = utime;
  check.first_byte = static_cast<std::int64_t>(file_->size());
  check.num_bytes = static_cast<std::int32_t>(stretch_.size());
  check.synced_bytes = static_cast<std::int64_t>(file_->synced_bytes());
  AddEvent(kJournalCheckChannel, check);
  const std::size_t covered = stretch_.size() - kCrcBytes;
  const std::uint32_t crc = Crc32(std::string_view(stretch_).substr(0, covered));
  for (std::size_t i = 0; i < kCrcBytes; ++i) stretch_[covered + i] = static_cast<char>(crc >> (24 - 8 * i) & 0xff);
  file_->Append(stretch_);
  stretch_.clear();
}

std::string NameMap(std::int64_t epoch, std::int64_t num_scans) {
  return fmt::format("{} of {} scans", FormatIdentity(epoch), num_scans);
}

std::string ReadJournal(const fs::path& folder, const JournalSubject& subject, OnDamage on_damage,
                        const VisitJournal& visit) {
  return Read(JournalPath(folder).string(), subject, on_damage, visit).notice;
}

std::optional<JournalHead> ReadHead(const fs::path& folder) {
  JournalReader reader(JournalPath(folder).string());
  const auto first = reader.Next();
  return first ? std::optional(FromMessage(*first->head)) : std::nullopt;
}

bool IsOfAnotherMap(const fs::path& folder, const std::string& identity) {
  std::error_code error;
  if (!fs::exists(JournalPath(folder), error)) return false;
  try {
    const auto head = ReadHead(folder);
    return head && FormatIdentity(head->epoch) != identity;
  } catch (const std::runtime_error&) {
    return true;
  }
}

void CheckAreOfOneMap(const fs::path& results) {
  const std::string identity = ReadIdentity(results);
  if (identity.empty() || !IsOfAnotherMap(JournalFolder(results), identity)) return;
  throw std::runtime_error(fmt::format(
      "{0}: its summary.json is of another map than its journal: put the right journal back into {0}, or map "
      "the log anew into another folder",
      results.string()));
}

bool IsCovered(const fs::path& folder, std::int64_t epoch, std::span<const ScanMatch> matches) {
  std::size_t num_matches = 0;
  try {
    JournalReader reader(JournalPath(folder).string());
    while (const auto stretch = reader.Next()) {
      if (stretch->head && (stretch->head->epoch != epoch || stretch->head->finished_map != 0)) return false;
      if (!stretch->match) continue;
      if (num_matches == matches.size()) return false;
      const ScanMatch& match = matches[num_matches++];
      if (match.utime != stretch->match->utime || match.T_map_laser != stretch->match->T_map_laser) return false;
    }
    return num_matches > 0 && reader.whole_bytes() == reader.size();
  } catch (const std::runtime_error&) {
    return false;
  }
}

void TakeOverJournal(const fs::path& earlier, const fs::path& out) {
  const fs::path from = JournalPath(JournalFolder(earlier));
  const fs::path to = JournalPath(JournalFolder(out));
  std::error_code error;
  if (!fs::exists(from, error)) throw std::runtime_error(fmt::format("there is no file {}", from.string()));
  if (!fs::equivalent(from, to, error)) CopyWhole(from, to);
}

ParameterTexts ListTexts(const Parameters& parameters, const std::vector<ParameterGroup>& groups) {
  ParameterTexts texts;
  for (const auto& [key, value] : ListParameters(parameters, groups)) texts.emplace_back(key, FormatValue(value));
  return texts;
}

ParameterTexts ListMapParameters(const Parameters& parameters) {
  using enum ParameterGroup;
  return ListTexts(parameters, {kLaser, kScan, kUpdate, kLoops, kAlgorithm});
}

std::vector<ParameterDifference> FindDifferences(const ParameterTexts& found, const ParameterTexts& wanted) {
  std::vector<ParameterDifference> differences;
  for (const auto& [key, value] : wanted) {
    const auto other = std::ranges::find(found, key, &ParameterTexts::value_type::first);
    if (other != found.end() && other->second != value) differences.push_back({key, other->second, value});
  }
  return differences;
}

void ThrowLoopsDoNotFit(const fs::path& journal) {
  throw std::runtime_error(fmt::format("{}: its loop closures do not fit its scans", journal.string()));
}

void RemoveHalfJournal(const fs::path& out) {
  std::error_code error;
  fs::remove(JournalPath(HalfJournalFolder(out)), error);
  fs::remove(HalfJournalFolder(out), error);
}

void RemoveJournal(const fs::path& out) { fs::remove(JournalPath(JournalFolder(out))); }

}  // namespace crsm
