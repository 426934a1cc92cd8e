#pragma once

#include <sys/types.h>

#include <cstddef>
#include <filesystem>
#include <string>

namespace crsm {

/// A descriptor of a regular file, opened with `flags` as open takes them; the caller closes it. A FIFO would let the
/// process wait for ever, and a device has no end: throws std::runtime_error "cannot read PATH: ..." or "cannot write
/// PATH: ..." for all that is no regular file, or cannot be opened.
int OpenRegularFile(const std::filesystem::path& path, int flags, mode_t mode = 0666);

/// The whole of a regular file. Throws std::runtime_error "cannot read PATH: ...", also if it has more than
/// `most_bytes`.
std::string ReadWholeFile(const std::filesystem::path& path, std::size_t most_bytes = std::size_t{1} << 26);

}  // namespace crsm
