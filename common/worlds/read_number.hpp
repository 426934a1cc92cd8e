#pragma once

#include <string>

namespace crsm {

/// A number in a world file or in a world's name: what it is called, and its range.
struct Field {
  const char* name;
  double min;
  double max;
};

/// The number that a word is. Throws std::runtime_error if it is none, or out of the field's range.
/// place: file:line. key: of the line.
double ReadNumber(const std::string& place, const std::string& key, const Field& field, const std::string& word);

}  // namespace crsm
