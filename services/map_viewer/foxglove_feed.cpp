#include "services/map_viewer/foxglove_feed.hpp"

#include <algorithm>
#include <utility>

#include "common/results/json_text.hpp"
#include "services/map_viewer/little_endian.hpp"

namespace crsm {
namespace {

using nlohmann::json;

constexpr std::uint8_t kMessageData = 1;

/// Between two messages of a topic: large ones are whole each time.
std::chrono::milliseconds PauseOf(FoxgloveTopic::Kind kind) {
  using enum FoxgloveTopic::Kind;
  const bool is_large = kind == kGrid || kind == kPath || kind == kFloatingPath;
  return std::chrono::milliseconds(is_large ? 1000 : 30);
}

std::optional<std::uint32_t> ReadId(const json& value) {
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > 0xffffffffU) return std::nullopt;
  return value.get<std::uint32_t>();
}

/// What a client says; what is nested deeper than anything in the protocol is left out: whoever copies it would go as
/// deep into the stack.
json Parse(std::string_view text) {
  constexpr int kDeepest = 8;
  return json::parse(
      text, [](int depth, json::parse_event_t, json&) { return depth <= kDeepest; }, false);
}

/// An empty list where there is none.
json ListIn(const json& message, const char* key) {
  const auto found = message.find(key);
  return found != message.end() && found->is_array() ? *found : json::array();
}

}  // namespace

std::optional<Feed::Message> FoxgloveFeed::Next() {
  has_more_ = true;
  if (!std::exchange(greeted_, true)) {
    return Message{true, ToText({{"op", "serverInfo"},
                                 {"name", "CRSM SLAM"},
                                 {"capabilities", json::array()},
                                 {"supportedEncodings", {"json"}},
                                 {"metadata", json::object()}})};
  }
  if (auto message = Advertise()) return message;
  if (auto message = TellNext()) return message;
  has_more_ = false;
  return std::nullopt;
}

std::optional<Feed::Message> FoxgloveFeed::Advertise() {
  json channels = json::array();
  for (FoxgloveScene& scene : scenes_) {
    const auto num_known = static_cast<std::size_t>(std::count_if(
        channels_.begin(), channels_.end(), [&](const Channel& channel) { return channel.scene == &scene; }));
    const std::vector<FoxgloveTopic>& topics = scene.Topics();
    for (std::size_t i = num_known; i < topics.size(); ++i) {
      channels.push_back({{"id", channels_.size()},
                          {"topic", scene.NameOf(topics[i])},
                          {"encoding", "json"},
                          {"schemaName", FoxgloveScene::SchemaNameOf(topics[i])},
                          {"schemaEncoding", "jsonschema"},
                          {"schema", FoxgloveScene::SchemaOf(topics[i])}});
      channels_.push_back({&scene, topics[i]});
    }
  }
  if (channels.empty()) return std::nullopt;
  return Message{true, ToText({{"op", "advertise"}, {"channels", channels}})};
}

bool FoxgloveFeed::IsDue(const Subscription& subscription, Clock::time_point now) const {
  const auto& [scene, topic] = channels_[subscription.channel];
  const ChangeNumber last = scene->LastChange(topic);
  return last != 0 && last != subscription.told && now >= subscription.next;
}

/// In turn, so that no topic keeps the others from being told.
std::optional<Feed::Message> FoxgloveFeed::TellNext() {
  const auto now = Clock::now();
  for (std::size_t i = 0; i < subscriptions_.size(); ++i) {
    Subscription& subscription = subscriptions_[turn_++ % subscriptions_.size()];
    if (!IsDue(subscription, now)) continue;
    const auto& [scene, topic] = channels_[subscription.channel];
    subscription.told = scene->LastChange(topic);
    subscription.next = now + PauseOf(topic.kind);
    Message message;
    Append(message.bytes, kMessageData);
    Append(message.bytes, subscription.id);
    Append(message.bytes, scene->time_ns());
    message.bytes += scene->Encode(topic);
    return message;
  }
  return std::nullopt;
}

bool FoxgloveFeed::Hear(std::string_view text, bool is_text) {
  if (!is_text) return false;  // nobody was asked to publish
  const json message = Parse(text);
  if (!message.is_object()) return false;
  const json op = message.value("op", json());
  if (op == "subscribe") {
    for (const json& wanted : ListIn(message, "subscriptions")) {
      if (!wanted.is_object()) return false;
      const auto id = ReadId(wanted.value("id", json()));
      const auto channel = ReadId(wanted.value("channelId", json()));
      if (!id || !channel || *channel >= channels_.size()) return false;
      // One of each channel: a client that asks for it a thousand times is not told it as often.
      std::erase_if(subscriptions_,
                    [&](const Subscription& known) { return known.id == *id || known.channel == *channel; });
      subscriptions_.push_back({*id, *channel});
    }
  } else if (op == "unsubscribe") {
    for (const json& unwanted : ListIn(message, "subscriptionIds")) {
      const auto id = ReadId(unwanted);
      std::erase_if(subscriptions_, [&](const Subscription& known) { return known.id == id; });
    }
  }
  return true;  // whatever else there is in newer versions of the protocol is none of ours
}

}  // namespace crsm
