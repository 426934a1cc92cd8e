#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "services/bus/bus.hpp"
#include "services/bus/multicast_socket.hpp"

namespace crsm {

/// Searches the bus for a laser that is not heard on its channel: hears all channels for a second, and then for one in
/// every five, because it may begin later.
class LaserSearch {
 public:
  using Clock = std::chrono::steady_clock;

  /// bus: outlives this. channel: of the laser, with the bus's prefix.
  LaserSearch(const Bus& bus, std::string channel) : bus_(bus), channel_(std::move(channel)) {}

  /// To be called often while the laser is missed. Of one that was never heard, at the end of the first second: that
  /// nothing came, and what the bus has. Else each channel with a laser that was not named yet, 20 at most.
  std::vector<std::string> Look(bool was_heard, Clock::time_point now);

  /// The laser is not missed now.
  void Rest();

  /// Whether it was said that nothing came.
  bool has_said_so() const { return has_said_so_; }

 private:
  void Listen(Clock::time_point now);
  void Hear();
  std::vector<std::string> Conclude(bool was_heard);
  std::string DescribeBus();
  std::string DescribeMend(const std::string& channel) const;

  const Bus& bus_;
  std::string channel_;
  bool has_said_so_ = false;
  std::set<std::string> named_;  ///< channels with a laser, in what was said

  // While it listens.
  std::unique_ptr<MulticastSocket> all_channels_;  ///< none where the bus is not by multicast
  std::optional<Clock::time_point> until_;
  Clock::time_point next_{};                     ///< when it listens again
  std::map<std::string, std::uint64_t> lasers_;  ///< fingerprints by channel, of a few channels
  std::map<std::string, std::uint64_t> others_;
};

}  // namespace crsm
