#pragma once

#include <chrono>
#include <functional>
#include <optional>

#include "services/bus/look_limiter.hpp"
#include "services/bus/sender.hpp"

namespace crsm {

/// Whether a packet came from this host: its address is one of it.
bool IsOfThisHost(const Sender& sender);

/// Whether the socket of a sender is still open, on this host; of another host, whether it was heard in the last two
/// seconds.
bool SenderLives(const Sender& sender, std::chrono::steady_clock::time_point last_heard,
                 std::chrono::steady_clock::time_point now);

/// Who has the role to which a channel belongs (BusRole), as far as this host sees.
enum class RoleHolder {
  kNobody,
  kSender,   ///< the process that sent the message
  kAnother,  ///< another process
  kBusy,     ///< a process that cannot be asked now: somebody else asks it without end
  kUnknown   ///< a process of which it cannot be told which sockets it has
};

/// Who is believed on a channel on which only one process has something to say: at once the process that has the
/// channel's role on this host, and no other. Where none is known to have it, the first that is heard, for as long as
/// it lives. There are no keys.
class SoleSender {
 public:
  using Clock = std::chrono::steady_clock;

  enum class Verdict {
    kBelieved,
    kChanged,  ///< believed, and not the one that was before
    kRefused
  };

  /// Both are asked seldom: they take system calls.
  using FindRole = std::function<RoleHolder(const Sender&)>;
  using Lives = std::function<bool(const Sender&, Clock::time_point last_heard, Clock::time_point now)>;
  explicit SoleSender(FindRole find_role, Lives lives = SenderLives);

  /// A message has come.
  Verdict Judge(const Sender& sender, Clock::time_point now);

 private:
  Verdict Believe(const Sender& sender, bool has_role, Clock::time_point now);
  void LoseRoleHolder(Clock::time_point now);

  FindRole find_role_;
  Lives lives_;
  std::optional<Sender> sender_;  ///< that is believed
  std::optional<Sender> last_;    ///< that was believed last
  bool has_role_ = false;         ///< it is, because it has the role
  Clock::time_point last_heard_{};
  Clock::time_point next_check_{};    ///< of the one that is believed
  LookLimiter look_limiter_;          ///< for others
  Clock::time_point vacant_until_{};  ///< the role's holder has gone: another one is waited for so long
};

}  // namespace crsm
