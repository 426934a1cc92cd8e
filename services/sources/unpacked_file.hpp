#pragma once

#include <functional>
#include <string>

namespace crsm {

/// A path under which a file is read as it was before it was compressed as a whole by bzip2, gzip, lz4, xz or zstd: its
/// own where it was not; else that of a copy without a name in $TMPDIR, or /var/tmp, which goes with the process. A
/// file is unpacked once in a process. A stream that is cut short is unpacked as far as it goes.
///
/// say: gets a line where it takes long. Throws std::runtime_error, one line, if the file cannot be read, holds
/// nothing, or does not fit, and when the process is asked to end.
std::string PathOfUnpacked(const std::string& path, const std::function<void(const std::string&)>& say);

/// Whether a file that PathOfUnpacked has unpacked was so to its end: not where it is cut short or damaged.
bool IsUnpackedWhole(const std::string& path);

/// The copy of a file goes when nobody reads it any more.
void ForgetUnpacked(const std::string& path);

/// Errors about such a copy are to name the file: the path of a copy in a text becomes that of its file.
std::string NameUnpacked(std::string text);

}  // namespace crsm
