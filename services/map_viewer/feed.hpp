#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace crsm {

/// What one client is told, a message at a time. A message is made when the client can take it, of what has changed
/// since the one before: who is slow gets fewer of them, and the newest, and nothing waits in a queue.
class Feed {
 public:
  struct Message {
    bool is_text = false;
    std::string bytes;
  };

  virtual ~Feed() = default;

  /// The next message; nothing while the client has all that there is.
  virtual std::optional<Message> Next() = 0;

  /// Whether there is more to tell at once: a part was left out, so that no message is too large.
  virtual bool has_more() const { return false; }

  /// What the client says. False where it makes no sense, and the client is to be sent away.
  virtual bool Hear(std::string_view message, bool is_text) = 0;
};

}  // namespace crsm
