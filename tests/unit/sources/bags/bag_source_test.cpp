#include "services/sources/bags/bag_source.hpp"

#include <cmath>

#include "bag_bytes.hpp"
#include "catch.hpp"
#include "packed.hpp"
#include "services/sources/bags/decompress.hpp"
#include "services/sources/bags/scan_messages.hpp"
#include "services/sources/open_laser_source.hpp"
#include "source_helpers.hpp"

namespace crsm {
namespace {

struct Result {
  std::vector<LaserScan> scans;
  std::vector<std::optional<Pose2>> odometry;
  std::map<std::string, std::int64_t> counts;
  std::vector<std::string> complaints;
  std::vector<std::string> notes;  ///< on the odometry
};

Result Read(const std::string& path, const LaserChoice& laser = {}) {
  BagSource source(path, laser);
  Result result;
  while (auto scan = source.Next()) {
    result.scans.push_back(*scan);
    result.odometry.push_back(source.Odometry());
  }
  CHECK(source.Progress() == 1.0);
  result.counts = source.Counts();
  result.complaints = source.Complaints();
  result.notes = source.OdometryNotes();
  return result;
}

Result ReadBag(const std::string& bytes, const LaserChoice& laser = {}) {
  const ScratchFile file(bytes);
  return Read(file.path(), laser);
}

/// Of a bag of ROS 1, or of MCAP, whose scans are on /scan.
Result ReadRos1(const std::string& records) { return ReadBag(Ros1Bytes(Ros1Connection(1, "/scan") + records)); }
Result ReadMcap(const std::string& records) { return ReadBag(McapBytes(McapChannel(1, "/scan") + records)); }

std::string ErrorOfBag(const std::string& bytes, const LaserChoice& laser = {}) {
  const ScratchFile file(bytes);
  const std::string error = ErrorOf([&] { Read(file.path(), laser); });
  return error.starts_with(file.path()) ? error.substr(file.path().size()) : error;
}

/// What is measured in tests/bags/small.world: a room of 4 by 3 m, 1 m from its lower left walls, heading along x.
double TrueRange(double x_m, double angle_rad) {
  const double cos = std::cos(angle_rad);
  const double sin = std::sin(angle_rad);
  const double to_right_m = cos > 1e-9 ? (4.0 - x_m) / cos : 1e9;
  const double to_wall_m = sin > 1e-9 ? 2.0 / sin : sin < -1e-9 ? -1.0 / sin : 1e9;
  return std::min(to_right_m, to_wall_m);
}

/// A scan of that second.
std::string Ros1At(std::uint32_t sec, const std::string& frame = "las") {
  return Ros1Message(1, LaserMessage{.sec = sec, .frame = frame}.Ros1());
}
std::string CdrAt(std::uint32_t sec) { return LaserMessage{.sec = sec}.Cdr(); }

using Seconds = std::vector<std::int64_t>;

Seconds SecondsOf(const Result& result) {
  Seconds seconds;
  for (const LaserScan& scan : result.scans) seconds.push_back(scan.utime / 1'000'000);
  return seconds;
}

const std::vector<std::string> kFiles{"lz4.bag",        "bz2_killed.bag", "none_killed.bag", "zstd.mcap",
                                      "no_chunks.mcap", "json.mcap",      "run.db3"};

std::uint32_t SizeOf(const std::string& bytes) { return static_cast<std::uint32_t>(bytes.size()); }

}  // namespace

TEST_CASE("bags that other programs wrote give the sweeps and the odometry that went in") {
  const std::string name = GENERATE(from_range(kFiles));
  INFO(name);
  const Result result = Read(DataPath(name));
  REQUIRE(result.scans.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    const LaserScan& scan = result.scans[i];
    const double driven_m = 0.1 * static_cast<double>(i);
    CHECK(scan.utime == 1'000'000 + static_cast<std::int64_t>(i) * 100'000);
    REQUIRE(scan.ranges_m.size() == 10);
    for (std::size_t beam = 0; beam < 10; ++beam) {
      const double angle_rad = -kPi / 2 + static_cast<double>(beam) * kPi / 10;
      CHECK(std::abs(scan.angle_min_rad + static_cast<float>(beam) * scan.angle_step_rad - angle_rad) < 1e-5);
      CHECK(std::abs(scan.ranges_m[beam] - TrueRange(1.0 + driven_m, angle_rad)) < 1e-5);
    }
    const bool is_lost = name == "bz2_killed.bag" && i == 2;  // it had not reached the file
    const bool has_odometry = name != "json.mcap" && !is_lost;
    REQUIRE(result.odometry[i].has_value() == has_odometry);
    if (has_odometry) CHECK(*result.odometry[i] == Pose2{std::round(driven_m * 100) / 100, 0.0, 0.0});
  }
  const bool is_killed = name.find("killed") != std::string::npos;
  CHECK(result.counts == std::map<std::string, std::int64_t>{{"bad_chunk", 0}, {"truncated", is_killed}});
  CHECK(result.complaints.empty());
}

TEST_CASE("a bag that is cut anywhere gives its first scans as they are, and says that it is cut") {
  const std::string name = GENERATE(from_range(kFiles));
  INFO(name);
  const std::string whole = DataBytes(name);
  const auto scans = Read(DataPath(name)).scans;
  std::size_t most = 0;
  for (std::size_t size = 1; size < whole.size(); size += 11) {
    try {
      const Result result = ReadBag(whole.substr(0, size));
      INFO(size);
      REQUIRE(result.scans.size() <= scans.size());
      CHECK(std::equal(result.scans.begin(), result.scans.end(), scans.begin()));
      if (result.scans.size() < scans.size()) CHECK(result.counts.at("truncated") == 1);
      most = std::max(most, result.scans.size());
    } catch (const std::runtime_error&) {  // nothing of a laser is left
    }
  }
  CHECK(most >= 2);
}

TEST_CASE("of a laser that tells several echoes of a beam the first one counts, which is the nearest") {
  const std::string echoes = Ros1Bytes(Ros1Connection(1, "/echoes", "sensor_msgs/MultiEchoLaserScan") +
                                       Ros1Message(1, LaserMessage{.sec = 1, .has_echoes = true}.Ros1()));
  const std::string plain = Ros1Bytes(Ros1Connection(1, "/scan") + Ros1At(1));
  REQUIRE(ReadBag(plain).scans.size() == 1);
  CHECK(ReadBag(echoes).scans == ReadBag(plain).scans);
  const BagTopic topic{"/scan", "sensor_msgs/msg/MultiEchoLaserScan", "cdr"};
  const DecodedScan decoded = DecodeScan(topic, LaserMessage{.sec = 1, .has_echoes = true}.Cdr());
  REQUIRE(decoded.scan);
  CHECK(decoded.scan->ranges_m == ReadBag(plain).scans[0].ranges_m);
  CHECK_FALSE(DecodeScan(topic, LaserMessage{.sec = 1}.Cdr()).scan);  // plain ranges are no echoes
}

TEST_CASE("a topic on which nothing was sent is no laser, and what damage may have taken is said") {
  const std::string declared = Ros1Connection(1, "/front") + Ros1Connection(2, "/rear");
  CHECK(SecondsOf(ReadBag(Ros1Bytes(declared + Ros1Message(2, LaserMessage{.sec = 2}.Ros1())))) == Seconds{2});
  CHECK(ErrorOfBag(Ros1Bytes(declared)).starts_with(" has several laser topics"));
  CHECK(ErrorOfBag(Ros1Bytes(Ros1Chunk("no lz4", "lz4", 1000)))
            .ends_with("its topics: none; 1 parts of it are damaged, and what stood in them is not known"));
}

TEST_CASE("a header that contradicts itself is complained of once") {
  const LaserMessage message{.sec = 1, .angle_min = -0.5f, .angle_increment = -0.5f, .angle_max = 0.5f};
  LaserMessage next = message;
  next.sec = 2;
  const ScratchFile bag(
      Ros1Bytes(Ros1Connection(1, "/scan") + Ros1Message(1, message.Ros1()) + Ros1Message(1, next.Ros1())));
  BagSource source(bag.path(), {});
  CHECK(ReadAll(source).size() == 2);
  REQUIRE(source.Complaints().size() == 1);
  CHECK(source.Complaints()[0].starts_with("/scan: headers contradict themselves: angle_increment is -0.5000 rad"));
}

TEST_CASE("a bag with several lasers, or none that is wanted, is an error that lists its topics") {
  const std::string two = Ros1Bytes(Ros1Connection(1, "/front") + Ros1At(1) + Ros1Connection(2, "/rear") +
                                    Ros1Message(2, LaserMessage{.sec = 2}.Ros1()));
  CHECK(ErrorOfBag(two) ==
        " has several laser topics: --laser-channel must name one of /front (sensor_msgs/LaserScan in ros1), "
        "/rear (sensor_msgs/LaserScan in ros1); slam_offline maps several robots by '--laser-channel A,B'");
  CHECK(SecondsOf(ReadBag(two, {"/rear"})) == Seconds{2});
  // All that have a message, and no other.
  const std::string three =
      Ros1Bytes(Ros1Connection(1, "/front") + Ros1Connection(2, "/rear") + Ros1Connection(3, "/left") +
                Ros1Connection(4, "/never") + Ros1At(1) + Ros1At(2) + Ros1Message(2, LaserMessage{.sec = 2}.Ros1()) +
                Ros1At(3) + Ros1Message(3, LaserMessage{.sec = 3}.Ros1()));
  CHECK(ErrorOfBag(three).starts_with(
      " has several laser topics: --laser-channel must name one of /front (sensor_msgs/LaserScan in ros1), /left "
      "(sensor_msgs/LaserScan in ros1), /rear (sensor_msgs/LaserScan in ros1)"));
  const std::string other = Ros1Bytes(Ros1Connection(1, "/scan") + Ros1Connection(2, "/im\tage", "sensor_msgs/Image"));
  CHECK(ErrorOfBag(other, {"/other"})
            .ends_with(" named /other; its topics: /im?age (sensor_msgs/Image in ros1), /scan (sensor_msgs/LaserScan "
                       "in ros1); it is cut short or damaged at its end"));  // as one of a recording that was killed
  CHECK(ErrorOfBag(two, {"/raer"}).ends_with("; did you mean /rear?"));
  CHECK(ErrorOfBag(other, {"/skan"}).ends_with("; did you mean /scan?"));
  CHECK(ErrorOfBag(Ros1Bytes("")).ends_with("its topics: none; it is cut short or damaged at its end"));
}

TEST_CASE("scans without stamps are numbered, and that is said") {
  std::string records;
  for (int i = 0; i < 60; ++i) {
    records += Ros1Message(1, LaserMessage{.sec = 0, .ranges = {1.0f, 0.1f * static_cast<float>(i), 3.0f}}.Ros1());
  }
  const Result result = ReadRos1(records);
  REQUIRE(result.scans.size() == 60);
  CHECK(result.scans[59].utime == 59 * 1'000'000);
  CHECK(result.complaints.at(0) ==
        "/scan: 49 of the first 50 scans have the header.stamp of the scan before: the scans "
        "are numbered instead, as if one came every 1 s: times and speeds are not the true ones");
}

TEST_CASE("of several odometries that of the laser's namespace is taken, or none, which is said") {
  const auto ReadWith = [](const std::string& odometry) {
    return ReadBag(Ros1Bytes(Ros1Connection(1, "/a/scan") + Ros1At(1) +
                             Ros1Connection(2, odometry, "nav_msgs/Odometry") +
                             Ros1Connection(3, "/wheels", "nav_msgs/Odometry") + Ros1Message(2, "no odometry") +
                             Ros1Message(3, "nor this")));
  };
  const Result beside = ReadWith("/a/odom");
  CHECK(beside.counts.at("bad_odometry") == 1);
  REQUIRE(beside.notes.size() == 1);
  CHECK(beside.notes[0].starts_with("has odometry (/a/odom), but gives it to no scan: "));
  const Result unknown = ReadWith("/b/odom");
  CHECK(unknown.counts.count("bad_odometry") == 0);
  REQUIRE(unknown.notes.size() == 1);
  CHECK(unknown.notes[0].find("--odometry-topic must name one of /b/odom (nav_msgs/Odometry in ros1), ") !=
        std::string::npos);
}

TEST_CASE("two drivers on one topic are told apart by their frames, and one of them is chosen") {
  std::string bag = Ros1Connection(1, "/scan");
  for (std::uint32_t sec = 1; sec <= 4; ++sec) bag += Ros1At(sec, sec % 2 == 0 ? "/rear" : "front");
  bag = Ros1Bytes(bag + Ros1Message(1, LaserMessage{.sec = 6, .ranges = {1.0f}, .frame = "rear"}.Ros1()));
  const std::string choices = "--laser-frame must name one of front, rear";
  CHECK(ErrorOfBag(bag) == ": /scan: the scans are of several lasers: " + choices);
  CHECK(ErrorOfBag(bag, {"/scan", "font"}) == ": /scan: no scan has the frame font: " + choices);
  const Result front = ReadBag(bag, {"/scan", "front"});
  CHECK(SecondsOf(front) == Seconds{1, 3});
  CHECK(front.counts.at("other_frame") == 3);
  CHECK(front.counts.count("bad_message") == 0);
  CHECK(front.complaints.empty());
  for (const std::string rear : {"rear", "/rear"}) CHECK(SecondsOf(ReadBag(bag, {"/scan", rear})) == Seconds{2, 4});
}

TEST_CASE("what is complained of at the end: a second driver, bad scans, stamps that repeat") {
  std::string second_driver;
  for (std::uint32_t sec = 1; sec <= 60; ++sec) second_driver += Ros1At(sec);
  second_driver += Ros1At(61, "new");
  const std::string degrees = Ros1Message(1, LaserMessage{.angle_min = -90.0f, .angle_increment = 1.0f}.Ros1());
  for (const auto& [records, complaint] :
       {std::pair(second_driver, "/scan: the scans are of several lasers: --laser-frame must name one of las, new"),
        std::pair(Ros1At(1) + degrees, "1 of 2 scans on /scan are left out: angles look like degrees"),
        std::pair(Ros1At(0) + Ros1At(0) + Ros1At(0),
                  "2 of 3 scans on /scan repeat the header.stamp of an earlier scan and are left out")}) {
    const Result result = ReadRos1(records);
    REQUIRE(result.complaints.size() == 1);
    CHECK(result.complaints[0].starts_with(complaint));
  }
  CHECK(ReadRos1(degrees).counts.at("bad_message") == 1);
}

TEST_CASE("a damaged chunk is passed over and counted, its neighbours are read") {
  const auto ReadWith = [&](const std::string& chunk, std::uint32_t size) {
    return ReadRos1(Ros1At(1) + Ros1Chunk(chunk, "bz2", size) + Ros1At(3));
  };
  const std::string good = Pack("bz2", Ros1At(2));
  const std::uint32_t size = SizeOf(Ros1At(2));
  CHECK(SecondsOf(ReadWith(good, size)) == Seconds{1, 2, 3});
  std::string flipped = good;
  flipped[flipped.size() / 2] ^= 4;
  for (const auto& [chunk, said] :
       {std::pair(flipped, size), std::pair(good, size - 1), std::pair(good, size + 1), std::pair(good, 0xffffffffu)}) {
    const Result result = ReadWith(chunk, said);
    CHECK(SecondsOf(result) == Seconds{1, 3});
    CHECK(result.counts.at("bad_chunk") == 1);
    CHECK(result.complaints.size() == 1);
  }
}

TEST_CASE("a chunk of MCAP with a wrong checksum is passed over") {
  const std::string records = McapMessage(1, CdrAt(2));
  const auto ReadWith = [&](std::uint32_t crc) {
    return ReadMcap(McapMessage(1, CdrAt(1)) + McapChunk(records, "", records.size(), crc) +
                    McapChunk(Pack("zstd", records), "zstd", records.size(), crc) + McapMessage(1, CdrAt(3)));
  };
  const auto crc = static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(records.data()), static_cast<uInt>(records.size())));
  for (const std::uint32_t right : {0u, crc}) CHECK(SecondsOf(ReadWith(right)) == Seconds{1, 2, 3});
  CHECK(ReadWith(crc).counts.at("bad_chunk") == 0);
  CHECK(SecondsOf(ReadWith(crc + 1)) == Seconds{1, 3});
  CHECK(ReadWith(crc + 1).counts.at("bad_chunk") == 2);
}

