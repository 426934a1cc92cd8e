// What is drawn over the map. All lengths are metres: the context's unit is a metre, y up; `pixel` is a pixel's size.

import {hasPose} from "./wire.js";

const TAU = 2 * Math.PI;
const LONGEST_STEP_M = 10;  // of the path; behind a longer one something was not seen
const MOVED_STEP_PX = 12;
const FLOATING_DASH_PX = [7, 5];  // what is not joined to the map
const UNKNOWN_M2 = 1e4;  // variance of a position of which nothing is known
export const CHI_95 = Math.sqrt(5.991);  // an ellipse of so many sigmas holds 95 % in two dimensions

function circle(context, x, y, radius) {
  context.beginPath();
  context.arc(x, y, radius, 0, TAU);
}

export function drawGrid(context, {x0, y0, x1, y1}, pixel, colours) {
  const step = [0.5, 1, 2, 5, 10, 20, 50, 100, 200].find((metres) => metres / pixel > 36) ?? 500;
  context.lineWidth = pixel;
  for (const [every, colour] of [[step, colours.grid], [5 * step, colours.grid_strong]]) {
    context.strokeStyle = colour;
    context.beginPath();
    for (let x = Math.ceil(x0 / every) * every; x <= x1; x += every) {
      context.moveTo(x, y0);
      context.lineTo(x, y1);
    }
    for (let y = Math.ceil(y0 / every) * every; y <= y1; y += every) {
      context.moveTo(x0, y);
      context.lineTo(x1, y);
    }
    context.stroke();
  }
}

const isBeside = (from, to, {x0, y0, x1, y1}) =>
  Math.max(from.x_m, to.x_m) < x0 || Math.min(from.x_m, to.x_m) > x1 ||
  Math.max(from.y_m, to.y_m) < y0 || Math.min(from.y_m, to.y_m) > y1;

// The line through points that float, or through those that do not: no finer than a pixel, and only where it is in the
// window: most of a frame would be spent on the rest of a long path.
function traceLine(context, lists, floating, window_m, pixel) {
  let last = null;
  let is_at_last = false;
  for (const points of lists) {
    for (const point of points) {
      if (!hasPose(point.state)) continue;
      if ((point.state === "FLOATING") !== floating) {
        last = null;  // nobody knows what lies between
        continue;
      }
      const step_m = last ? Math.hypot(point.x_m - last.x_m, point.y_m - last.y_m) : Infinity;
      if (step_m < pixel) continue;
      const is_drawn = step_m <= LONGEST_STEP_M && !isBeside(last, point, window_m);
      if (is_drawn && !is_at_last) context.moveTo(last.x_m, last.y_m);
      if (is_drawn) context.lineTo(point.x_m, point.y_m);
      is_at_last = is_drawn;
      last = point;
    }
  }
}

// tail: where the robot was seen behind the end of the path.
export function drawPath(context, points, tail, window_m, pixel, colours, with_floating) {
  if (points.length === 0) return;
  context.lineWidth = 2 * pixel;
  context.lineJoin = "round";
  context.globalAlpha = 0.85;
  for (const floating of with_floating ? [false, true] : [false]) {
    context.strokeStyle = floating ? colours.floating : colours.path;
    context.setLineDash(floating ? FLOATING_DASH_PX.map((px) => px * pixel) : []);
    context.beginPath();
    traceLine(context, [points, tail], floating, window_m, pixel);
    context.stroke();
  }
  context.setLineDash([]);
  context.globalAlpha = 1;
  context.fillStyle = colours.bad;
  for (const {x_m, y_m, state} of points) {
    if (hasPose(state)) continue;
    circle(context, x_m, y_m, 3 * pixel);
    context.fill();
  }
  drawMarker(context, points[0], pixel, colours.good);
}

