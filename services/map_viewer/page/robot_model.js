// All that the page knows of one robot, and who is to be told when it changes.

import {MapModel} from "./map_model.js";
import {LEAST_MOVE_M, Timeline} from "./timeline.js";
import {hasPose} from "./wire.js";

const MOST_SAMPLES = 1024;
const LONGEST_STEP_M = 10;  // of the way: what is longer is none
const MOST_TAIL = 4000;
const TAIL_STEP_M = 0.1;

function wayOf(points) {
  let [way_m, last] = [0, null];
  for (const point of points) {
    if (!hasPose(point.state)) continue;
    const step_m = last?.trajectory === point.trajectory ? Math.hypot(point.x_m - last.x_m, point.y_m - last.y_m) : 0;
    if (step_m < LONGEST_STEP_M) way_m += step_m;
    last = point;
  }
  return way_m;
}

export class RobotModel extends EventTarget {
  constructor() {
    super();
    this.map = new MapModel();
    this.cursor = {epoch: 0n, version: 0n};
    this.num_loaded = 0;   // tiles, of the map as it was at first
    this.num_left = 0;     // of them, still to come
    this.robot = null;
    this.was_found = false;  // whether it ever had a pose
    this.path = [];
    this.path_generation = 0;
    this.is_another_map = false;  // than the one that the path lies on
    this.moved = [];  // what the last correction moved: {from, to} of places of the path
    this.moved_m = 0;  // by how much at most, until it is told
    this.is_corrected = false;  // and it is not told yet
    this.loops_told = null;     // loops that were closed then
    this.way_m = 0;  // along the path
    this.lines = new Map();  // the same by trajectory: robots of a fleet come in turn
    this.tail = [];  // where the robot was seen since the path was told last
    this.samples = [];
    this.timeline = null;  // of a run that has ended
    this.is_old = false;   // whether the robot is where it was known last, and nobody knows where it is
    this.scan = null;      // of the moment of the timeline, as robot
    this.wants_then = true;  // whether the map is to be as it was known at the moment
    this.then = null;        // {loops, loops_closed, points} as they were known then; null where the last ones are shown
    this.info = {services: [], loops: [], marks: [], robots: [""], robot: ""};
    this.info_at_ms = 0;   // when it came
    this.fleet = null;     // its robots, if it is one: fleet.js
    this.num_joins = 0;    // of them that were told so far
    this.joined_at_ms = -Infinity;
    this.num_news = null;  // that were told so far
    this.connected = false;
    this.connection_at_ms = performance.now();  // when `connected` became what it is
    this.refusal = "";  // why the viewer takes no connection, if it says so
    this.trouble = "";     // what the page could not show, if anything
    this.changed = true;  // since it was drawn
  }

  tell(type, detail) {
    this.changed = true;
    this.dispatchEvent(new CustomEvent(type, {detail}));
  }

  setConnected(connected, refusal = "") {
    if (connected !== this.connected) this.connection_at_ms = performance.now();
    this.connected = connected;
    this.refusal = refusal;
    if (connected) {
      this.samples = [];  // they come again
      this.trouble = "";
    }
    this.tell("connection");
  }

  take(record) {
    this[`take_${record.kind}`](record);
    this.tell(record.kind);
  }

  // How much of the map has come, 0 to 1; null where all has, or nothing.
  loadedShare() {
    return this.cursor.version === 0n && this.num_left > 0 ? this.num_loaded / (this.num_loaded + this.num_left) : null;
  }

  take_map({anew, epoch, version, num_left, cell_size_m, tiles}) {
    this.num_loaded = (anew ? 0 : this.num_loaded) + tiles.length;
    this.num_left = num_left;
    if (anew) {
      this.then = null;
      this.map.clear();
      this.cursor = {epoch: 0n, version: 0n};
      this.is_another_map = true;
      this.loops_told = null;
    }
    this.map.cell_size_m = cell_size_m;
    for (const tile of tiles) this.map.take(tile);
    if (num_left > 0) return;
    const corrected = this.cursor.epoch !== 0n && epoch !== this.cursor.epoch;
    this.cursor = {epoch, version};
    this.is_corrected ||= corrected;  // what it was comes with the next info
    this.tell("whole");
  }

  take_robot(robot) {
    if (![robot.x_m, robot.y_m, robot.yaw_rad].every(Number.isFinite)) return;  // it is nowhere
    if (this.timeline) {
      this.scan = {...robot, ...(this.shows_then && this.timeline.isAt(robot) && this.timeline.placeThen())};
      if (this.timeline.isAt(robot)) this.robot = this.scan;
      return;
    }
    this.robot = robot;
    this.was_found ||= hasPose(robot.state);
    const last = this.tail.at(-1);
    if (!hasPose(robot.state)) return;
    if (last && Math.hypot(robot.x_m - last.x_m, robot.y_m - last.y_m) < TAIL_STEP_M) return;
    this.tail.push({x_m: robot.x_m, y_m: robot.y_m, state: robot.floating ? "FLOATING" : "OK"});
    if (this.tail.length > MOST_TAIL) this.tail.shift();
  }

