#pragma once

#include <stdexcept>

namespace crsm {

/// A program was called wrongly: its exit code is 2, where other failures have 1.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace crsm
