#include "services/bus/sole_sender.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace crsm {
namespace {

constexpr auto kLookPeriod = std::chrono::milliseconds(100);

/// Whether a socket of this process can be at that place: 0, or why not (errno). Port 0 stands for any.
int TryToBind(const Sender& place) {
  const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (probe < 0) return errno;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = place.address;
  address.sin_port = htons(place.port);
  const int error = bind(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 ? 0 : errno;
  close(probe);
  return error;
}

}  // namespace

SoleSender::SoleSender(FindRole find_role, Lives lives)
    : find_role_(std::move(find_role)), lives_(std::move(lives)), look_limiter_(kLookPeriod) {}

SoleSender::Verdict SoleSender::Judge(const Sender& sender, Clock::time_point now) {
  constexpr auto kCheckPeriod = std::chrono::milliseconds(250);
  const bool is_believed = sender_ == sender;
  if (is_believed && now < next_check_) {
    last_heard_ = now;
    return Verdict::kBelieved;
  }
  if (!is_believed && !look_limiter_.MayLook(sender, now)) return Verdict::kRefused;
  if (is_believed) next_check_ = now + kCheckPeriod;
  const RoleHolder holder = find_role_(sender);
  if (holder == RoleHolder::kSender) return Believe(sender, true, now);
  if (holder == RoleHolder::kBusy) return is_believed ? Believe(sender, has_role_, now) : Verdict::kRefused;
  if (holder == RoleHolder::kAnother) {
    if (is_believed) sender_.reset();
    return Verdict::kRefused;
  }
  if (holder == RoleHolder::kNobody && sender_ && has_role_)
    LoseRoleHolder(now);  // also where the port is another process's by now
  if (now < vacant_until_) return Verdict::kRefused;
  const bool is_free = is_believed || !sender_ || !lives_(*sender_, last_heard_, now);
  return is_free ? Believe(sender, is_believed && has_role_, now) : Verdict::kRefused;
}

SoleSender::Verdict SoleSender::Believe(const Sender& sender, bool has_role, Clock::time_point now) {
  const bool changed = last_ && *last_ != sender;
  sender_ = last_ = sender;
  has_role_ = has_role;
  last_heard_ = now;
  return changed ? Verdict::kChanged : Verdict::kBelieved;
}

/// The next one that has the role is believed at once, one without it only after a while.
void SoleSender::LoseRoleHolder(Clock::time_point now) {
  constexpr auto kForAnother = std::chrono::seconds(5);
  sender_.reset();
  has_role_ = false;
  vacant_until_ = now + kForAnother;
}

bool IsOfThisHost(const Sender& sender) { return TryToBind({sender.address, 0}) != EADDRNOTAVAIL; }

bool SenderLives(const Sender& sender, std::chrono::steady_clock::time_point last_heard,
                 std::chrono::steady_clock::time_point now) {
  constexpr auto kSilence = std::chrono::seconds(2);
  const bool heard_lately = now - last_heard < kSilence;
  if (!sender.known()) return heard_lately;
  const int error = TryToBind(sender);
  if (error == 0) return false;                         // of this host, and nobody's any more
  return error == EADDRNOTAVAIL ? heard_lately : true;  // not of this host; or in use
}

}  // namespace crsm
