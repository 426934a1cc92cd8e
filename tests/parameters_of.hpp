#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "services/settings/command_line.hpp"

namespace crsm {

/// What the programs compute with when they are started with these flags.
inline Parameters ParametersOf(const std::vector<std::string>& flags) {
  using enum ParameterGroup;
  CommandLine command_line("test", "", {kSeed, kLaser, kScan, kSelection, kUpdate, kLoops, kAlgorithm}, {});
  std::vector<const char*> words{"test"};
  for (const std::string& flag : flags) words.push_back(flag.c_str());
  if (command_line.Parse(static_cast<int>(words.size()), words.data())) throw std::runtime_error("flags are refused");
  return command_line.parameters();
}

}  // namespace crsm
