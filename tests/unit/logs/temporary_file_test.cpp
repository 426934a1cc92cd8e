#include "common/logs/temporary_file.hpp"

#include <stdexcept>
#include <vector>

#include "catch.hpp"

namespace crsm {
namespace {

std::vector<std::uint8_t> Read(const TemporaryFile& file, std::uint64_t offset, std::size_t size) {
  std::vector<std::uint8_t> bytes(size);
  file.Read(offset, bytes);
  return bytes;
}

}  // namespace

TEST_CASE("what was appended is read back, whether it is on the disk already or not") {
  TemporaryFile file;
  std::vector<std::uint8_t> all;
  for (int piece = 0; piece < 3000; ++piece) {
    const std::vector<std::uint8_t> bytes(static_cast<std::size_t>(piece % 40), static_cast<std::uint8_t>(piece));
    file.Append(bytes);
    all.insert(all.end(), bytes.begin(), bytes.end());
    if (piece % 500 == 0) CHECK(Read(file, 0, all.size()) == all);
  }
  CHECK(file.size() == all.size());
  CHECK(Read(file, 0, all.size()) == all);
  CHECK(Read(file, 20000, 10) == std::vector<std::uint8_t>(all.begin() + 20000, all.begin() + 20010));
  CHECK(Read(file, all.size(), 0).empty());
  CHECK_THROWS_AS(Read(file, all.size() - 1, 2), std::runtime_error);
}

TEST_CASE("a file takes its bytes along when it is moved") {
  TemporaryFile file;
  file.Append(std::vector<std::uint8_t>{1, 2, 3});
  TemporaryFile other = std::move(file);
  CHECK(Read(other, 1, 2) == std::vector<std::uint8_t>{2, 3});
  other = TemporaryFile();
  CHECK(other.size() == 0);
}

}  // namespace crsm
