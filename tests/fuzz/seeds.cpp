// Writes what each fuzz target starts from: FOLDER/TARGET/NAME. All of it is made by the project's own encoders, but
// for the bags.

#include <zlib.h>

#include <filesystem>
#include <iostream>
#include <mbot_lcm_msgs/pose2D_t.hpp>

#include "common/math/random.hpp"
#include "common/worlds/built_in_worlds.hpp"
#include "graph/block.hpp"
#include "graph/nth.hpp"
#include "input.hpp"
#include "map_owner.hpp"
#include "services/journal/journal.hpp"
#include "services/settings/presets.hpp"
#include "services/sources/bags/bag_reader.hpp"
#include "services/wire/event_log_writer.hpp"
#include "services/wire/graph_messages.hpp"
#include "wire_messages.hpp"

namespace crsm {
namespace {

constexpr std::int64_t kRequester = 77;  // as in the targets

class Seeds {
 public:
  explicit Seeds(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::filesystem::path PathOf(const std::string& target, const std::string& name) const {
    std::filesystem::create_directories(folder_ / target);
    return folder_ / target / name;
  }
  void Write(const std::string& target, const std::string& name, std::string_view content) const {
    std::ofstream(PathOf(target, name), std::ios::binary) << content;
  }
  void Write(const std::string& target, const std::string& name, const Bytes& content) const {
    Write(target, name, std::string_view(reinterpret_cast<const char*>(content.data()), content.size()));
  }
  void Write(const std::string& target, const std::string& name, const std::vector<Bytes>& messages) const {
    Bytes input;
    for (const Bytes& message : messages) AppendMessage(input, message);
    Write(target, name, input);
  }

 private:
  std::filesystem::path folder_;
};

LaserScan Scan(std::int64_t utime, int num_beams = 90) { return ScanRoom({0.1, 0.2, 0.3}, utime, num_beams); }

Bytes EncodeRays(const LaserScan& scan) { return Encode(ToMessage(RaySelector({}).Select(scan))); }

Bytes MatchOf(const LaserScan& scan, const Pose2& pose, MatchState state = MatchState::kOk) {
  return Encode(ToMessage(ScanMatch{scan.utime, pose, 0.9, 1, 1, 0, state}));
}

/// The first page of a small map, for a replica that has nothing.
map_page_t FirstPage() {
  map_page_t page = MapPageMessage();
  page.version = 1;
  page.next_tile = -1;
  page.next_match = 1;
  page.tracking[0] = ToMessage(After({FromMessage(page.matches[0])}));
  page.tiles.clear();
  const auto changes = PaintTiles(-1, 0, RoomByte);
  for (const TileChange& change : changes) page.tiles.push_back(ToMessage(change));
  page.num_tiles = static_cast<std::int32_t>(page.tiles.size());
  return page;
}

/// FirstPage of a robot that drives and turns: by its last two scans, and by the twist of the last one.
map_page_t PageOfDrive() {
  constexpr std::int64_t kPeriod_us = 100000;
  map_page_t page = FirstPage();
  ScanMatch before = FromMessage(page.matches[0]);
  before.state = MatchState::kOk;
  before.T_map_laser = {0.0, 0.2, 0.2};
  ScanMatch last = before;
  last.utime += kPeriod_us;
  last.T_map_laser = {0.1, 0.2, 0.3};
  last.twist = {1.0, 0.0, 1.0};
  page.version = 2;
  page.next_match = 2;
  page.tracking[0] = ToMessage(After({before, last}));
  return page;
}

/// The room in a sweep of a laser that drives and turns, which ends where PageOfDrive's robot is 0.1 s later.
Bytes EncodeSweep(std::int64_t utime) {
  constexpr Pose2 kEnd{0.2, 0.2, 0.4};
  constexpr double kSweep_s = 0.15;
  CriticalRays scan = RaySelector({}).Select(ScanRoom(kEnd, utime, 90));
  ValidRays& rays = scan.rays;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const double time_s = kSweep_s * (static_cast<double>(i + 1) / static_cast<double>(rays.size()) - 1.0);
    const Pose2 at = kEnd * Pose2{time_s, 0.0, time_s};
    rays.range_m[i] = static_cast<float>(RangeInRoom(at.x_m, at.y_m, at.yaw_rad + rays.angle_rad[i]));
    rays.time_s.push_back(static_cast<float>(time_s));
  }
  return Encode(ToMessage(scan));
}

/// The next version after FirstPage, with one small change.
map_delta_t NextDelta() {
  map_delta_t delta = MapDeltaMessage();
  delta.utime = 6;
  delta.version = 2;
  return delta;
}

/// A page of as many tiles as fit, each with one cell, as far from each other as the map is large.
map_page_t ScatteredPage() {
  map_page_t page = FirstPage();
  page.tiles.clear();
  Random random(1);
  for (int i = 0; i < 4096; ++i) {
    const auto Draw = [&] { return static_cast<std::int16_t>(random.Uniform(-kMaxTile, kMaxTile)); };
    page.tiles.push_back({Draw(), Draw(), 5, {0, 0, 0, 1, 0}});
  }
  page.num_tiles = 4096;
  return page;
}

/// One delta after FirstPage in far more parts than come.
std::vector<Bytes> ManyParts() {
  std::vector<Bytes> messages{Encode(FirstPage())};
  map_delta_t delta = NextDelta();
  delta.num_parts = 4096;
  for (delta.part = 0; delta.part < 20; ++delta.part) messages.push_back(Encode(delta));
  return messages;
}

void WriteMessages(const Seeds& seeds) {
  const std::vector<std::pair<const char*, Bytes>> messages{{"sweep", Encode(SweepMessage())},
                                                            {"planar_lidar", Encode(LidarMessage())},
                                                            {"pose", Encode(PoseMessage())},
                                                            {"pose2d", Encode(mbot_lcm_msgs::pose2D_t{5, 1, 2, 3})},
                                                            {"lidar", Encode(BotlabLidarMessage())},
                                                            {"lidar_nranges", Encode(BotlabLidarNrangesMessage())},
                                                            {"critical_rays", Encode(CriticalRaysMessage())},
                                                            {"scan_match", Encode(ScanMatchMessage())},
                                                            {"map_delta", Encode(MapDeltaMessage())},
                                                            {"map_page", Encode(MapPageMessage())},
                                                            {"mark", Encode(MarkMessage())},
                                                            {"kept_mark", Encode(KeptMarkMessage())},
                                                            {"robot_marks", Encode(RobotMarksMessage())},
                                                            {"fleet_marks", Encode(FleetMarksMessage())},
                                                            {"map_request", Encode(MapRequestMessage())},
                                                            {"scan_request", Encode(ScanRequestMessage())},
                                                            {"scan_answer", Encode(ScanAnswerMessage())},
                                                            {"keyframe", Encode(KeyframeMessage())},
                                                            {"keyframe_request", Encode(KeyframeRequestMessage())},
                                                            {"pose_graph", Encode(PoseGraphMessage())},
                                                            {"service_status", Encode(ServiceStatusMessage())},
                                                            {"journal_head", Encode(JournalHeadMessage())},
                                                            {"journal_check", Encode(JournalCheckMessage())}};
  for (const auto& [name, message] : messages) {
    seeds.Write("wire", name, message);
    Bytes packet{0x4c, 0x43, 0x30, 0x32, 0, 0, 0, 7, 'L', 'A', 'S', 'E', 'R', 0};
    packet.insert(packet.end(), message.begin(), message.end());
    seeds.Write("packet", name, packet);
  }
  for (const int num_beams : {2, 30, 180, 4096}) {
    seeds.Write("ray_selector", std::to_string(num_beams), Encode(ToMessage(Scan(1, num_beams))));
  }

  const Bytes page = Encode(FirstPage());
  const Bytes delta = Encode(NextDelta());
  const Bytes rays = EncodeRays(Scan(7));
  seeds.Write("rrhc_matcher", "match", std::vector<Bytes>{page, rays, delta, rays});
  seeds.Write("rrhc_matcher", "small", std::vector<Bytes>{page, Encode(CriticalRaysMessage())});
  const Bytes sweep = EncodeSweep(PageOfDrive().tracking[0].recent[1].utime + 100000);
  seeds.Write("rrhc_matcher", "sweep", std::vector<Bytes>{Encode(PageOfDrive()), sweep, rays});
  map_page_t finished = FirstPage();  // a map without a history: the scan is looked for on all of it
  finished.version = 0;
  finished.next_match = 0;
  finished.num_matches = 0;
  finished.matches.clear();
  finished.tracking[0] = ToMessage(TrackingState::OnFinishedMap());
  seeds.Write("map_search", "finished", std::vector<Bytes>{Encode(finished), rays, Encode(CriticalRaysMessage())});
  seeds.Write("rrhc_matcher", "scattered", std::vector<Bytes>{Encode(ScatteredPage()), rays});
  seeds.Write("map_search", "scattered", std::vector<Bytes>{Encode(ScatteredPage()), rays});
  seeds.Write("view", "all",
              std::vector<Bytes>{Encode(CriticalRaysMessage()), Encode(ScanMatchMessage()), page,
                                 Encode(ServiceStatusMessage())});
  seeds.Write("map_updater", "marks",
              std::vector<Bytes>{Encode(CriticalRaysMessage()), Encode(ScanMatchMessage()), Encode(MarkMessage()),
                                 Encode(MapRequestMessage())});
  seeds.Write("map_exporter", "status", std::vector<Bytes>{page, Encode(ServiceStatusMessage())});
  map_page_t anew = FirstPage();
  anew.epoch = 100;
  seeds.Write("map_exporter", "anew", std::vector<Bytes>{page, Encode(anew), page});
  seeds.Write("map_exporter", "scattered", std::vector<Bytes>{Encode(ScatteredPage())});
  seeds.Write("rrhc_matcher", "parts", ManyParts());

  const std::string key = "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
  const std::string upgrade = " HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n" + key;
  const std::string subscribe = R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":0}]})";
  using std::string_literals::operator""s;
  const std::string mask = "\0\0\0\0"s;
  seeds.Write("map_viewer", "page", "\0GET /main.js HTTP/1.1\r\nHost: localhost\r\n\r\n"s);
  seeds.Write("map_viewer", "live",
              "\0GET /live?robot=0&epoch=7&version=1"s + upgrade + "Sec-WebSocket-Protocol: crsm.view.v1\r\n\r\n");
  seeds.Write("map_viewer", "close", "\1\x88\x82"s + mask + "\x03\xe8");
  seeds.Write("map_viewer", "ping", "\1\x89\x84"s + mask + "ping");
  seeds.Write("map_viewer", "subscribe", "\2\x81"s + static_cast<char>(0x80 | subscribe.size()) + mask + subscribe);

  MapOwner owner;
  std::vector<Bytes> pages;
  owner.Answer();
  for (std::int32_t tile = 0; tile >= 0;) {
    const map_page_t owned = owner.Page({.epoch = owner.epoch, .first_tile = tile});
    pages.push_back(Encode(owned));
    tile = owned.next_tile;
  }
  seeds.Write("map_exporter", "owner", pages);

  const Bytes request = Encode(map_request_t{.requester = kRequester, .question = 1});
  std::vector<Bytes> drive;
  for (const std::int64_t utime : {1, 2, 3}) {
    drive.push_back(EncodeRays(Scan(utime, 20)));
    drive.push_back(MatchOf(Scan(utime), {static_cast<double>(utime), 0.0, 0.1}));
  }
  drive.push_back(request);
  drive.push_back(Encode(map_request_t{.requester = kRequester,
                                       .question = 2,
                                       .epoch = 99,
                                       .base_version = 1,
                                       .first_match = -1}));  // the target's own epoch
  seeds.Write("map_updater", "drive", drive);
  std::vector<Bytes> jumps;
  for (const std::int64_t utime : {1, 2, 3, 4, 5, 6}) {
    const double far_m = utime % 2 == 0 ? 3200.0 : -3200.0;
    jumps.push_back(EncodeRays(Scan(utime, 4)));
    jumps.push_back(MatchOf(Scan(utime), {far_m, -far_m, 0.0}));
  }
  seeds.Write("map_updater", "jumps", jumps);
}

/// The keyframes of a drive, with few rays each.
std::vector<Bytes> Keyframes(const std::vector<Pose2>& places) {
  std::vector<Bytes> messages;
  for (Keyframe& keyframe : MakeKeyframes(MakeBlock(7), places, {0.0, 0.001, 0.0008}, 7)) {
    const ValidRays rays = keyframe.rays.Unpack();
    ValidRays few;
    for (std::size_t i = 0; i < rays.size(); i += 4) {
      few.angle_rad.push_back(rays.angle_rad[i]);
      few.range_m.push_back(rays.range_m[i]);
    }
    keyframe.rays = few;
    const int number = static_cast<int>(messages.size());
    messages.push_back(Encode(ToMessage(keyframe, {99, Nth(number), NthOrNone(number - 1)})));
  }
  return messages;
}

/// The same where loops were searched before: at every third one something was found.
std::vector<Bytes> WithSearches(std::vector<Bytes> messages) {
  for (Bytes& bytes : messages) {
    auto message = *Decode<keyframe_t>(bytes);
    message.searched = 1;
    message.num_findings = message.id.number > 0 && message.id.number % 3 == 0 ? 1 : 0;
    if (message.num_findings > 0) message.findings = {{{0, 0}, {1.0, 0.5, 0.1}, 0.8, loop_finding_t::DRIFT}};
    bytes = Encode(message);
  }
  return messages;
}

void WriteLoops(const Seeds& seeds) {
  std::vector<Pose2> round;  // and a little further, so that loops are closed
  for (int i = 0; i <= 50; ++i) round.push_back(PlaceRoundBlock(5.0 + 2.0 * i));
  seeds.Write("loop_closer", "round", Keyframes(round));
  seeds.Write("loop_closer", "begin", Keyframes({round.begin(), round.begin() + 4}));
  std::vector<Bytes> lacking = Keyframes({round.begin(), round.begin() + 6});
  lacking.erase(lacking.begin() + 2);
  seeds.Write("loop_closer", "lacking", lacking);
  seeds.Write("loop_closer", "searched", WithSearches(Keyframes(round)));
  seeds.Write("loop_closer", "small", std::vector<Bytes>{Encode(KeyframeMessage())});

  // A drive whose map is corrected on the way, and who looks at it.
  std::vector<Bytes> drive;
  for (int i = 0; i < 8; ++i) {
    drive.push_back(EncodeRays(Scan(i, 20)));
    drive.push_back(MatchOf(Scan(i), {static_cast<double>(i), 0.0, 0.1}));
    if (i != 4) continue;
    GraphUpdate update;
    update.keyframe = {0, 3};
    update.closed = {{{0, 0}, {0, 3}, {3.0, 0.1, 0.0}}};
    update.constraints_wrong_from = KeyframeId{0, 2};
    update.moved = {{{0, 0}, {}}};
    for (int k = 0; k <= 3; ++k) update.moved[0].poses.push_back({static_cast<double>(k), 0.1 * k, 0.0});
    for (const pose_graph_t& part : MakeParts(update, 3, 99)) drive.push_back(Encode(part));
  }
  drive.push_back(Encode(map_request_t{.requester = kRequester, .question = 1, .whole = 1}));
  drive.push_back(
      Encode(map_request_t{.requester = kRequester, .question = 2, .epoch = 99, .base_version = 1, .first_match = -1}));
  seeds.Write("map_updater", "corrected", drive);
}

void WriteLogs(const Seeds& seeds) {
  {
    EventLogWriter log(seeds.PathOf("logs", "lcm").string());
    log.Write("LASER", ToMessage(Scan(1, 20)));
    log.Write("BOTLAB", BotlabLidarMessage());
    log.Write("BOTLAB_OLD", BotlabLidarNrangesMessage());
    log.Write("LASER", ToMessage(Scan(2, 20)));
  }
  const std::string carmen =
      "# comment\nODOM 0 0 0 0 0 0 1.0 host 1.0\n"
      "FLASER 3 1.0 2.5 81.9 0 0 0 0 0 0 976052905.167303 host 0.5\n"
      "ROBOTLASER1 0 -1.57 3.14 0.0174 8.1 0.01 0 3 1.0 2.0 9.0 1 7 0 0 0 0 0 0 0 0 0 0 0 2.5 host 0.5\n";
  seeds.Write("logs", "carmen", carmen);
  gzFile compressed = gzopen(seeds.PathOf("logs", "carmen_gz").c_str(), "wb");
  gzwrite(compressed, carmen.data(), static_cast<unsigned>(carmen.size()));
  gzclose(compressed);
}

std::string ReadWhole(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The bags of tests/bags/data, which others' programs have written, and what is in them.
void WriteBags(const Seeds& seeds) {
  const std::vector<BagTopic> topics{
      {"/scan", "sensor_msgs/LaserScan", "ros1"},  // as in fuzz_bag_messages
      {"/scan", "sensor_msgs/msg/LaserScan", "cdr"}, {"/scan", "foxglove.LaserScan", "json"},
      {"/odom", "nav_msgs/Odometry", "ros1"},        {"/odom", "nav_msgs/msg/Odometry", "cdr"},
      {"/tf", "tf2_msgs/TFMessage", "ros1"},         {"/tf", "tf2_msgs/msg/TFMessage", "cdr"}};
  const std::map<std::string, std::string> targets{{".bag", "ros1_bag"}, {".mcap", "mcap"}, {".db3", "rosbag2"}};
  for (const auto& entry : std::filesystem::directory_iterator(CRSM_SOURCE_DIR "/tests/bags/data")) {
    const std::filesystem::path& path = entry.path();
    seeds.Write(targets.at(path.extension()), path.filename(), ReadWhole(path));
    for (std::size_t kind = 0; kind < topics.size(); ++kind) {
      const auto bag = OpenBagFile(path, [&](const BagTopic& topic) { return topic == topics[kind]; });
      const auto message = bag->Next();
      if (message)
        seeds.Write("bag_messages", std::to_string(kind), static_cast<char>(kind) + std::string(message->data));
    }
  }
}

void WriteJournal(const Seeds& seeds) {
  const std::filesystem::path folder = seeds.PathOf("journal", "making");
  {
    Journal journal(folder, {false, {{"cell_size_m", "0.05"}}});
    const CriticalRays scan = RaySelector({}).Select(Scan(1, 20));
    journal.Append(&scan, {1, {}, 0.0, 0, 1, 0, MatchState::kFirst});
    GraphUpdate update;
    update.keyframe = {0, 1};
    update.finding = LoopFinding{{0, 0}, {0, 1}, {1.0, 0.5, 0.1}, 0.75};
    update.moved = {{{}, {{}}}};
    journal.Append(update, 1);
    journal.AppendSearched({0, 2}, KeyframeId{0, 1}, 2);
    journal.Append(nullptr, {2, {0.1, 0.0, 0.0}, 0.9, 1, 1, 1, MatchState::kOk});
  }
  std::filesystem::rename(folder / "journal.lcm", seeds.PathOf("journal", "whole"));
  std::filesystem::remove(folder);
}

Bytes BytesOf(std::string_view text) { return {text.begin(), text.end()}; }

/// What each kind of laser says when it is started, and a scan or two.
void WriteLasers(const Seeds& seeds) {
  using namespace std::string_view_literals;
  seeds.Write(
      "hokuyo", "scan",
      std::vector<Bytes>{BytesOf("QT\n00P\n\n"), BytesOf("VV\n00P\nSERI:H1;V\n\n"),
                         BytesOf("PP\n00P\nMODL:X;n\nDMIN:20;4\nDMAX:5600;_\nARES:4;I\nAMIN:1;@\nAMAX:3;D\n"
                                 "AFRT:2;I\nSCAN:600;e\n\n"),
                         BytesOf("II\n00P\nSTAT:ok.;n\n\n"), BytesOf("BM\n00P\n\n"),
                         BytesOf("MD0001000301000\n99b\nm2@0?\n1Dh00?0CBa\n\n"), BytesOf("MD0001000301000\n50U\n\n")});
  Bytes turn;
  for (unsigned k = 0; k < 80; ++k) {
    const unsigned angle = (k * 10 % 360) * 64;
    for (const unsigned byte : {k % 36 == 0 ? 0x3du : 0x3eu, (angle & 0x7f) << 1 | 1u, angle >> 7, k, 15u}) {
      turn.push_back(static_cast<std::uint8_t>(byte));
    }
  }
  seeds.Write("rplidar", "scan",
              std::vector<Bytes>{{},
                                 BytesOf("\xA5\x5A\x14\x00\x00\x00\x04\x28\x1d\x01\x07 0123456789abcde"sv),
                                 BytesOf("\xA5\x5A\x03\x00\x00\x00\x06\x00\x00\x00"sv),
                                 BytesOf("\xA5\x5A\x04\x00\x00\x00\x15\xf4\x01\xf4\x01"sv),
                                 BytesOf("\xA5\x5A\x05\x00\x00\x40\x81"sv),
                                 turn});
  seeds.Write("sick", "scan",
              std::vector<Bytes>{
                  BytesOf("\x02sEA LMDscandata 0\x03"), BytesOf("\x02sRA DeviceIdent 6 LMS111 5 V1.36\x03"),
                  BytesOf("\x02sRA SCdevicestate 1\x03"), BytesOf("\x02sRA LCMstate 1\x03"),
                  BytesOf("\x02sEA LMDscandata 1\x03"),
                  BytesOf("\x02sSN LMDscandata 1 1 D6FF21 0 0 286B 3C84 EE4D4845 EE4DA2ED 0 0 7 0 0 1388 168 0 1 "
                          "DIST1 3F800000 00000000 FFF92230 1388 3 112 F 10 0 0 0 0 0 0\x03")});
}

void WriteTexts(const Seeds& seeds) {
  for (const BuiltInWorld& world : kBuiltInWorlds) seeds.Write("world", std::string(world.name), world.text);
  seeds.Write("view", "mark",
              std::vector<Bytes>{BytesOf(R"(mark {"id":"v","kind":"door","name":"","points":[[1,2]]})"),
                                 BytesOf(R"(mark {"id":"v","kind":"","name":"","points":[]})")});
  seeds.Write(
      "edits", "all",
      R"({"crop_m": [[0, 0], [1, 1]], "erase": [{"becomes": "free", "outline_m": [[0,0],[1,0],[0,1]]}], "turn_deg": 3})");
  seeds.Write("marks", "list", "# seen\ntime_s,x_m,y_m,kind,id,name\n1.5,,,victim,v,\"a, b\"\n,0;1;2,0;1;0,slow,,\n");
  for (const BuiltInConfig& preset : kPresets) seeds.Write("config", std::string(preset.name), preset.toml);
  for (const BuiltInConfig& profile : kProfiles) seeds.Write("config", std::string(profile.name), profile.toml);
  seeds.Write("config", "kinds", "seed = 7\nout = \"a\"\nlockstep = true\n[table]\nlist = [1, {a = 1979-05-27}]\n");
}

}  // namespace
}  // namespace crsm

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: fuzz_seeds FOLDER\n";
    return 2;
  }
  const crsm::Seeds seeds(argv[1]);
  crsm::WriteMessages(seeds);
  crsm::WriteLoops(seeds);
  crsm::WriteLogs(seeds);
  crsm::WriteBags(seeds);
  crsm::WriteJournal(seeds);
  crsm::WriteTexts(seeds);
  crsm::WriteLasers(seeds);
}
