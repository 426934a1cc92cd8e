#include "services/bus/sole_sender.hpp"

#include <arpa/inet.h>
#include <fmt/core.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

namespace crsm {

std::string Sender::Describe() const {
  if (!known()) return "an unknown sender";
  std::array<char, INET_ADDRSTRLEN> text{};
  const in_addr network{address};
  inet_ntop(AF_INET, &network, text.data(), text.size());
  return fmt::format("{}:{}", text.data(), port);
}

SoleSender::SoleSender(std::chrono::milliseconds probation, Lives lives)
    : probation_(probation), lives_(std::move(lives)) {}

SoleSender::Verdict SoleSender::Judge(const Sender& sender, Clock::time_point now, bool heard) {
  if (Candidate* known = Find(sender); known && heard) known->last_heard = now;
  if (believed_ && candidates_.front().sender == sender) return Verdict::kBelieved;
  DropDead(now);
  if (believed_ && now - alone_since_ >= kYoung) return Verdict::kRefused;
  believed_ = false;
  if (!Find(sender)) {
    constexpr std::size_t kMost = 16;  // more change nothing: there are too many already
    if (!heard || candidates_.size() == kMost) return Verdict::kRefused;
    candidates_.push_back({sender, now});
    alone_since_ = now;
  }
  if (candidates_.size() > 1) return Verdict::kRefused;
  believed_ = now - alone_since_ >= probation_;
  return believed_ ? Verdict::kBelieved : Verdict::kUndecided;
}

/// To look whether a socket is still open takes some system calls: not for each message of a flood.
void SoleSender::DropDead(Clock::time_point now) {
  constexpr auto kPause = std::chrono::milliseconds(20);
  if (now < next_look_) return;
  next_look_ = now + kPause;
  const auto num_dead =
      std::erase_if(candidates_, [&](const Candidate& one) { return !lives_(one.sender, one.last_heard, now); });
  if (num_dead == 0) return;
  believed_ = false;
  alone_since_ = now;
}

SoleSender::Candidate* SoleSender::Find(const Sender& sender) {
  const auto found =
      std::find_if(candidates_.begin(), candidates_.end(), [&](const Candidate& one) { return one.sender == sender; });
  return found == candidates_.end() ? nullptr : &*found;
}

bool SenderLives(const Sender& sender, std::chrono::steady_clock::time_point last_heard,
                 std::chrono::steady_clock::time_point now) {
  constexpr auto kSilence = std::chrono::seconds(2);
  const bool heard_lately = now - last_heard < kSilence;
  if (!sender.known()) return heard_lately;
  const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (probe < 0) return true;
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_addr.s_addr = sender.address;
  place.sin_port = htons(sender.port);
  const bool is_free = bind(probe, reinterpret_cast<const sockaddr*>(&place), sizeof place) == 0;
  const int error = errno;
  close(probe);
  if (is_free) return false;                            // of this host, and nobody's any more
  return error == EADDRNOTAVAIL ? heard_lately : true;  // not of this host; or in use
}

}  // namespace crsm
