// What the viewer tells a page, as services/map_viewer/page_feed.hpp describes it.

export const SUBPROTOCOL = "crsm.view.v1";
export const STATES = ["START", "OK", "LOST", "DEGENERATE", "FLOATING", "NO RAYS"];  // as page_feed.hpp has them

// Whether a scan in this state has a pose: a guess is none.
export const hasPose = (state) => state !== "LOST" && state !== "NO RAYS";

// Reads numbers one after the other.
class Reader {
  constructor(buffer, begin, size) {
    this.view = new DataView(buffer, begin, size);
    this.at = 0;
  }
  skip(size) { return (this.at += size) - size; }
  u8() { return this.view.getUint8(this.skip(1)); }
  u16() { return this.view.getUint16(this.skip(2), true); }
  i16() { return this.view.getInt16(this.skip(2), true); }
  i32() { return this.view.getInt32(this.skip(4), true); }
  u32() { return this.view.getUint32(this.skip(4), true); }
  i64() { return this.view.getBigInt64(this.skip(8), true); }
  f32() { return this.view.getFloat32(this.skip(4), true); }
  f64() { return this.view.getFloat64(this.skip(8), true); }
  bytes(size) { return new Uint8Array(this.view.buffer, this.view.byteOffset + this.skip(size), size); }
  copy(size) { return this.bytes(size).slice().buffer; }
  list(count, read) { return Array.from({length: count}, () => read()); }
}

function readMap(reader) {
  return {
    kind: "map", anew: reader.u8() === 1, epoch: reader.i64(), version: reader.i64(), num_left: reader.u32(),
    cell_size_m: reader.f64(),
    tiles: reader.list(reader.u16(), () => ({
      x: reader.i16(), y: reader.i16(), whole: reader.u8() === 1, runs: reader.bytes(reader.u16()),
    })),
  };
}

function readRobot(reader) {
  return {
    kind: "robot", utime: reader.i64(), state: STATES[reader.u8()],
    trajectory: reader.i32(), floating: reader.u8() === 1,
    x_m: reader.f64(), y_m: reader.f64(), yaw_rad: reader.f64(), fitness: reader.f32(),
    covariance: {xx: reader.f32(), xy: reader.f32(), yy: reader.f32(), yaw: reader.f32()},
    axis: {x: reader.f32(), y: reader.f32()},
    rays: reader.list(reader.u16(), () => ({angle_rad: reader.f32(), range_m: reader.f32()})),
    critical: reader.list(reader.u16(), () => reader.u16()),
  };
}

const readPoints = (reader) => reader.list(reader.u32(), () => ({
  scan: reader.u32(), x_m: reader.f32(), y_m: reader.f32(), state: STATES[reader.u8()], trajectory: reader.i32(),
}));

const readPath = (reader) => ({kind: "path", generation: reader.u32(), first: reader.u32(), points: readPoints(reader)});

function readThen(reader) {
  return {
    kind: "then", is_end: reader.u8() === 1, loops_closed: reader.u32(),
    loops: reader.list(reader.u16(), () => [reader.f32(), reader.f32(), reader.f32(), reader.f32()]), points: readPoints(reader),
  };
}

function readSamples(reader) {
  return {
    kind: "samples",
    samples: reader.list(reader.u32(), () => ({
      time_s: reader.f64(), fitness: reader.f32(), state: STATES[reader.u8()],
    })),
  };
}

function readTimeline(reader) {
  const num = reader.u32();
  const f32 = () => new Float32Array(reader.copy(4 * num));
  return {
    kind: "timeline", num, time_s: new Float64Array(reader.copy(8 * num)), x_m: f32(), y_m: f32(), yaw_rad: f32(),
    first_x_m: f32(), first_y_m: f32(), first_yaw_rad: f32(), fitness: f32(), axis_rad: f32(), trajectory: new Int32Array(reader.copy(4 * num)),
    state: new Uint8Array(reader.copy(num)),
  };
}

const READERS = {
  1: readMap, 2: readRobot, 3: readPath, 4: readSamples, 6: readTimeline, 7: readThen,
  5: (reader) => ({kind: "info", ...JSON.parse(new TextDecoder().decode(reader.bytes(reader.view.byteLength)))}),
};

// The records of a message.
export function* readRecords(buffer) {
  const view = new DataView(buffer);
  for (let at = 0; at < view.byteLength;) {
    const size = view.getUint32(at + 1, true);
    yield READERS[view.getUint8(at)](new Reader(buffer, at + 5, size));
    at += 5 + size;
  }
}

// Applies the runs of a tile (map_tile_t) to its cells.
export function unpackRuns(runs, cells) {
  let cell = 0;
  for (let at = 0; at < runs.length;) {
    cell += runs[at] * 256 + runs[at + 1];
    const count = runs[at + 2] * 256 + runs[at + 3];
    cells.set(runs.subarray(at + 4, at + 4 + count), cell);
    cell += count;
    at += 4 + count;
  }
}

export const readToken = () => new URLSearchParams(location.hash.slice(1)).get("token") ?? "";

// Why the viewer does not take a connection, which no browser tells: the token, or no such piece; else nothing.
async function findRefusal(query) {
  const answer = await fetch(`files?${query}`).catch(() => null);
  if (answer?.status === 404) return "no such piece";
  return answer?.status !== 401 ? "" : query.get("token") ? "token wrong" : "token missing";
}

// Keeps a connection to the feed of a robot, and tells `model` what comes. After a loss it goes on where it was.
export class Connection {
  // piece: of the map of a finished run; 0 is the one that the viewer shows.
  constructor(robot, piece, model) {
    this.robot = robot;
    this.piece = piece;
    this.model = model;
    this.pause_ms = 250;
    this.open();
  }

  // Says something to the viewer, if it is there.
  say(text) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(text);
  }

  // Of what is looked at, for a request.
  query(others = {}) { return new URLSearchParams({robot: this.robot, piece: this.piece, token: readToken(), ...others}); }

  // Goes on with another piece.
  showPiece(piece) {
    this.piece = piece;
    this.model.cursor = {epoch: 0n, version: 0n};
    this.socket.onclose = null;
    this.socket.close();
    this.open();
  }

  open() {
    const query = this.query(this.model.then ? {epoch: 0n, version: 0n} : this.model.cursor);
    const socket = new WebSocket(`ws://${location.host}/live?${query}`, SUBPROTOCOL);
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    let was_open = false;
    socket.onopen = () => {
      was_open = true;
      this.pause_ms = 250;
      this.model.setConnected(true);
    };
    socket.onmessage = ({data}) => {
      try {
        for (const record of readRecords(data)) this.model.take(record);
      } catch (error) {  // not whole: what is missing comes with the next connection
        console.error(error);
        socket.close();
      }
    };
    socket.onclose = async () => {
      this.model.setConnected(false, was_open ? "" : await findRefusal(query));
      setTimeout(() => this.open(), this.pause_ms);
      this.pause_ms = Math.min(this.pause_ms * 1.5, 2000);
    };
  }
}
