#include "services/runtime/match_store.hpp"

#include <vector>

#include "services/runtime/conversions.hpp"

namespace crsm {
namespace {

std::size_t RecordBytes() {
  static const auto kBytes = static_cast<std::size_t>(scan_match_t{}.getEncodedSize());
  return kBytes;
}

ScanMatch DecodeRecord(std::span<const std::uint8_t> record) {
  scan_match_t message;
  message.decode(record.data(), 0, static_cast<int>(record.size()));
  return FromMessage(message);
}

}  // namespace

void MatchStore::Append(const ScanMatch& match) {
  const scan_match_t message = ToMessage(match);
  std::vector<std::uint8_t> record(RecordBytes());
  message.encode(record.data(), 0, static_cast<int>(record.size()));
  file_.Append(record);
  utimes_.Add(match.utime);
  ++size_;
}

ScanMatch MatchStore::At(std::int64_t index) const {
  std::vector<std::uint8_t> record(RecordBytes());
  file_.Read(static_cast<std::uint64_t>(index) * record.size(), record);
  return DecodeRecord(record);
}

std::optional<ScanMatch> MatchStore::Find(std::int64_t utime) const {
  const auto index = utimes_.Find(utime);
  return index ? std::optional(At(*index)) : std::nullopt;
}

MatchSequence MatchStore::Sequence() const {
  return MatchSequence([this](const MatchSequence::Visit& visit) {
    constexpr std::int64_t kAtOnce = 256;
    std::vector<std::uint8_t> records;
    for (std::int64_t first = 0; first < size_; first += kAtOnce) {
      records.resize(static_cast<std::size_t>(std::min(kAtOnce, size_ - first)) * RecordBytes());
      file_.Read(static_cast<std::uint64_t>(first) * RecordBytes(), records);
      for (std::size_t at = 0; at < records.size(); at += RecordBytes()) {
        visit(DecodeRecord(std::span(records).subspan(at, RecordBytes())));
      }
    }
  });
}

}  // namespace crsm
