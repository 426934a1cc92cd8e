#pragma once

#include <set>
#include <string>

#include "services/run_stack/member.hpp"

namespace crsm {

/// The map_viewer of a stack. It shows the live robot from before the first scan on. Its port and its token stay the
/// same when it is started again, so that an open page finds it.
class StackViewer {
 public:
  /// Starts it and says where the map is to be seen. Waits until it is ready or has ended, 10 s at most.
  explicit StackViewer(const PlannedService& plan);

  /// To be watched and, if need be, started again.
  Member& member() { return member_; }

  /// Says the addresses that it has said since it was started last, if they are others than before. The next start
  /// takes the same port.
  void SayAddresses();

 private:
  std::string& http();

  Member member_;
  std::set<std::string> said_;  ///< addresses
};

}  // namespace crsm
