// A journal, as map_updater reads it and goes on with it. What it takes is whole: read again, it is the same.

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "services/journal/journal.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  static const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("crsm_fuzz_journal_" + std::to_string(getpid()));
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "journal.lcm", std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  const JournalSubject subject{false, {{"cell_size_m", "0.05"}}};
  int num_scans = 0;
  const VisitJournal count{[&](const CriticalRays*, const ScanMatch&) { ++num_scans; }};
  try {
    ReadHead(folder);
    { Journal journal(folder, subject, OnDamage::kTakeWhatIsBefore, count); }
    const int num_taken = std::exchange(num_scans, 0);
    ReadJournal(folder, subject, OnDamage::kRefuse, count);
    if (num_scans != num_taken) std::abort();
  } catch (const std::runtime_error&) {  // is how a journal is refused
  }
  return 0;
}
