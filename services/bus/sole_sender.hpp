#pragma once

#include <chrono>
#include <compare>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

namespace crsm {

/// Where a UDP packet came from. On its own host a sender cannot pretend to be another one: the port is that of its
/// socket, which no other process can have while the first lives.
struct Sender {
  std::uint32_t address = 0;  ///< IPv4, in the order of the network; 0: this host, which has no address of its own
  std::uint16_t port = 0;     ///< 0: the sender is not known
  bool known() const { return port != 0; }
  friend auto operator<=>(const Sender&, const Sender&) = default;

  std::string Describe() const;
};

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
  bool MayLook(const Sender& sender, Clock::time_point now);
  Verdict Believe(const Sender& sender, bool has_role, Clock::time_point now);
  void LoseRoleHolder(Clock::time_point now);

  FindRole find_role_;
  Lives lives_;
  std::optional<Sender> sender_;  ///< that is believed
  std::optional<Sender> last_;    ///< that was believed last
  bool has_role_ = false;         ///< it is, because it has the role
  Clock::time_point last_heard_{};
  Clock::time_point next_check_{};                  ///< of the one that is believed
  std::map<Sender, Clock::time_point> next_looks_;  ///< at others: a flood from many ports does not shut one out
  Clock::time_point vacant_until_{};                ///< the role's holder has gone: another one is waited for so long
};

}  // namespace crsm
