#include "services/bus/bus.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>

#include "catch.hpp"
#include "packets.hpp"
#include "processes.hpp"
#include "services/wire/conversions.hpp"

using namespace crsm;

namespace {

/// What is said on stderr while this lives goes to a file.
class CaughtErrors {
 public:
  explicit CaughtErrors(const std::filesystem::path& path) : path_(path) {
    REQUIRE(old_ >= 0);
    std::FILE* file = std::fopen(path.c_str(), "w");
    REQUIRE(file);
    REQUIRE(dup2(fileno(file), STDERR_FILENO) == STDERR_FILENO);
    std::fclose(file);
  }
  ~CaughtErrors() {
    std::fflush(stderr);
    dup2(old_, STDERR_FILENO);
    close(old_);
  }
  CaughtErrors(const CaughtErrors&) = delete;

  std::string text() const { return ReadFile(path_); }

 private:
  std::filesystem::path path_;
  int old_ = dup(STDERR_FILENO);
};

std::int64_t Count(const Counters& counters, const std::string& name) {
  const auto found = counters.counts().find(name);
  return found == counters.counts().end() ? 0 : found->second;
}

const map_request_t kRequest{.requester = 42, .question = 1, .epoch = 7};

}  // namespace

TEST_CASE("messages are heard once, by whichever thread they are received, and with a buffer that no kernel gives") {
  const std::string url = MakeBusUrl();
  const std::string small_buffer = "?ttl=0&recv_buf_size=999999999";
  struct Way {
    Reception reception;
    std::string url;
  };
  for (const Way& way : {Way{Reception::kByHandler, url}, Way{Reception::kByThread, url},
                         Way{Reception::kByHandler, url.substr(0, url.find('?')) + small_buffer}}) {
    INFO(way.url);
    Counters counters;
    Bus bus(way.url, "", counters, way.reception);
    std::vector<std::int64_t> heard;
    bus.Subscribe<map_request_t>(kMapRequestChannel, [&](const auto& request) { heard.push_back(request.requester); });
    for (const std::int64_t requester : {1, 2, 3})
      bus.Publish(kMapRequestChannel, map_request_t{.requester = requester});
    CHECK(WaitUntil([&] { return bus.Wait(10), heard.size() >= 3; }));
    bus.Wait(50);  // for what might come twice
    CHECK(heard == std::vector<std::int64_t>{1, 2, 3});
    CHECK(Count(counters, "socket_unfiltered") == 0);
  }
}

TEST_CASE("an exception that leaves a handler is counted each time, and said once") {
  const TemporaryFolder folder;
  Counters counters;
  Bus bus(MakeBusUrl(), "robot1/", counters);
  bus.Subscribe<map_request_t>(kMapRequestChannel,
                               [](const map_request_t&) { throw std::runtime_error("this is why"); });
  const CaughtErrors errors(folder / "errors");
  for (int i = 0; i < 3; ++i) bus.Publish(kMapRequestChannel, kRequest);
  REQUIRE(WaitUntil([&] { return bus.Wait(10), Count(counters, "handler_failed") == 3; }));
  CHECK(errors.text() == "cannot handle a message on robot1/MAP_REQUEST: this is why\n");
}

TEST_CASE("a message that cannot be published is counted each time, and said once") {
  const TemporaryFolder folder;
  Counters counters;
  Bus bus(MakeBusUrl(), std::string(60, 'n'), counters);  // LCM takes names of 63 letters
  const CaughtErrors errors(folder / "errors");
  for (int i = 0; i < 3; ++i) bus.Publish(kMapRequestChannel, kRequest);
  CHECK(Count(counters, "publish_failed") == 3);
  const std::string text = errors.text();
  const std::size_t at = text.find("LCM cannot publish on nnn");
  REQUIRE(at != std::string::npos);
  CHECK(text.find("LCM cannot publish on nnn", at + 1) == std::string::npos);
}

TEST_CASE("each of several buses in a process hears its own channels, and no others") {
  const std::string url = MakeBusUrl();
  Counters one_counters, other_counters;
  Bus one(url, "", one_counters), other(url, "", other_counters);
  int requests = 0, deltas = 0, requests_of_other = 0;
  one.Subscribe<map_request_t>(kMapRequestChannel, [&](const map_request_t&) { ++requests; });
  other.Subscribe<map_delta_t>(kMapDeltaChannel, [&](const map_delta_t&) { ++deltas; });
  other.Subscribe<map_request_t>(kMapRequestChannel, [&](const map_request_t&) { ++requests_of_other; });
  one.Publish(kMapDeltaChannel, map_delta_t{.epoch = 1, .version = 1, .cell_size_m = 0.05, .num_parts = 1});
  other.Publish(kMapRequestChannel, kRequest);
  CHECK(WaitUntil([&] {
    one.Wait(1);
    other.Wait(1);
    return requests == 1 && deltas == 1 && requests_of_other == 1;
  }));
  CHECK(Count(one_counters, "socket_unfiltered") == 0);
  CHECK(Count(other_counters, "socket_unfiltered") == 0);
}

TEST_CASE("subscriptions to more channels than the kernel filters by are heard all the same") {
  Counters counters;
  Bus bus(MakeBusUrl(), std::string(40, 'n'), counters);
  int requests = 0;
  for (int i = 0; i < 200; ++i)
    bus.Subscribe<map_request_t>(std::to_string(i).c_str(), [&](const auto&) { ++requests; });
  CHECK(Count(counters, "socket_unfiltered") > 0);
  bus.Publish("0", kRequest);
  bus.Publish("199", kRequest);
  CHECK(WaitUntil([&] { return bus.Wait(10), requests == 2; }));
}