TEST_CASE("sizes that are lies end the reading, and take no memory") {
  const std::string huge = Little(0xfffffff0u);
  for (const std::string& lie : {huge, huge + std::string(100, 'x'), Text("op=\x02") + huge + "few",
                                 Text(huge) + Text("data"), std::string(50, '\0')}) {
    const Result result = ReadRos1(Ros1At(1) + lie);
    CHECK(SecondsOf(result) == Seconds{1});
    CHECK(result.counts.at("truncated") == 1);
  }
  const std::string start = McapBytes("").substr(0, 25) + McapChannel(1, "/scan") + McapMessage(1, CdrAt(1));
  for (const std::uint64_t size : {~std::uint64_t{0}, ~std::uint64_t{0} / 2, std::uint64_t{100000}}) {
    const Result result = ReadBag(start + Little(std::uint8_t{5}) + Little(size) + std::string(30, 'x'));
    CHECK(SecondsOf(result) == Seconds{1});
    CHECK(result.counts.at("truncated") == 1);
  }
  CHECK(ReadMcap(McapChunk("", "zstd", std::uint64_t{1} << 60)).counts.at("bad_chunk") == 1);
}

TEST_CASE("a chunk is read to its end, or up to a size that no recorder writes") {
  const std::string bytes(1000, 'x');
  for (const std::string compression : kCompressionNames) {
    const std::string packed = Pack(compression, bytes);
    const auto unpacked = Decompress({compression, packed, 1000});
    REQUIRE(unpacked);
    CHECK(unpacked->All() == bytes);
    CHECK(Decompress({compression, packed, 999}) == nullptr);
    CHECK(Decompress({compression, packed, 1001}) == nullptr);
    CHECK(Decompress({compression, packed.substr(0, packed.size() - 1), 1000}) == nullptr);
    CHECK(Decompress({compression, packed.substr(0, packed.size() - 1), 1000, true}));
    CHECK(Decompress({compression, packed, kMostChunkBytes + 1, true}) == nullptr);
    CHECK(Decompress({"other", packed, 1000}) == nullptr);
  }
}

