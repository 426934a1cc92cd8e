#include "services/diagnosis/laser_frames.hpp"

#include <fmt/format.h>

#include <vector>

#include "services/base/printable.hpp"

namespace crsm {
namespace {

/// As TF had it once: with a '/' before it.
std::string WithoutSlash(const std::string& frame) { return frame.starts_with('/') ? frame.substr(1) : frame; }

}  // namespace

LaserFrames::LaserFrames(const std::string& wanted) : wanted_(WithoutSlash(wanted)) {}

bool LaserFrames::Take(const std::string& frame) {
  constexpr std::size_t kMostFrames = 20;  // the names are others'
  const std::string name = WithoutSlash(frame);
  ++num_scans_;
  if (frames_.size() < kMostFrames || name == wanted_) frames_.insert(name);
  return wanted_.empty() || name == wanted_;
}

std::string LaserFrames::Complaint() const {
  std::vector<std::string> names;
  for (const std::string& frame : frames_) names.push_back(frame.empty() ? "(no name)" : frame);
  if (wanted_.empty()) {
    return frames_.size() < 2 ? ""
                              : fmt::format("the scans are of several lasers: --laser-frame must name one of {}",
                                            ListPrintable(names));
  }
  if (frames_.empty() || frames_.count(wanted_) > 0) return "";
  if (frames_ == std::set<std::string>{""}) return "the scans name no frame: remove --laser-frame";
  return fmt::format("no scan has the frame {}: --laser-frame must name one of {}", MakePrintable(wanted_),
                     ListPrintable(names));
}

}  // namespace crsm
