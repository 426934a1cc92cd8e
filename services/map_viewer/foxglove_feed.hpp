#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

#include "services/map_viewer/feed.hpp"
#include "services/map_viewer/foxglove_scene.hpp"

namespace crsm {

/// What Foxglove and Lichtblick are told, by their WebSocket protocol: which topics there are, and of those that the
/// client has subscribed to, how each is now when it has changed. Nothing is asked of a client or taken from it
/// besides.
class FoxgloveFeed : public Feed {
 public:
  /// The protocol's two names, the newer first.
  static constexpr const char* kSubprotocols[]{"foxglove.sdk.v1", "foxglove.websocket.v1"};

  explicit FoxgloveFeed(std::vector<FoxgloveScene> scenes) : scenes_(std::move(scenes)) {}

  std::optional<Message> Next() override;
  bool has_more() const override { return has_more_; }
  bool Hear(std::string_view message, bool is_text) override;

 private:
  using Clock = std::chrono::steady_clock;
  struct Channel {
    FoxgloveScene* scene;
    FoxgloveTopic topic;
  };
  struct Subscription {
    std::uint32_t id;
    std::uint32_t channel;  ///< its id
    ChangeNumber told = 0;
    Clock::time_point next{};  ///< not before
  };

  std::optional<Message> Advertise();
  std::optional<Message> TellNext();
  bool IsDue(const Subscription& subscription, Clock::time_point now) const;

  std::vector<FoxgloveScene> scenes_;
  std::vector<Channel> channels_;            ///< that were advertised; their ids are their indices
  std::vector<Subscription> subscriptions_;  ///< at most one of a channel
  std::size_t turn_ = 0;                     ///< whose it is to be told, if it is due
  bool greeted_ = false;
  bool has_more_ = false;
};

}  // namespace crsm
