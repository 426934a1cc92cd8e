#include "services/sources/unpacker.hpp"

#include <cstdlib>

#include "catch.hpp"
#include "packed.hpp"
#include "services/sources/open_laser_source.hpp"
#include "services/sources/unpacked_file.hpp"
#include "source_helpers.hpp"

using namespace crsm;

namespace {

struct Result {
  std::string text;
  Unpacker::State state = Unpacker::State::kGoesOn;
};

/// Through pieces of some bytes, as they come from a disk.
Result Unpack(const std::string& compression, const std::string& packed, std::size_t piece_bytes) {
  const auto unpacker = MakeUnpacker(compression);
  Result result;
  for (std::size_t at = 0; at < packed.size() && result.state != Unpacker::State::kDamaged; at += piece_bytes) {
    std::string_view piece = std::string_view(packed).substr(at, piece_bytes);
    for (bool goes_on = true; goes_on && result.state != Unpacker::State::kDamaged;) {
      std::string buffer(1000, '\0');
      std::span<char> to(buffer);
      const std::size_t before = piece.size();
      result.state = unpacker->Go(piece, to);
      result.text += buffer.substr(0, buffer.size() - to.size());
      goes_on = to.size() < buffer.size() || piece.size() < before;
    }
  }
  return result;
}

/// Numbers, of which no compression makes next to nothing.
std::string Text() {
  std::string text;
  for (unsigned i = 0, number = 1; i < 20'000; ++i, number = number * 1664525u + 1013904223u) {
    text += std::to_string(number >> 16) + " ";
  }
  return text;
}

std::string CarmenLines() {
  std::string log;
  for (int i = 0; i < 300; ++i) log += "FLASER 3 1.5 2.5 3.5 0 0 0 0 0 0 " + std::to_string(i) + ".5 host 0\n";
  return log;
}

}  // namespace

TEST_CASE("what any compression has packed comes back, in one stream or several, in pieces of any size") {
  const std::string text = Text();
  for (const std::string compression : kCompressionNames) {
    CAPTURE(compression);
    const std::string packed = Pack(compression, text);
    REQUIRE(packed.size() < text.size());
    CHECK(FindCompression(packed) == compression);
    for (const std::size_t piece_bytes : {std::size_t{7}, std::size_t{4096}, packed.size()}) {
      const Result result = Unpack(compression, packed, piece_bytes);
      CHECK(result.text == text);
      CHECK(result.state == Unpacker::State::kWhole);
    }
    CHECK(Unpack(compression, packed + Pack(compression, "more"), 4096).text == text + "more");

    CHECK(Unpack(compression, packed + "more", 4096).state != Unpacker::State::kWhole);
    if (compression != "lz4" && compression != "zstd") {
      const std::string filled = packed + std::string(4096, '\0');
      CHECK(Unpack(compression, filled, 1000).state == Unpacker::State::kWhole);
      CHECK(Unpack(compression, filled + Pack(compression, "more"), 1000).text == text + "more");
    }

    const Result cut = Unpack(compression, packed.substr(0, packed.size() * 3 / 4), 4096);
    CHECK(text.starts_with(cut.text));
    CHECK(cut.state != Unpacker::State::kWhole);
    std::string damaged = packed;
    for (std::size_t i = 0; i < 32; ++i) damaged[packed.size() / 2 + i] ^= 0x55;
    const Result wrong = Unpack(compression, damaged, 4096);
    CHECK((wrong.state == Unpacker::State::kDamaged || wrong.text != text));
  }
  CHECK(MakeUnpacker("other") == nullptr);
  CHECK(FindCompression("FLASER 2 1 1").empty());
}

TEST_CASE("a log or a bag is read as it is, whatever has compressed it, once or twice, and errors name it") {
  const std::string bag = BytesOf(std::string(CRSM_SOURCE_DIR) + "/tests/bags/data/zstd.mcap");
  const std::string database = BytesOf(std::string(CRSM_SOURCE_DIR) + "/tests/bags/data/run.db3");
  std::string with_log = database;  // as rosbag2 writes it
  with_log[18] = with_log[19] = 2;
  for (const std::string& content : {CarmenLines(), bag, database, with_log}) {
    const ScratchFile plain(content);
    const auto scans = ReadAll(*OpenLaserSource(plain.path(), {}));
    REQUIRE(scans.size() >= 3);
    for (const std::string compression : kCompressionNames) {
      CAPTURE(compression);
      const ScratchFile packed(Pack(compression, content));
      CHECK(ReadAll(*OpenLaserSource(packed.path(), {})) == scans);
      CHECK(ReadAll(*OpenLaserSource(packed.path(), {})) == scans);
    }
  }
  for (const std::string compression : kCompressionNames) {
    CAPTURE(compression);
    const ScratchFile no_log(Pack(compression, Text()));
    CHECK(ErrorOf([&] { OpenLaserSource(no_log.path(), {}); }).find(no_log.path() + " is neither a CARMEN log") == 0);
    const ScratchFile damaged(Pack(compression, Text()).substr(0, 12));
    CHECK(ErrorOf([&] { OpenLaserSource(damaged.path(), {}); }).find(damaged.path()) == 0);
  }
}

TEST_CASE("a compressed log that is cut short or damaged is read as far as it goes, and that is counted") {
  const std::string line = CarmenLines().substr(0, 33);  // up to its time
  std::string log;  // of two blocks of bzip2, of which each comes back whole or not at all
  for (int i = 0; i < 30'000; ++i) log += line + std::to_string(i * 7919) + ".5 host 0\n";
  for (const std::string compression : kCompressionNames) {
    CAPTURE(compression);
    const std::string packed = Pack(compression, log);
    const ScratchFile whole(packed);
    const auto all = OpenLaserSource(whole.path(), {});
    const std::size_t num = ReadAll(*all).size();
    CHECK(CountOf(*all, "truncated") == 0);
    const ScratchFile cut(packed.substr(0, packed.size() * 3 / 4));
    const auto some = OpenLaserSource(cut.path(), {});
    const std::size_t num_of_some = ReadAll(*some).size();
    CHECK(num_of_some > num / 2);
    CHECK(num_of_some < num);
    CHECK(CountOf(*some, "truncated") == 1);
  }
}

TEST_CASE("a file that has changed is unpacked again, and what does not fit on the disk is said") {
  const ScratchFile file(Pack("xz", CarmenLines()));
  CHECK(ReadAll(*OpenLaserSource(file.path(), {})).size() == 300);
  std::ofstream(file.path(), std::ios::binary) << Pack("xz", CarmenLines() + CarmenLines().substr(0, 51));
  CHECK(ReadAll(*OpenLaserSource(file.path(), {})).size() == 301);

  const ScratchFile other(Pack("xz", CarmenLines()));
  const char* const before = std::getenv("TMPDIR");
  const std::string kept = before ? before : "";
  setenv("TMPDIR", "/proc", 1);
  CHECK(ErrorOf([&] { OpenLaserSource(other.path(), {}); }).find("TMPDIR names another folder") != std::string::npos);
  before ? setenv("TMPDIR", kept.c_str(), 1) : unsetenv("TMPDIR");
}