TEST_CASE("a message in fragments, as LCM sends it on other systems, is heard") {
  const std::string url = MakeBusUrl();
  Counters counters;
  Bus bus(url, "", counters);
  std::size_t num_ranges = 0;
  bus.Subscribe<bot_core::planar_lidar_t>(
      kLaserChannel, [&](const bot_core::planar_lidar_t& message) { num_ranges = message.ranges.size(); });
  const LaserScan scan{5, -1.5f, 0.01f, std::vector<float>(300, 2.0f)};
  const std::vector<std::uint8_t> message = Encode(ToMessage(scan));
  const std::string bytes(message.begin(), message.end());
  const auto size = static_cast<std::uint32_t>(bytes.size());
  const RawSender sender;
  for (const Fragment& fragment :
       {Fragment{.message_bytes = size, .rest = std::string("LASER\0", 6) + bytes.substr(0, 700)},
        Fragment{.message_bytes = size, .offset = 700, .number = 1, .rest = bytes.substr(700)}}) {
    sender.Send(fragment.Encode(), PortOf(url));
  }
  CHECK(WaitUntil([&] { return bus.Wait(10), num_ranges == 300; }));
}

TEST_CASE("fragments whose place wraps at 32 bits harm no service") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  Process selector("ray_selector", {"--lcm-url", url}, folder / "log");
  REQUIRE(selector.AwaitReady());
  TestBus bus(url);
  std::int64_t answered_utime = 0;
  bus->Subscribe<critical_rays_t>(kCriticalRaysChannel,
                                  [&](const critical_rays_t& rays) { answered_utime = rays.utime; });
  const RawSender sender;
  for (std::uint32_t i = 0; i < 1000; ++i) SendWrappingFragments(sender, PortOf(url), "LASER", i);
  bus->Publish(kLaserChannel, ToMessage(LaserScan{5, -1.5f, 0.01f, std::vector<float>(300, 2.0f)}));
  CHECK(bus.Await([&] { return answered_utime == 5; }));
  CHECK(selector.Interrupt() == 0);
}

TEST_CASE("of two senders on a channel for one, the first is heard, all that it sent and in order, while it lives") {
  const std::string url = MakeBusUrl();
  const TemporaryFolder folder;
  Counters counters, sender_counters;
  Bus bus(url, "", counters);
  std::vector<std::int64_t> heard;
  bus.SubscribeToOne<map_request_t>(kMapRequestChannel, kMatcherRole,
                                    [&](const map_request_t& request) { heard.push_back(request.requester); });
  CHECK(Count(counters, "senders_unknown") == 0);
  auto one = std::make_unique<Bus>(url, "", sender_counters);
  Bus other(url, "", sender_counters);
  const CaughtErrors errors(folder / "errors");
  const auto Send = [&](Bus& sender, std::int64_t requester) {
    sender.Publish(kMapRequestChannel, map_request_t{.requester = requester});
    bus.Wait(10);
  };
  for (const std::int64_t requester : {1, 2, 3}) Send(*one, requester);
  CHECK(WaitUntil([&] { return bus.Wait(10), heard.size() == 3; }));
  for (const std::int64_t requester : {101, 102}) Send(other, requester);
  Send(*one, 4);
  CHECK(WaitUntil([&] { return bus.Wait(10), heard.size() == 4 && Count(counters, "MAP_REQUEST_refused") == 2; }));
  one.reset();
  CHECK(WaitUntil([&] { return Send(other, 103), heard.size() >= 5; }));
  heard.resize(5);
  CHECK(heard == std::vector<std::int64_t>{1, 2, 3, 4, 103});
  const std::string text = errors.text();
  CHECK(text.find("is refused: another process sends it") != std::string::npos);
  CHECK(text.find("comes from another process now") != std::string::npos);
  CHECK(std::count(text.begin(), text.end(), '\n') == 2);
  CHECK(Count(counters, "MAP_REQUEST_sender_changed") == 1);
}

TEST_CASE("who has the role on a bus is heard at once, and who was there before no more") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  Counters counters, other_counters;
  Bus bus(url, "", counters), other(url, "", other_counters);
  const CaughtErrors errors(folder / "errors");
  std::vector<std::int64_t> heard;
  bus.SubscribeToOne<critical_rays_t>(kCriticalRaysChannel, kSelectorRole,
                                      [&](const critical_rays_t& rays) { heard.push_back(rays.utime); });
  const auto Forge = [&](std::int64_t utime) {
    CriticalRays forged;
    forged.utime = utime;
    other.Publish(kCriticalRaysChannel, ToMessage(forged));
    bus.Wait(10);
  };
  Forge(1);
  CHECK(WaitUntil([&] { return bus.Wait(10), heard.size() == 1; }));
  Process selector("ray_selector", {"--lcm-url", url}, folder / "log");
  REQUIRE(selector.AwaitReady());
  other.Publish(kLaserChannel, ToMessage(LaserScan{2, -1.5f, 0.01f, std::vector<float>(300, 2.0f)}));
  CHECK(WaitUntil([&] { return bus.Wait(10), heard.size() == 2; }));
  Forge(3);
  CHECK(WaitUntil([&] { return bus.Wait(10), Count(counters, "CRITICAL_RAYS_refused") == 1; }));
  CHECK(heard == std::vector<std::int64_t>{1, 2});
  CHECK(Count(counters, "CRITICAL_RAYS_sender_changed") == 1);
  CHECK(errors.text().find("CRITICAL_RAYS comes from another process now") != std::string::npos);
  CHECK(selector.Interrupt() == 0);
}
