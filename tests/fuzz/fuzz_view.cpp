// SCAN_MATCH, CRITICAL_RAYS, WHOLE_MAP and SERVICE_STATUS, as map_viewer shows them: whatever came, what pages and
// Foxglove's programs are told must be JSON that holds no number that is none (JSON writes it as null). And what a page
// says.

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "common/results/json_text.hpp"
#include "input.hpp"
#include "matcher_replica.hpp"
#include "services/map_viewer/foxglove_feed.hpp"
#include "services/map_viewer/history.hpp"
#include "services/map_viewer/page_feed.hpp"
#include "services/map_viewer/service_info.hpp"

namespace crsm {
namespace {

void CheckNumbers(const nlohmann::json& json) {
  if (json.is_null()) std::abort();
  if (!json.is_structured()) return;
  for (const nlohmann::json& part : json) CheckNumbers(part);
}

void CheckText(std::string_view text) {
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (json.is_discarded()) std::abort();
  CheckNumbers(json);
}

/// The records of a message to a page: the info is JSON.
void CheckPage(std::string_view message) {
  constexpr std::size_t kHead = 5;
  constexpr char kInfo = 5;
  while (message.size() >= kHead) {
    std::size_t size = 0;
    for (std::size_t i = kHead; i-- > 1;) size = size << 8 | static_cast<unsigned char>(message[i]);
    if (size > message.size() - kHead) std::abort();
    if (message.front() == kInfo) CheckText(message.substr(kHead, size));
    message.remove_prefix(kHead + size);
  }
}

/// A scene of a robot that is heard, and all that it is told to.
class View {
 public:
  View() {
    ScanMatch match;
    Timeline timeline;
    for (match.utime = 0; match.utime < 20; ++match.utime) timeline.Add(match, nullptr);
    scene_.SetTimeline(std::move(timeline));
    auto history = std::make_shared<History>();
    history->Add(scene_, 1);
    history->Finish(scene_.map(), scene_.timeline().size());
    scene_.SetHistory(std::move(history));
    scene_.SetStartHandler([](const Pose2& T_map_laser) {
      if (!Decode<bot_core::pose_t>(Encode(ToPoseMessage(0, T_map_laser))))
        std::abort();  // the matcher would refuse it
    });
    scene_.SetMarkHandler([](const Mark& mark) {
      if (!Decode<mark_t>(Encode(ToMessage(mark)))) std::abort();  // the owner of the map would refuse it
    });
    foxglove_.Next();  // who it is
    foxglove_.Next();  // the channels
    std::string subscriptions;
    for (int id = 0; id < 10; ++id) {
      subscriptions += (id == 0 ? "" : ",") + nlohmann::json{{"id", id}, {"channelId", id}}.dump();
    }
    foxglove_.Hear(R"({"op":"subscribe","subscriptions":[)" + subscriptions + "]}", true);
  }

  void Handle(std::span<const std::uint8_t> bytes) {
    page_.Hear({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, true);
    if (const auto rays = Decode<critical_rays_t>(bytes)) scan_ = FromMessage(*rays);
    if (const auto match = Decode<scan_match_t>(bytes)) Show(FromMessage(*match));
    if (auto page = Decode<map_page_t>(bytes)) HandleAsAsked(std::move(*page), replica_);
    if (const auto status = Decode<service_status_t>(bytes)) {
      nlohmann::json info{{"live", true}};
      info["services"].push_back(DescribeService(*status, 0.5));
      scene_.SetInfo(ToText(info));
    }
    Tell();
  }

 private:
  void Show(const ScanMatch& match) {
    scene_.SetRobot({match, scan_});
    scene_.AddSample({match.utime, static_cast<float>(match.fitness), match.state});
  }

  void Tell() {
    constexpr int kMost = 100;
    scene_.SetLoops(replica_.loops());
    scene_.SetMarks(replica_.marks());
    for (int i = 0; i < kMost; ++i) {
      const auto message = page_.Next();
      if (!message) break;
      CheckPage(message->bytes);
    }
    for (int i = 0; i < kMost; ++i) {
      const auto message = foxglove_.Next();
      if (!message) break;
      constexpr std::size_t kHead = 13;  // of a binary message: kind, subscription, time
      CheckText(message->is_text ? std::string_view(message->bytes) : std::string_view(message->bytes).substr(kHead));
    }
  }

  Scene scene_{"caf\xe9/"};  // names need not be UTF-8
  PathSketch path_;
  CriticalRays scan_;
  MapReplica replica_{77,
                      {[this](double cell_size_m) {
                         map_.emplace(cell_size_m);
                         path_ = PathSketch();
                         scene_.map().Begin(cell_size_m);
                       },
                       [this](std::span<const TileChange> changes) {
                         for (const TileChange& change : changes) {
                           if (!map_->Apply(change)) continue;
                           const ByteMap::Tile* tile = map_->tiles().Find(change.index);
                           if (tile) scene_.map().Set(change.index, tile->cells, replica_.version());
                         }
                       },
                       [this](const ScanMatch& match) {
                         path_.Add(match);
                         scene_.SetPath(path_, false);
                       }},
                      MapReplica::View::kWhole};
  std::optional<ByteMap> map_;
  PageFeed page_{scene_, {scene_.name()}, {}};
  FoxgloveFeed foxglove_{{FoxgloveScene(scene_, scene_.name())}};
};

}  // namespace
}  // namespace crsm

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  View view;
  MessageReader messages({data, size});
  while (const auto bytes = messages.Next()) view.Handle(*bytes);
  return 0;
}