// Where places of the path were believed to be: {from, to}, a line every few pixels.
export function drawMoved(context, moved, window_m, pixel, colours) {
  context.strokeStyle = colours.loop;
  context.lineWidth = pixel;
  context.globalAlpha = 0.7;
  context.beginPath();
  let last = null;
  for (const {from, to} of moved) {
    if (isBeside(from, to, window_m)) continue;
    if (last && Math.hypot(to.x_m - last.x_m, to.y_m - last.y_m) < MOVED_STEP_PX * pixel) continue;
    last = to;
    context.moveTo(from.x_m, from.y_m);
    context.lineTo(to.x_m, to.y_m);
    context.moveTo(from.x_m + 2 * pixel, from.y_m);
    context.arc(from.x_m, from.y_m, 2 * pixel, 0, TAU);
  }
  context.stroke();
  context.globalAlpha = 1;
}

// Past which place of the path the map is off most likely, if it is off.
export function drawDoubt(context, [x_m, y_m], pixel, colours) {
  context.strokeStyle = colours.warn;
  context.lineWidth = 3 * pixel;
  circle(context, x_m, y_m, 12 * pixel);
  context.stroke();
}

const DOUBT_REACH_M = 2;  // of the path
const DEEPEST_DOUBT = 0.55;
const doubts_canvas = document.createElement("canvas");

// Along the path, the deeper, the further off the map may be there. Discs that overlap do not add up.
export function drawDoubts(context, verdict, colours) {
  const {doubts, off_m} = verdict ?? {};
  if (!Array.isArray(doubts) || !verdict.off_at_m) return;
  const {width, height} = context.canvas;
  Object.assign(doubts_canvas, {width, height});
  const discs = doubts_canvas.getContext("2d");
  discs.setTransform(context.getTransform());
  for (const [x_m, y_m, there_m] of [...doubts].sort((a, b) => a[2] - b[2])) {
    discs.fillStyle = `color-mix(in srgb, ${colours.warn} ${100 * Math.min(there_m / off_m, 1)}%, ${colours.free})`;
    circle(discs, x_m, y_m, DOUBT_REACH_M);
    discs.fill();
  }
  context.save();
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.globalAlpha = DEEPEST_DOUBT;
  context.drawImage(doubts_canvas, 0, 0);
  context.restore();
}

// The drive that would tell most.
// A rectangle around each thing that has come or gone since the map was made.
export function drawChanges(context, changes, pixel, colours) {
  for (const {kind, x_m, y_m, length_m, width_m, yaw_rad} of changes ?? []) {
    context.save();
    context.translate(x_m, y_m);
    context.rotate(yaw_rad);
    context.fillStyle = context.strokeStyle = kind === "new" ? colours.good : colours.bad;
    context.lineWidth = 2 * pixel;
    context.globalAlpha = 0.25;
    context.fillRect(-length_m / 2, -width_m / 2, length_m, width_m);
    context.globalAlpha = 1;
    context.strokeRect(-length_m / 2, -width_m / 2, length_m, width_m);
    context.restore();
  }
}

export function drawWayBack(context, way, pixel, colours) {
  if (!way) return;
  const [from, to] = [way.from_m, way.to_m].map(([x_m, y_m]) => ({x_m, y_m}));
  context.strokeStyle = colours.warn;
  context.lineWidth = 2 * pixel;
  context.setLineDash([8 * pixel, 6 * pixel]);
  context.beginPath();
  context.moveTo(from.x_m, from.y_m);
  context.lineTo(to.x_m, to.y_m);
  context.stroke();
  context.setLineDash([]);
  for (const end of [from, to]) drawMarker(context, end, pixel, colours.warn);
}

