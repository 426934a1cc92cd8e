// A run that has ended, scan by scan, and the moment of it that is shown.

import {STATES, hasPose} from "./wire.js";

const FLOATING = STATES.indexOf("FLOATING");
export const LEAST_MOVE_M = 0.05;  // a cell: less is not seen
const LONGEST_PAUSE_S = 1;  // of what is played: nobody waits through the night between two drives
const NO_COVARIANCE = {xx: 0, xy: 0, yy: 0, yaw: 0};

export class Timeline {
  constructor(record) {
    Object.assign(this, record);
    this.at = this.num - 1;  // number of the scan that is shown
    this.clock_s = new Float64Array(this.num);  // since the begin, without pauses
    for (let i = 1; i < this.num; ++i) {
      const step_s = this.time_s[i] - this.time_s[i - 1];
      this.clock_s[i] = this.clock_s[i - 1] + Math.min(LONGEST_PAUSE_S, Math.max(0, Number.isFinite(step_s) ? step_s : 0));
    }
  }

  get duration_s() { return this.clock_s[this.num - 1]; }
  get is_at_end() { return this.at === this.num - 1; }

  goTo(number) { this.at = Math.max(0, Math.min(this.num - 1, Math.round(number) || 0)); }

  // The last scan that was taken when so much of the run was played.
  find(clock_s) {
    let [low, high] = [0, this.num - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.clock_s[middle] <= clock_s) low = middle; else high = middle - 1;
    }
    return low;
  }

  stateOf(number) { return STATES[this.state[number]]; }

  // How many of the scans in a part of the run, given by shares of it, were in a state: 0 to 1.
  shareOf(state, from, to) {
    const wanted = STATES.indexOf(state);
    const first = Math.floor(from * this.num);
    const end = Math.max(first + 1, Math.floor(to * this.num));
    let found = 0;
    for (let i = first; i < end; ++i) found += this.state[i] === wanted;
    return found / (end - first);
  }

  // Whether a robot, as the viewer tells it, is that of the moment.
  isAt({utime}) { return Math.abs(Number(utime) * 1e-6 - this.time_s[this.at]) < 1e-5; }

  // What is known of the moment before its scan has come.
  robot() {
    const {at} = this;
    const state = this.stateOf(at);
    const axis_rad = this.axis_rad[at];  // NaN where there is none
    return {
      utime: BigInt(Math.round(this.time_s[at] * 1e6)), state: state === "FLOATING" ? "OK" : state,
      trajectory: this.trajectory[at], floating: this.state[at] === FLOATING, x_m: this.x_m[at], y_m: this.y_m[at],
      yaw_rad: this.yaw_rad[at], fitness: this.fitness[at], covariance: NO_COVARIANCE,
      axis: Number.isFinite(axis_rad) ? {x: Math.cos(axis_rad), y: Math.sin(axis_rad)} : {x: 0, y: 0}, rays: [], critical: [],
    };
  }

  // In which state a scan was when it was matched: what floated may be joined later, and another piece shown.
  stateThen(number) {
    const state = this.stateOf(number);
    if (hasPose(state) && !Number.isFinite(this.first_x_m[number])) return "FLOATING";
    return state === "FLOATING" ? "OK" : state;
  }

  // Where the robot was known to be at the moment: where it was matched, or the last scan before that was.
  placeThen() {
    let {at} = this;
    while (at > 0 && !Number.isFinite(this.first_x_m[at])) --at;
    if (!Number.isFinite(this.first_x_m[at])) return {};
    return {x_m: this.first_x_m[at], y_m: this.first_y_m[at], yaw_rad: this.first_yaw_rad[at],
            floating: this.stateThen(this.at) === "FLOATING"};
  }

  // Scans up to the moment, from one of them on, where they were matched.
  pointsThen(first) {
    const points = [];
    for (let scan = first; scan <= this.at; ++scan) {
      if (!Number.isFinite(this.first_x_m[scan])) continue;
      points.push({scan, x_m: this.first_x_m[scan], y_m: this.first_y_m[scan], state: "OK", trajectory: this.trajectory[scan]});
    }
    return points;
  }

  // The fitness of the scans up to the moment, as samples.
  samples(most) {
    const first = Math.max(0, this.at + 1 - most);
    return Array.from({length: this.at + 1 - first}, (_, i) => ({
      time_s: this.time_s[first + i], fitness: this.fitness[first + i], state: this.stateOf(first + i),
    }));
  }

  // The scan that was taken nearest to a place, if one was within so many metres.
  nearest(x_m, y_m, within_m, is_then = false) {
    const [xs, ys] = is_then ? [this.first_x_m, this.first_y_m] : [this.x_m, this.y_m];
    let [nearest, nearest_m2] = [null, within_m * within_m];
    for (let i = 0; i < this.num; ++i) {
      const distance_m2 = (xs[i] - x_m) ** 2 + (ys[i] - y_m) ** 2;
      if (distance_m2 < nearest_m2 && hasPose(this.stateOf(i))) [nearest, nearest_m2] = [i, distance_m2];
    }
    return nearest;
  }

  // Where scans lie elsewhere than they were matched first: {scan, from, to}, one in so many metres.
  moved(step_m) {
    const moved = [];
    let last = {x_m: Infinity, y_m: Infinity};
    for (let scan = 0; scan < this.num; ++scan) {
      const to = {x_m: this.x_m[scan], y_m: this.y_m[scan]};
      const from = {x_m: this.first_x_m[scan], y_m: this.first_y_m[scan]};
      const way_m = Math.hypot(to.x_m - from.x_m, to.y_m - from.y_m);  // NaN where it was matched nowhere
      if (!(way_m > LEAST_MOVE_M) || !hasPose(this.stateOf(scan)) || this.state[scan] === FLOATING) continue;
      if (Math.hypot(to.x_m - last.x_m, to.y_m - last.y_m) < step_m) continue;
      moved.push({scan, from, to});
      last = to;
    }
    return moved;
  }

  // The path up to the moment, as points that are so far apart.
  points(step_m) {
    const points = [];
    for (let scan = 0; scan <= this.at; ++scan) {
      const last = points.at(-1);
      const point = {x_m: this.x_m[scan], y_m: this.y_m[scan], state: this.stateOf(scan)};
      if (!last || Math.hypot(point.x_m - last.x_m, point.y_m - last.y_m) >= step_m) points.push(point);
    }
    return points;
  }

  // Where something happened: {at, kind}.
  marks(info) {
    const marks = (info.breaks ?? []).map(({scan, joined}) => ({at: scan, kind: joined ? "joined" : "break"}));
    for (const [x0, y0, x1, y1] of info.loops) {
      const at = this.nearest(x1, y1, 1);
      if (at !== null) marks.push({at, kind: "loop"});
    }
    return marks;
  }
}
