// Looks at a finished run as Foxglove does, with its own client library, and at its MCAP file with its own reader.
//
// usage: node foxglove_client.mjs PORT MAP.png RUN.mcap
// Every message has to be as the published schema says, and the cells of the grids those of the picture. Prints what
// was seen as JSON; ends with a line and exit code 1 where something is wrong.

import {readFileSync} from "node:fs";
import {open} from "node:fs/promises";
import {createRequire} from "node:module";
import path from "node:path";

// The packages are not beside this file, but where NODE_MODULES says.
const load = createRequire(path.join(process.env.NODE_MODULES, "here.js"));
const {FoxgloveClient} = load("@foxglove/ws-protocol");
const {McapIndexedReader} = load("@mcap/core");
const published_schemas = load("@foxglove/schemas/jsonschema");
const Ajv = load("ajv").default;
const {PNG} = load("pngjs");
const WebSocket = load("ws");

const [port, map_path, mcap_path] = process.argv.slice(2);
const PATIENCE_MS = 60000;
const UNEXPLORED = 127;

function fail(text) {
  console.error(text);
  process.exit(1);
}

const ajv = new Ajv({strict: false});
const validators = new Map();

// Against the schema that the viewer sends, and against the one that Foxglove publishes.
function check(schema_name, sent_schema, message) {
  if (!validators.has(schema_name)) {
    const published = published_schemas[schema_name.replace("foxglove.", "")];
    validators.set(schema_name, [ajv.compile(JSON.parse(sent_schema)), ajv.compile(published)]);
  }
  for (const validate of validators.get(schema_name)) {
    if (!validate(message)) fail(`${schema_name}: ${ajv.errorsText(validate.errors)}`);
  }
}

// All that a client is told when it subscribes to every topic, once each.
function subscribeToAll(subprotocol) {
  return new Promise((resolve) => {
    setTimeout(() => fail(`${subprotocol}: not all topics have told something`), PATIENCE_MS).unref();
    const socket = new WebSocket(`ws://127.0.0.1:${port}/`, [subprotocol]);
    const client = new FoxgloveClient({ws: socket});
    const topics = new Map();  // by subscription
    const messages = {};       // by topic
    client.on("error", (error) => fail(`${subprotocol}: ${error}`));
    client.on("advertise", (channels) => {
      for (const channel of channels) topics.set(client.subscribe(channel.id), channel);
    });
    client.on("message", ({subscriptionId, timestamp, data}) => {
      const {topic, schemaName, schema, encoding, schemaEncoding} = topics.get(subscriptionId);
      if (encoding !== "json" || schemaEncoding !== "jsonschema") fail(`${topic}: ${encoding}, ${schemaEncoding}`);
      const message = JSON.parse(new TextDecoder().decode(data));
      check(schemaName, schema, message);
      const {sec, nsec} = message.timestamp;
      if (BigInt(sec) * 1_000_000_000n + BigInt(nsec) !== timestamp) fail(`${topic}: two times`);
      messages[topic] = message;
      if (Object.keys(messages).length < topics.size) return;
      client.close();
      resolve(messages);
    });
  });
}

// Puts the grids together; their explored cells have to be those of the picture, its rows being upside down.
function compareWithPicture(grids, what) {
  const png = PNG.sync.read(readFileSync(map_path));
  const yaml = readFileSync(map_path.replace(/png$/, "yaml"), "utf8");
  const cell_size_m = Number(/resolution: (\S+)/.exec(yaml)[1]);
  const origin_m = /origin: \[(\S+), (\S+),/.exec(yaml).slice(1);
  const origin = origin_m.map((metres) => Math.round(parseFloat(metres) / cell_size_m));
  let num_explored = 0;
  let num_equal = 0;
  for (const grid of grids) {
    const cells = Buffer.from(grid.data, "base64");
    const x0 = Math.round(grid.pose.position.x / cell_size_m);
    const y0 = Math.round(grid.pose.position.y / cell_size_m);
    cells.forEach((cell, index) => {
      if (cell === UNEXPLORED) return;
      const x = x0 + (index % grid.column_count) - origin[0];
      const y = y0 + Math.floor(index / grid.row_stride) - origin[1];
      ++num_explored;
      const pixel = png.data[4 * ((png.height - 1 - y) * png.width + x)];
      if (x >= 0 && x < png.width && y >= 0 && y < png.height && pixel === cell) ++num_equal;
    });
  }
  let num_in_picture = 0;
  for (let at = 0; at < png.data.length; at += 4) num_in_picture += png.data[at] !== UNEXPLORED;
  if (num_equal !== num_explored || num_explored !== num_in_picture) {
    fail(`${what}: ${num_equal} of ${num_explored} cells are those of ${num_in_picture} in ${map_path}`);
  }
  return num_explored;
}

const isGrid = ([topic]) => topic.startsWith("/map/");

async function readMcap() {
  const file = await open(mcap_path);
  const readable = {
    size: async () => BigInt((await file.stat()).size),
    read: async (offset, size) => {
      const bytes = new Uint8Array(Number(size));
      await file.read(bytes, 0, bytes.length, Number(offset));
      return bytes;
    },
  };
  const reader = await McapIndexedReader.Initialize({readable});
  const last = {};
  const counts = {};
  for await (const {channelId, data} of reader.readMessages()) {
    const channel = reader.channelsById.get(channelId);
    const schema = reader.schemasById.get(channel.schemaId);
    const message = JSON.parse(new TextDecoder().decode(data));
    check(schema.name, new TextDecoder().decode(schema.data), message);
    last[channel.topic] = message;
    counts[channel.topic] = (counts[channel.topic] ?? 0) + 1;
  }
  await file.close();
  const num_told = Object.values(counts).reduce((sum, count) => sum + count, 0);
  if (reader.statistics.messageCount !== BigInt(num_told)) fail(`${mcap_path}: its statistics count otherwise`);
  return {last, counts};
}

const seen = {};
for (const subprotocol of ["foxglove.sdk.v1", "foxglove.websocket.v1"]) {
  const messages = await subscribeToAll(subprotocol);
  const grids = Object.entries(messages).filter(isGrid).map(([, grid]) => grid);
  seen[subprotocol] = {topics: Object.keys(messages).sort(), cells: compareWithPicture(grids, subprotocol)};
}
const {last, counts} = await readMcap();
seen.mcap = {counts, cells: compareWithPicture(Object.entries(last).filter(isGrid).map(([, grid]) => grid), mcap_path)};
console.log(JSON.stringify(seen));
process.exit(0);