// Where the robot of a simulated world really was.
export function drawTruth(context, places, pixel, colours) {
  context.strokeStyle = colours.good;
  context.lineWidth = 1.5 * pixel;
  context.setLineDash([2 * pixel, 4 * pixel]);
  context.beginPath();
  places.forEach(([x, y], index) => (index === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  context.stroke();
  context.setLineDash([]);
}

export function drawMarker(context, {x_m, y_m}, pixel, colour) {
  context.fillStyle = colour;
  circle(context, x_m, y_m, 5 * pixel);
  context.fill();
  context.strokeStyle = "#fff";
  context.lineWidth = 1.5 * pixel;
  context.stroke();
}

// age_s: since the newest of them was closed; it is pointed at for a while.
export function drawLoops(context, loops, age_s, pixel, colours) {
  context.strokeStyle = context.fillStyle = colours.loop;
  loops.forEach(([x0, y0, x1, y1], index) => {
    context.lineWidth = 1.5 * pixel;
    context.globalAlpha = 0.8;
    context.beginPath();
    context.moveTo(x0, y0);
    context.lineTo(x1, y1);
    context.stroke();
    circle(context, x1, y1, 3.5 * pixel);
    context.fill();
    if (index < loops.length - 1 || age_s > 3) return;
    const turn = age_s % 1;
    context.globalAlpha = 1 - turn;
    context.lineWidth = 3 * pixel;
    circle(context, x1, y1, (6 + 40 * turn) * pixel);
    context.stroke();
  });
  context.globalAlpha = 1;
}

export function drawScan(context, robot, map, pixel, colours) {
  const ends = robot.rays.map(({angle_rad, range_m}) => ({
    x: robot.x_m + range_m * Math.cos(robot.yaw_rad + angle_rad),
    y: robot.y_m + range_m * Math.sin(robot.yaw_rad + angle_rad),
  }));
  context.fillStyle = colours.scan;
  const side = 2.4 * pixel;
  for (const {x, y} of ends) context.fillRect(x - side / 2, y - side / 2, side, side);
  for (const kind of ["wall", "new", "free"]) {
    const hits = robot.critical.map((index) => ends[index]).filter((end) => end && map.hit(end.x, end.y) === kind);
    // What the map says of a place that is a guess means nothing.
    context.strokeStyle = context.fillStyle = robot.floating ? colours.floating : colours[`ray_${kind}`];
    context.lineWidth = pixel;
    context.globalAlpha = 0.3;
    context.beginPath();
    for (const {x, y} of hits) {
      context.moveTo(robot.x_m, robot.y_m);
      context.lineTo(x, y);
    }
    context.stroke();
    context.globalAlpha = 1;
    for (const {x, y} of hits) {
      circle(context, x, y, 3 * pixel);
      context.fill();
    }
  }
}

// Half axes [m] of the ellipse that holds 95 %, and where the longer one points [rad].
export function ellipseOf({xx, xy, yy}) {
  const mean = (xx + yy) / 2;
  const spread = Math.hypot((xx - yy) / 2, xy);
  return {
    long_m: CHI_95 * Math.sqrt(Math.max(0, mean + spread)),
    short_m: CHI_95 * Math.sqrt(Math.max(0, mean - spread)),
    angle_rad: 0.5 * Math.atan2(2 * xy, xx - yy),
  };
}

// Whether the covariance tells anything: not in the first scan of all, which is the origin, nor where nothing is known.
export const isMeasured = ({xx}) => xx > 0 && xx < UNKNOWN_M2;

export function drawRobot(context, robot, pixel, colours, with_uncertainty) {
  const {long_m, short_m, angle_rad} = ellipseOf(robot.covariance);
  context.lineWidth = 1.5 * pixel;
  const colour = robot.floating ? colours.floating : colours.robot;
  if (with_uncertainty && isMeasured(robot.covariance)) {
    context.strokeStyle = colour;
    context.fillStyle = colour;
    context.beginPath();
    context.ellipse(robot.x_m, robot.y_m, Math.min(long_m, 100), Math.min(short_m, 100), angle_rad, 0, TAU);
    context.globalAlpha = 0.2;
    context.fill();
    context.globalAlpha = 1;
    context.stroke();
  }
  if (with_uncertainty && robot.state === "DEGENERATE" && isKnown(robot.axis)) drawAxis(context, robot, pixel, colours);
  context.save();
  context.translate(robot.x_m, robot.y_m);
  context.rotate(robot.yaw_rad);
  const size = Math.max(0.22, 9 * pixel);
  context.beginPath();
  context.moveTo(1.25 * size, 0);
  context.lineTo(-0.8 * size, 0.8 * size);
  context.lineTo(-0.4 * size, 0);
  context.lineTo(-0.8 * size, -0.8 * size);
  context.closePath();
  context.fillStyle = robot.floating ? colours.ground : !hasPose(robot.state) ? colours.bad : colours.robot;
  context.fill();
  context.strokeStyle = robot.floating ? colours.floating : colours.ground;
  context.lineWidth = (robot.floating ? 2.5 : 1.5) * pixel;
  context.stroke();
  context.restore();
}

// Whether an axis tells a direction.
export const isKnown = ({x, y}) => Math.hypot(x, y) > 0;

function drawAxis(context, {x_m, y_m, axis}, pixel, colours) {
  context.save();
  context.translate(x_m, y_m);
  context.rotate(Math.atan2(axis.y, axis.x));
  context.strokeStyle = colours.warn;
  context.lineWidth = 3 * pixel;
  context.lineCap = "round";
  context.beginPath();
  for (const way of [1, -1]) {
    context.moveTo(14 * way * pixel, 0);
    context.lineTo(44 * way * pixel, 0);
    context.moveTo(36 * way * pixel, 7 * pixel);
    context.lineTo(44 * way * pixel, 0);
    context.lineTo(36 * way * pixel, -7 * pixel);
  }
  context.stroke();
  context.restore();
}

// A text beside a place, upright however the map is turned.
export function drawText(context, text, {x_m, y_m}, pixel, colours, angle_rad) {
  context.save();
  context.translate(x_m, y_m);
  context.rotate(-angle_rad);
  context.scale(pixel, -pixel);
  context.font = "600 14px system-ui, sans-serif";
  context.textAlign = "center";
  const width = context.measureText(text).width + 16;
  context.fillStyle = colours.ground;
  context.globalAlpha = 0.85;
  context.fillRect(-width / 2, -36, width, 24);
  context.globalAlpha = 1;
  context.fillStyle = colours.text;
  context.fillText(text, 0, -19);
  context.restore();
}

export const formatDistance = (metres) => `${metres.toFixed(2)} m`;

export function drawMeasure(context, [from, to], pixel, colours, angle_rad) {
  context.strokeStyle = colours.text;
  context.lineWidth = 2 * pixel;
  context.setLineDash([6 * pixel, 4 * pixel]);
  context.beginPath();
  context.moveTo(from.x_m, from.y_m);
  context.lineTo(to.x_m, to.y_m);
  context.stroke();
  context.setLineDash([]);
  for (const end of [from, to]) drawMarker(context, end, pixel, colours.path);
  const distance_m = Math.hypot(to.x_m - from.x_m, to.y_m - from.y_m);
  if (distance_m > 0) drawText(context, formatDistance(distance_m), to, pixel, colours, angle_rad);
}

// Where somebody says that the robot is, and where it looks.
export function drawPlace(context, {x_m, y_m, yaw_rad}, pixel, colours) {
  context.save();
  context.translate(x_m, y_m);
  context.rotate(yaw_rad);
  context.strokeStyle = context.fillStyle = colours.good;
  context.lineWidth = 4 * pixel;
  context.beginPath();
  context.moveTo(0, 0);
  context.lineTo(60 * pixel, 0);
  context.stroke();
  context.beginPath();
  context.moveTo(76 * pixel, 0);
  context.lineTo(54 * pixel, 11 * pixel);
  context.lineTo(54 * pixel, -11 * pixel);
  context.fill();
  context.restore();
  drawMarker(context, {x_m, y_m}, pixel, colours.good);
}

const CHUNK_SCANS = 512;
const [PLAIN, PALE] = [0.9, 0.22];

// The path of a run that has ended, in chunks of lines that are no finer than `step_m`.
export class TimelinePath {
  constructor(timeline, step_m) {
    this.timeline = timeline;
    this.step_m = step_m;
    this.chunks = [];
    for (let first = 0; first < timeline.num; first += CHUNK_SCANS) {
      this.chunks.push({first, ...this.trace(first, Math.min(timeline.num, first + CHUNK_SCANS + 1))});
    }
  }

  // What was moved of the scans up to the moment, no finer than it is drawn.
  moved() {
    this.all_moved ??= this.timeline.moved(MOVED_STEP_PX * this.step_m);
    return this.all_moved.filter(({scan}) => scan <= this.timeline.at);
  }

  // The lines through the scans [first, end): those of the map, those that float, and where the robot was lost.
  trace(first, end) {
    const {timeline, step_m} = this;
    const lines = {map: new Path2D(), floating: new Path2D(), lost: []};
    const box = {x0: Infinity, y0: Infinity, x1: -Infinity, y1: -Infinity};
    let last = null;
    for (let i = first; i < end; ++i) {
      const state = timeline.stateOf(i);
      const [x, y] = [timeline.x_m[i], timeline.y_m[i]];
      if (!Number.isFinite(x) || !Number.isFinite(y)) continue;
      if (!hasPose(state)) {
        lines.lost.push([x, y]);
        continue;
      }
      const kind = state === "FLOATING" ? "floating" : "map";
      const way_m = last ? Math.hypot(x - last.x, y - last.y) : 0;
      if (last && way_m < step_m && i < end - 1 && kind === last.kind) continue;
      if (last && kind === last.kind && way_m <= LONGEST_STEP_M) lines[kind].lineTo(x, y); else lines[kind].moveTo(x, y);
      last = {x, y, kind};
      Object.assign(box, {x0: Math.min(box.x0, x), y0: Math.min(box.y0, y), x1: Math.max(box.x1, x), y1: Math.max(box.y1, y)});
    }
    return {...lines, box};
  }

  // The chunk of the moment that is shown.
  get current() { return Math.floor(this.timeline.at / CHUNK_SCANS); }

  // All chunks before the moment's as a path, and pale what comes after them. It changes with `current` only.
  drawChunks(context, window_m, pixel, colours, with_floating) {
    const {chunks, current} = this;
    for (const chunk of chunks.slice(current)) this.stroke(context, chunk, PALE, window_m, pixel, colours, with_floating);
    for (const chunk of chunks.slice(0, current)) this.stroke(context, chunk, PLAIN, window_m, pixel, colours, with_floating);
  }

  // The rest of the path up to the moment.
  drawRest(context, window_m, pixel, colours, with_floating) {
    const {at, x_m, y_m} = this.timeline;
    const rest = this.trace(this.current * CHUNK_SCANS, at + 1);
    this.stroke(context, rest, PLAIN, window_m, pixel, colours, with_floating);
    drawMarker(context, {x_m: x_m[0], y_m: y_m[0]}, pixel, colours.good);
  }

  stroke(context, {map, floating, lost, box}, alpha, {x0, y0, x1, y1}, pixel, colours, with_floating) {
    if (box.x0 > x1 || box.x1 < x0 || box.y0 > y1 || box.y1 < y0) return;
    context.lineWidth = 2 * pixel;
    context.lineJoin = "round";
    context.globalAlpha = alpha;
    context.strokeStyle = colours.path;
    context.stroke(map);
    context.strokeStyle = colours.floating;
    context.setLineDash(FLOATING_DASH_PX.map((px) => px * pixel));
    if (with_floating) context.stroke(floating);
    context.setLineDash([]);
    context.fillStyle = colours.bad;
    for (const [x, y] of lost) context.fillRect(x - 2.5 * pixel, y - 2.5 * pixel, 5 * pixel, 5 * pixel);
    context.globalAlpha = 1;
  }
}