  // Whether nobody has ever known where the robot is: its pose is none.
  get is_nowhere() {
    const {robot, timeline, samples} = this;
    return Boolean(robot && !timeline && !this.was_found && !hasPose(robot.state)) && !samples.some(({state}) => hasPose(state));
  }

  take_path({generation, first, points}) {
    const before = this.path;
    if (generation !== this.path_generation || first < this.path.length) {
      this.path = [];
      this.way_m = 0;
      this.lines.clear();
    }
    this.path_generation = generation;
    for (const point of points) {
      if (!this.lines.has(point.trajectory)) this.lines.set(point.trajectory, []);
      const line = this.lines.get(point.trajectory);
      const last = line.at(-1);
      const step_m = last ? Math.hypot(point.x_m - last.x_m, point.y_m - last.y_m) : 0;
      if (hasPose(point.state) && step_m < LONGEST_STEP_M) this.way_m += step_m;
      this.path.push(point);
      line.push(point);
    }
    if (this.path !== before) this.compare(before);
    const end = this.path.at(-1);
    if (!end) return;
    const ways_m = this.tail.map(({x_m, y_m}) => Math.hypot(x_m - end.x_m, y_m - end.y_m));
    this.tail.splice(0, 1 + ways_m.lastIndexOf(Math.min(...ways_m)));
  }

  // What of the path a correction has moved, by the numbers of the scans; on another map nothing is where it was.
  compare(before) {
    if (this.is_another_map) this.moved = [];
    const moved = [];
    let most_m = 0;
    for (let old = 0, now = 0; !this.is_another_map && old < before.length && now < this.path.length;) {
      const [from, to] = [before[old], this.path[now]];
      const way_m = Math.hypot(to.x_m - from.x_m, to.y_m - from.y_m);
      const has_place = [from, to].every(({state}) => hasPose(state) && state !== "FLOATING");
      if (from.scan === to.scan && has_place && way_m > LEAST_MOVE_M) {
        moved.push({from, to});
        most_m = Math.max(most_m, way_m);
      }
      if (from.scan <= to.scan) ++old;
      if (to.scan <= from.scan) ++now;
    }
    this.is_another_map = false;
    if (moved.length === 0) return;  // the path was thinned
    this.moved = moved;
    this.moved_m = most_m;
  }

  take_samples({samples}) { this.samples = [...this.samples, ...samples].slice(-MOST_SAMPLES); }

  take_timeline(record) {
    this.timeline = record.num > 0 ? new Timeline(record) : null;
    this.tail = [];
    if (this.timeline) this.robot = this.timeline.robot();
  }

  take_info(info) {
    this.info = {services: [], loops: [], marks: [], ...info};
    this.info_at_ms = performance.now();
    if (this.info.live !== false) this.timeline = null;
    this.tellCorrection(info.loops_closed ?? 0);
    const {number, text} = info.news ?? {number: 0, text: ""};
    if (this.num_news !== null && number > this.num_news) this.tell("news", text);
    this.num_news = number;
  }

  // A map is drawn anew not only where a loop is closed: also where one is rejected, or another piece is shown.
  tellCorrection(loops_closed) {
    const [is_corrected, loops_before] = [this.is_corrected, this.loops_told];
    if (is_corrected || loops_before === null) this.loops_told = loops_closed;
    if (!is_corrected) return;
    this.tell("corrected", {is_loop: loops_closed > loops_before, most_m: this.moved_m});
    this.is_corrected = false;
    this.moved_m = 0;
  }

  // Whether what was known at the moment is shown, and not what is known at the end.
  get shows_then() { return Boolean(this.timeline && this.info.knows_then && this.wants_then && !this.timeline.is_at_end); }

  take_then({is_end, ...then}) { this.then = is_end ? null : then; }

  // The path up to the moment as it was known then; its last scans are where they were matched.
  pathThen() {
    const {points} = this.then;
    return [...points, ...this.timeline.pointsThen((points.at(-1)?.scan ?? -1) + 1)];
  }

  // How many scans up to the moment have become what, by the names of summary.json, and what else was known then.
  factsThen() {
    const counts = Object.fromEntries(["LOST", "FLOATING", "NO RAYS"].map((state) => [state, 0]));
    for (let i = 0; i <= this.timeline.at; ++i) ++counts[this.timeline.stateThen(i)];
    return {scans: this.timeline.at + 1, lost: counts.LOST, floating: counts.FLOATING, without_rays: counts["NO RAYS"],
            loops_closed: this.then.loops_closed, loops: this.then.loops, way_m: wayOf(this.pathThen())};
  }

  // Shows the scan with this number of a run that has ended.
  goTo(number) {
    if (!this.timeline) return;
    this.timeline.goTo(number);
    this.robot = {...this.timeline.robot(), ...(this.shows_then && this.timeline.placeThen())};
    if (this.scan && this.timeline.isAt(this.scan)) this.take_robot(this.scan);
    this.tell("moment", this.timeline.at);
  }
}
