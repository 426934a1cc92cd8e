#include "services/wire/event_log_writer.hpp"

#include <fmt/core.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>

namespace crsm {

EventLogWriter::EventLogWriter(const std::string& path) : path_(path), log_(path, "w") {
  if (!log_.good()) Fail();
}

void EventLogWriter::WriteBytes(const std::string& channel, std::int64_t utime) {
  lcm::LogEvent event{0, clock_.Follow(utime), channel, static_cast<std::int32_t>(bytes_.size()), bytes_.data()};
  if (log_.writeEvent(&event) != 0) Fail();
}

void EventLogWriter::Flush() {
  if (std::fflush(log_.getFilePtr()) != 0) Fail();
}

void EventLogWriter::Fail() const {
  throw std::runtime_error(fmt::format("{}: cannot be written: {}", path_, std::strerror(errno)));
}

}  // namespace crsm
