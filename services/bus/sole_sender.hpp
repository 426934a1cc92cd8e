#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace crsm {

/// Where a UDP packet came from. On its own host a sender cannot pretend to be another one: the port is that of its
/// socket, which no other process can have while the first lives.
struct Sender {
  std::uint32_t address = 0;  ///< IPv4, in the order of the network; 0: this host, which has no address of its own
  std::uint16_t port = 0;     ///< 0: the sender is not known
  bool known() const { return port != 0; }
  friend bool operator==(const Sender&, const Sender&) = default;

  std::string Describe() const;
};

/// Whether the socket of a sender is still open, on this host; of another host, whether it was heard in the last two
/// seconds.
bool SenderLives(const Sender& sender, std::chrono::steady_clock::time_point last_heard,
                 std::chrono::steady_clock::time_point now);

/// Who is believed on a channel on which only one process has something to say: the first that is heard, for as long as
/// it lives. There are no keys: who is first when all begin is not known. So the first is not believed before it has
/// been the only one for a moment, and when there are two in its first seconds, neither is until one has ended. Later
/// it is the first that stays.
class SoleSender {
 public:
  using Clock = std::chrono::steady_clock;
  /// How long the first one must be the only one. What answers at once, and wrongly, is found out by the right answer.
  static constexpr auto kProbation = std::chrono::milliseconds(100);
  /// The same where the right answer comes later, since who gives it must first believe in the sender of the question.
  static constexpr auto kProbationOfAnswers = 4 * kProbation;
  /// How long another one may still show that the first was not the right one.
  static constexpr auto kYoung = std::chrono::seconds(2);

  enum class Verdict {
    kBelieved,   ///< from the one sender
    kUndecided,  ///< keep it, and ask again later
    kRefused     ///< from another one
  };

  /// lives: whether a sender is still there that was heard last at that time. By default: SenderLives.
  using Lives = std::function<bool(const Sender&, Clock::time_point last_heard, Clock::time_point now)>;
  explicit SoleSender(std::chrono::milliseconds probation = kProbation, Lives lives = SenderLives);

  /// A message has come. heard: false to ask once more about one that came before.
  Verdict Judge(const Sender& sender, Clock::time_point now, bool heard = true);

  /// Whether there are several at the moment and none is believed.
  bool contested() const { return !believed_ && candidates_.size() > 1; }

 private:
  struct Candidate {
    Sender sender;
    Clock::time_point last_heard;
  };

  void DropDead(Clock::time_point now);
  Candidate* Find(const Sender& sender);

  std::chrono::milliseconds probation_;
  Lives lives_;
  bool believed_ = false;              ///< the only candidate is the sender
  std::vector<Candidate> candidates_;  ///< that live; few, since a sender that is believed keeps the others out
  Clock::time_point alone_since_{};
  Clock::time_point next_look_{};  ///< for dead ones
};

}  // namespace crsm
