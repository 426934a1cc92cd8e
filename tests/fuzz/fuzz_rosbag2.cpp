// Databases of rosbag2. SQLite opens files by their names alone, so they are on a disk that is memory.

#include <filesystem>

#include "bag_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string path = "/dev/shm/crsm_fuzz_" + std::to_string(getpid()) + ".db3";
  std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  crsm::ReadBagFile(path);
  std::filesystem::remove(path);
  return 0;
}
