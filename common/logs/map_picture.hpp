#pragma once

#include <filesystem>
#include <string>

namespace crsm {

// Who reads a map reads map.yaml first, and then the picture that it names. He gets both of one map whenever he does
// so, because no picture is replaced while map.yaml names it: as long as a run writes its map again and again, map.yaml
// names a file map.N.png beside map.png, with another number each time.

/// The name of the picture of a map that nobody writes any more.
inline constexpr const char* kMapPicture = "map.png";

/// Whether a file is called map.N.png, with a number of up to nine digits.
bool IsNumberedPicture(const std::string& name);

/// The picture that map.yaml in `dir` names, if its name is kMapPicture or numbered; else kMapPicture.
std::string FindPicture(const std::filesystem::path& dir);

/// A numbered name larger than those of the files in `dir`.
std::string NameNextPicture(const std::filesystem::path& dir);

/// Makes map.png free to be replaced: where map.yaml names it, both get a numbered copy, and who has read map.yaml
/// before that gets a tenth of a second to open map.png. Throws std::runtime_error if it cannot be written.
void FreeMapPicture(const std::filesystem::path& dir);

/// Removes numbered pictures but `kept` and the one that map.yaml names.
void RemoveOldPictures(const std::filesystem::path& dir, const std::string& kept = "");

}  // namespace crsm
