// Writes a drive as MCAP files by their own library, and its messages in CDR for write_rosbag2.py.
//
// usage: node write_mcap.mjs SWEEPS.json OUT_DIR
// SWEEPS.json: [{sec, nsec, angle_min, angle_increment, ranges, pose, robot, mounting}, ...]. The packages are where NODE_MODULES says.

import {execFileSync} from "node:child_process";
import {readFileSync, writeFileSync} from "node:fs";
import {createRequire} from "node:module";
import path from "node:path";

const load = createRequire(path.join(process.env.NODE_MODULES, "here.js"));
const {McapWriter} = load("@mcap/core");
const {MessageWriter} = load("@foxglove/rosmsg2-serialization");
const {ros2humble: definitions} = load("@foxglove/rosmsg-msgs-common");

const [sweeps_path, out] = process.argv.slice(2);
const sweeps = JSON.parse(readFileSync(sweeps_path, "utf8"));

// A definition and all that it is made of, as MessageWriter wants them.
function withParts(type, seen = new Map()) {
  if (seen.has(type)) return [...seen.values()];
  seen.set(type, definitions[type]);
  for (const part of definitions[type].definitions) if (part.isComplex) withParts(part.type, seen);
  return [...seen.values()];
}
const laser_writer = new MessageWriter(withParts("sensor_msgs/LaserScan"));
const odometry_writer = new MessageWriter(withParts("nav_msgs/Odometry"));
const transforms_writer = new MessageWriter(withParts("tf2_msgs/TFMessage"));

const headerOf = ({sec, nsec}, frame_id) => ({stamp: {sec, nanosec: nsec}, frame_id});

function encodeLaser(sweep) {
  const {angle_min, angle_increment, ranges} = sweep;
  return laser_writer.writeMessage({
    header: headerOf(sweep, "laser"), angle_min, angle_increment, angle_max: 0, time_increment: 0, scan_time: 0,
    range_min: 0, range_max: 1000, ranges, intensities: ranges.map(() => 47),
  });
}

function encodeOdometry(sweep) {
  const [px, py, pz, w, x, y, z] = sweep.pose;
  const zero = {x: 0, y: 0, z: 0};
  return odometry_writer.writeMessage({
    header: headerOf(sweep, "odom"), child_frame_id: "base_link",
    pose: {pose: {position: {x: px, y: py, z: pz}, orientation: {x, y, z, w}}, covariance: new Array(36).fill(0)},
    twist: {twist: {linear: zero, angular: zero}, covariance: new Array(36).fill(0)},
  });
}

// Where the robot stands by its wheels, and the laser on the robot. The laser is told again and again.
function encodeTransforms(sweep) {
  const transform = (parent, child, [x, y, yaw]) => ({
    header: headerOf(sweep, parent), child_frame_id: child,
    transform: {translation: {x, y, z: 0.1}, rotation: {x: 0, y: 0, z: Math.sin(yaw / 2), w: Math.cos(yaw / 2)}},
  });
  return transforms_writer.writeMessage({
    transforms: [transform("odom", "base_footprint", sweep.robot), transform("base_footprint", "base_link", [0, 0, 0]),
                 transform("base_link", "laser", sweep.mounting)],
  });
}

function encodeJson({sec, nsec, angle_min, angle_increment, ranges}) {
  const none = {x: 0, y: 0, z: 0};
  return new TextEncoder().encode(JSON.stringify({
    timestamp: {sec, nsec}, frame_id: "laser", pose: {position: none, orientation: {...none, w: 1}},
    start_angle: angle_min, end_angle: angle_min + angle_increment * (ranges.length - 1), ranges, intensities: [],
  }));
}

// One after the other in memory.
class Buffered {
  pieces = [];
  length = 0n;
  position() {
    return this.length;
  }
  async write(bytes) {
    this.pieces.push(Buffer.from(bytes));
    this.length += BigInt(bytes.length);
  }
}

const cdr = {
  profile: "ros2", topics: [
    ["/scan", "sensor_msgs/msg/LaserScan", "ros2msg", "cdr", encodeLaser],
    ["/odom", "nav_msgs/msg/Odometry", "ros2msg", "cdr", encodeOdometry],
  ],
};
const tf = {
  profile: "ros2", topics: [
    ["/scan", "sensor_msgs/msg/LaserScan", "ros2msg", "cdr", encodeLaser],
    ["/tf", "tf2_msgs/msg/TFMessage", "ros2msg", "cdr", encodeTransforms],
  ],
};
const json = {profile: "", topics: [["/scan", "foxglove.LaserScan", "jsonschema", "json", encodeJson]]};

async function writeMcap(name, {profile, topics}, options) {
  const writable = new Buffered();
  const writer = new McapWriter({writable, chunkSize: 100000, ...options});
  await writer.start({profile, library: "a test"});
  const channels = [];
  for (const [topic, type, encoding, messageEncoding] of topics) {
    const schemaId = await writer.registerSchema({name: type, encoding, data: new TextEncoder().encode("{}")});
    channels.push(await writer.registerChannel({schemaId, topic, messageEncoding, metadata: new Map()}));
  }
  for (const [sequence, sweep] of sweeps.entries()) {
    const logTime = BigInt(sweep.sec) * 1_000_000_000n + BigInt(sweep.nsec);
    for (const [index, [topic, , , , encode]] of topics.entries()) {
      if (topic === "/odom" && !sweep.pose) continue;
      const data = encode(sweep);
      await writer.addMessage({channelId: channels[index], sequence, logTime, publishTime: logTime, data});
    }
  }
  await writer.end();
  writeFileSync(path.join(out, name), Buffer.concat(writable.pieces));
}

const by = (program) => (bytes) =>
  ({compression: program, compressedData: execFileSync(program, ["-c", "-q"], {input: bytes, maxBuffer: 1 << 30})});

await writeMcap("chunks.mcap", cdr, {});
await writeMcap("lz4.mcap", cdr, {compressChunk: by("lz4")});
await writeMcap("zstd.mcap", cdr, {compressChunk: by("zstd")});
await writeMcap("no_chunks.mcap", cdr, {useChunks: false});
await writeMcap("no_summary.mcap", cdr, {
  useStatistics: false, useSummaryOffsets: false, repeatSchemas: false, repeatChannels: false, useMessageIndex: false,
  useChunkIndex: false,
});
await writeMcap("json.mcap", json, {});
await writeMcap("tf.mcap", tf, {compressChunk: by("zstd")});

const messages = sweeps.map((sweep) => ({
  time: Number(sweep.sec) * 1e9 + sweep.nsec, scan: Buffer.from(encodeLaser(sweep)).toString("base64"),
  odom: sweep.pose && Buffer.from(encodeOdometry(sweep)).toString("base64"),
  tf: sweep.pose && Buffer.from(encodeTransforms(sweep)).toString("base64"),
}));
writeFileSync(path.join(out, "cdr.json"), JSON.stringify(messages));