TEST_CASE("messages that rosbag2 has compressed one by one are read; what is cut or far too long is counted") {
  const Result result =
      ReadMcap(McapMessage(1, Pack("zstd", CdrAt(1))) + McapMessage(1, Pack("zstd", CdrAt(2)).substr(0, 30)) +
               McapMessage(1, std::string(kMostMessageBytes + 1, 'x')) + McapMessage(1, CdrAt(4)));
  CHECK(SecondsOf(result) == Seconds{1, 4});
  CHECK(result.counts.at("bad_message") == 2);
}

TEST_CASE("bags of another version, or damaged at their beginning, are refused with what mends it") {
  CHECK(ErrorOfBag("#ROSBAG V1.2\n").ends_with("convert it with rosbag fix"));
  CHECK(ErrorOfBag("#ROSBAG V2.0\nrubbish").ends_with("is damaged at its beginning"));
}

TEST_CASE("a bag is a source like any other, and its topic the channel") {
  for (const std::string name : {"lz4.bag", "zstd.mcap", "run.db3"}) {
    CHECK(OpenLaserSource(DataPath(name), {})->Next()->utime == 1'000'000);
    CHECK(OpenLaserSource(DataPath(name), {0, {"/scan"}})->Next()->utime == 1'000'000);
    CHECK(ErrorOf([&] { OpenLaserSource(DataPath(name), {0, {"/odom"}}); }).find("named /odom") != std::string::npos);
  }
}

}  // namespace crsm
