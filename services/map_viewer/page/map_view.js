// One robot's map on the screen: camera, pointers and the drawing of a frame.

import {BLOCK_CELLS, REDUCTIONS, findWalls, makePalette} from "./map_model.js";
import {TimelinePath, drawChanges, drawDoubt, drawDoubts, drawGrid, drawLoops, drawMeasure, drawMoved, drawPath, drawPlace, drawRobot,
        drawScan, drawText, drawTruth, drawWayBack} from "./layers.js";
import {drawEdits, boxCorners} from "./edits.js";
import {COLOURS as FLEET_COLOURS, drawFleet} from "./fleet.js";
import {drawAim, drawDraft, drawMarks} from "./marks.js";
import {listenToPointers} from "./pointers.js";

const NEAREST_PX = 400;  // pixels of a metre
const FURTHEST_PX = 0.2;
const FINEST_CELL_PX = 0.8;  // where a cell is smaller, a wall of one cell would be hard to see
const TAP_PX = 14;           // so near to the path is on it
export const DEFAULT_PX = 40;  // of a metre
const LAYERS = ["doubts", "rays", "path", "floating", "loops", "moved", "uncertainty", "truth", "robots", "marks", "grid"];
export const DEFAULT_LAYERS = LAYERS.filter((layer) => layer !== "moved");
const POINTED_AT_S = 3.1;  // so long a correction of the map is

const rgb = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));

// The colours of the style sheet, by their names with _ for -.
function readColours() {
  const style = getComputedStyle(document.documentElement);
  const names = ["ground", "grid", "grid-strong", "free", "wall", "path", "ray-wall", "ray-new", "ray-free", "scan",
                 "robot", "good", "warn", "bad", "loop", "floating", "text", "dim", "panel", ...FLEET_COLOURS];
  return Object.fromEntries(names.map((name) => [name.replace("-", "_"), style.getPropertyValue(`--${name}`).trim()]));
}

export class MapView extends EventTarget {
  constructor(parent, model) {
    super();
    this.model = model;
    this.canvas = parent.appendChild(document.createElement("canvas"));
    this.canvas.setAttribute("role", "img");
    this.canvas.tabIndex = -1;  // Enter is for the map then, and not for the tool that was chosen
    this.parent = parent;
    this.camera = {x_m: 0, y_m: 0, px: DEFAULT_PX, turn_rad: 0};  // middle, pixels of a metre, what points to the right
    this.follows = true;
    this.fits = false;  // the whole map stays in view
    this.layers = Object.fromEntries(LAYERS.map((layer) => [layer, DEFAULT_LAYERS.includes(layer)]));
    this.mode = "beside";
    this.others = [];  // models whose maps are drawn over this one
    this.measures = false;
    this.places = false;
    this.placed = null;
    this.measured = [];  // ends of the distance that is measured
    this.marks = false;  // whether a tap says where a place with a name is
    this.draft = [];  // corners of an outline that is being made
    this.edits = null;  // of a copy of the map, while somebody edits it
    this.boxes = false;  // whether a drag spans a rectangle, ...
    this.boxed = null;   // ... from one place to another one
    this.by_keys = false;  // whether the middle of the view is pointed at, and no pointer
    this.pointers = new Map();
    this.loop_closed_at = -Infinity;
    this.ground_canvas = document.createElement("canvas");  // below what changes when a run is played
    this.ground = null;  // what is on it
    this.readTheme();
    new ResizeObserver(() => this.resize()).observe(parent);
    listenToPointers(this);
    model.addEventListener("corrected", ({detail}) => { if (detail.is_loop) this.loop_closed_at = performance.now(); });
    model.addEventListener("timeline", () => { this.timeline_path = null; });
    model.addEventListener("info", () => { this.ground = null; });
    model.addEventListener("whole", () => { if (this.fits) this.fit(); });
  }

  // For who does not see it.
  describe() {
    const {robot, map, info, is_nowhere} = this.model;
    const where = robot && !is_nowhere ? `; the robot is at x ${robot.x_m.toFixed(1)} m, y ${robot.y_m.toFixed(1)} m` : "";
    const text = `Map of ${info.robot || "the robot"}: ${Math.round(map.area_m2())} square metres${where}`;
    if (this.canvas.getAttribute("aria-label") !== text) this.canvas.setAttribute("aria-label", text);
  }

  readTheme() {
    this.colours = readColours();
    const {free, wall} = this.colours;
    this.model.map.setPalette(makePalette(rgb(free), rgb(wall)));
    this.stale = true;
  }

  // Shows the maps of others over this one: "overlay", each in a colour of its own, or "difference", where all that is
  // not the same is bright. Else "beside": this one alone, in the colours of readTheme.
  showOver(mode, others) {
    this.mode = mode;
    this.others = mode === "beside" ? [] : others;
    if (mode === "beside") return;
    const {free, path, ray_free} = this.colours;
    const paletteOf = (index) => (mode === "difference"
      ? makePalette([70, 70, 70], [255, 255, 255], {least: 1})
      : makePalette(rgb(free), rgb(index === 0 ? path : ray_free), {free_share: index === 0 ? 1 : 0.2}));
    [this.model, ...this.others].forEach(({map}, index) => map.setPalette(paletteOf(index)));
    this.stale = true;
  }

  resize() {
    this.ratio = window.devicePixelRatio || 1;
    const {width, height} = this.parent.getBoundingClientRect();
    this.canvas.width = Math.round(width * this.ratio);
    this.canvas.height = Math.round(height * this.ratio);
    this.stale = true;
    if (this.fits) this.fit();
  }

  // What of the view nothing covers, from its corner [css pixels].
  clearArea() {
    const view = this.parent.getBoundingClientRect();
    const area = {x0: 0, y0: 0, x1: view.width, y1: view.height};
    const [head, player, panel, tools, form] = ["head", "player", "panel", "tools", "edit_form"].map((id) => {
      const box = document.getElementById(id).getBoundingClientRect();
      const covers = box.width > 0 && box.left < view.right && box.right > view.left && box.top < view.bottom &&
                     box.bottom > view.top;
      return covers ? box : null;
    });
    if (head) area.y0 = head.bottom - view.top;
    const label = this.parent.querySelector(".label");
    if (label) area.y0 = Math.max(area.y0, label.getBoundingClientRect().bottom - view.top);
    if (player) area.y1 = player.top - view.top;
    if (panel) panel.width < view.width / 2 ? (area.x1 = panel.left - view.left) : (area.y1 = Math.min(area.y1, panel.top - view.top));
    if (tools && tools.width < view.width / 3) {
      tools.left - view.left < view.width / 2 ? (area.x0 = tools.right - view.left) : (area.x1 = tools.left - view.left);
    }
    if (form && form.width > view.width / 2) area.y1 = Math.min(area.y1, form.top - view.top);
    else if (form) area.x0 = Math.max(area.x0, form.right - view.left);
    return area;
  }

  // Shows all of the map in the part of the view that is clear, and goes on to while it grows.
  fit() {
    const extents = [this.model, ...this.others].map(({map}) => map.extent()).filter(Boolean);
    this.fits = true;
    this.setFollows(false);
    if (extents.length === 0) return;
    const [x0, y0] = ["x0", "y0"].map((edge) => Math.min(...extents.map((extent) => extent[edge])));
    const [x1, y1] = ["x1", "y1"].map((edge) => Math.max(...extents.map((extent) => extent[edge])));
    const area = this.clearArea();
    const margin = Math.min(48, (area.x1 - area.x0) / 12, (area.y1 - area.y0) / 12);
    const corners = [[x0, y0], [x0, y1], [x1, y0], [x1, y1]].map(([x, y]) => this.turn(x, y));
    const size = (of) => Math.max(...corners.map(of)) - Math.min(...corners.map(of));
    const px = Math.min((area.x1 - area.x0 - 2 * margin) / size(({right_m}) => right_m),
                        (area.y1 - area.y0 - 2 * margin) / size(({up_m}) => up_m));
    this.setScale(px);
    this.centre((x0 + x1) / 2, (y0 + y1) / 2);
  }

  // px: of a metre.
  setScale(px) { this.camera.px = Math.max(FURTHEST_PX, Math.min(NEAREST_PX, px)); }

  // A direction of the map as the screen has it, and back.
  turn(x_m, y_m) {
    const {turn_rad} = this.camera;
    return {right_m: x_m * Math.cos(turn_rad) + y_m * Math.sin(turn_rad),
            up_m: y_m * Math.cos(turn_rad) - x_m * Math.sin(turn_rad)};
  }
  turnBack(right_m, up_m) {
    const {turn_rad} = this.camera;
    return {x_m: right_m * Math.cos(turn_rad) - up_m * Math.sin(turn_rad),
            y_m: up_m * Math.cos(turn_rad) + right_m * Math.sin(turn_rad)};
  }

  // Turns the map so that its walls lie along the edges of the screen, or back.
  toggleTurn() {
    this.camera.turn_rad = this.camera.turn_rad === 0 ? findWalls(this.model.map) : 0;
    this.stale = true;
    if (this.fits) this.fit();
  }

  // Where the camera is to be, for a place to be in the middle of what is clear.
  cameraFor(x_m, y_m) {
    const {width, height} = this.parent.getBoundingClientRect();
    const area = this.clearArea();
    const aside = this.turnBack((area.x0 + area.x1 - width) / 2 / this.camera.px,
                                (height - area.y0 - area.y1) / 2 / this.camera.px);
    return {x_m: x_m - aside.x_m, y_m: y_m - aside.y_m};
  }

  centre(x_m, y_m) {
    Object.assign(this.camera, this.cameraFor(x_m, y_m));
    this.stale = true;
  }

  // Glides after the robot; a robot that is far off is jumped to.
  follow() {
    const {robot} = this.model;
    if (!this.follows || !robot || this.model.is_nowhere) return;
    const wanted = this.cameraFor(robot.x_m, robot.y_m);
    const behind_px = Math.hypot(wanted.x_m - this.camera.x_m, wanted.y_m - this.camera.y_m) * this.camera.px;
    if (behind_px < 0.5) return;
    const share = behind_px > 2000 ? 1 : 0.25;
    this.camera.x_m += share * (wanted.x_m - this.camera.x_m);
    this.camera.y_m += share * (wanted.y_m - this.camera.y_m);
    this.stale = true;
  }

  setFollows(follows) {
    if (follows) this.fits = false;
    if (this.follows === follows) return;
    this.follows = follows;
    this.dispatchEvent(new Event("follows"));
  }

  setMeasures(measures) {
    this.measures = measures;
    this.measured = [];
    if (measures) this.setPlaces(false), this.setMarks(false);
    this.showTool();
  }

  // Whether a press and a drag say where the robot is and looks.
  setPlaces(places) {
    this.places = places;
    this.placed = null;  // {x_m, y_m, yaw_rad} while it is said
    if (places) this.setMeasures(false), this.setMarks(false);
    this.showTool();
  }

  setMarks(marks) {
    this.marks = marks;
    this.draft = [];
    this.boxes = false;
    this.boxed = null;
    if (marks) this.setMeasures(false), this.setPlaces(false), this.canvas.focus({preventScroll: true});
    this.showTool();
  }

  showTool() {
    const tool = this.measures ? "measure" : this.places ? "place" : this.marks ? "mark" : "";
    if (tool) this.parent.dataset.tool = tool;
    else delete this.parent.dataset.tool;
    this.stale = true;
  }

  // A place of the window on the map.
  toMap(client_x, client_y) {
    const box = this.canvas.getBoundingClientRect();
    const from_middle = this.turnBack((client_x - box.left - box.width / 2) / this.camera.px,
                                      (box.top + box.height / 2 - client_y) / this.camera.px);
    return {x_m: this.camera.x_m + from_middle.x_m, y_m: this.camera.y_m + from_middle.y_m};
  }

  // What lies there stays there, unless the robot is followed.
  zoom(factor, client_x, client_y) {
    const before = this.toMap(client_x, client_y);
    this.setScale(this.camera.px * factor);
    const after = this.toMap(client_x, client_y);
    this.fits = false;
    if (!this.follows) {
      this.camera.x_m += before.x_m - after.x_m;
      this.camera.y_m += before.y_m - after.y_m;
    }
    this.stale = true;
  }

  zoomMiddle(factor) {
    const {left, top, width, height} = this.canvas.getBoundingClientRect();
    this.zoom(factor, left + width / 2, top + height / 2);
  }

  move(right_px, down_px) {
    this.setFollows(false);
    this.fits = false;
    const way = this.turnBack(right_px / this.camera.px, -down_px / this.camera.px);
    this.camera.x_m -= way.x_m;
    this.camera.y_m -= way.y_m;
    this.stale = true;
  }

  lookAt({x_m, y_m}) {
    if (Math.hypot(x_m - this.placed.x_m, y_m - this.placed.y_m) * this.camera.px < 8) return;
    this.placed.yaw_rad = Math.atan2(y_m - this.placed.y_m, x_m - this.placed.x_m);
    this.stale = true;
  }

  place(is_meant) {
    if (is_meant) this.dispatchEvent(new CustomEvent("placed", {detail: this.placed}));
    this.setPlaces(false);
    this.dispatchEvent(new Event("follows"));
  }

  // What a key points at: what is in the middle of the part of the view that is clear.
  aim() {
    const {x_m, y_m} = this.cameraFor(0, 0);
    return {x_m: this.camera.x_m - x_m, y_m: this.camera.y_m - y_m};
  }

  takeAim() {
    if (this.marks) this.dispatchEvent(new CustomEvent("marked", {detail: this.aim()}));
  }

  takeBox(is_meant) {
    if (is_meant) this.dispatchEvent(new CustomEvent("boxed", {detail: this.boxed}));
    this.boxed = null;
    this.stale = true;
  }

  // Marks an end of what is measured, or goes to the moment at which the robot was there.
  tap(event) {
    const place = this.toMap(event.clientX, event.clientY);
    if (this.measures) return this.mark(place);
    if (this.marks) return this.dispatchEvent(new CustomEvent("marked", {detail: place}));
    const at = this.model.timeline?.nearest(place.x_m, place.y_m, TAP_PX / this.camera.px, this.model.shows_then) ?? null;
    if (at !== null) this.dispatchEvent(new CustomEvent("moment", {detail: at}));
  }

  mark(place) {
    const ends = this.measured.done ? [] : this.measured;
    this.measured = ends.length === 0 ? [place, place] : Object.assign([ends[0], place], {done: true});
    this.stale = true;
    this.dispatchEvent(new CustomEvent("pointed", {detail: place}));
  }

  distance_m() {
    const [from, to] = this.measured;
    return from ? Math.hypot(to.x_m - from.x_m, to.y_m - from.y_m) : null;
  }

  // Draws, if anything has changed. Whether it has. A map that is drawn over another one has no room of its own.
  draw(now_ms) {
    const {model} = this;
    if (this.canvas.width === 0 || this.canvas.height === 0) return false;
    this.follow();
    const loop_age_s = (now_ms - this.loop_closed_at) / 1000;
    if (!(this.stale || [model, ...this.others].some(({changed}) => changed) || loop_age_s < POINTED_AT_S)) return false;
    if (this.stale || model.map.stale.size > 0) this.ground = null;
    this.stale = false;
    for (const shown of [model, ...this.others]) {
      shown.changed = false;
      shown.map.paint();
    }
    this.drawOn(this.canvas.getContext("2d"), loop_age_s, now_ms);
    return true;
  }

  // From here on the unit is a metre of the map.
  useMetres(context) {
    const {camera} = this;
    const {width, height} = this.canvas;
    const scale = camera.px * this.ratio;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.translate(width / 2, height / 2);
    context.scale(scale, -scale);
    context.rotate(-camera.turn_rad);
    context.translate(-camera.x_m, -camera.y_m);
  }

  // What of the map is seen, and around it where it is turned.
  windowOf() {
    const {camera} = this;
    const {width, height} = this.canvas;
    const scale = camera.px * this.ratio;
    const [cos, sin] = [Math.abs(Math.cos(camera.turn_rad)), Math.abs(Math.sin(camera.turn_rad))];
    const half = {x: (width * cos + height * sin) / 2 / scale, y: (width * sin + height * cos) / 2 / scale};
    return {x0: camera.x_m - half.x, x1: camera.x_m + half.x, y0: camera.y_m - half.y, y1: camera.y_m + half.y};
  }

  // Grid, maps, and the truth of a simulation.
  drawMaps(context, window_m, pixel) {
    const {model, colours, layers} = this;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = this.mode === "difference" ? "#000" : colours.ground;
    context.fillRect(0, 0, this.canvas.width, this.canvas.height);
    this.useMetres(context);
    if (layers.grid && this.mode !== "difference") drawGrid(context, window_m, pixel, colours);
    this.drawMap(context, model.map, window_m);
    for (const {map} of this.others) {
      if (this.mode === "difference") this.drawDifference(context, map, window_m);
      else this.drawMap(context, map, window_m);
    }
    if (layers.doubts && this.mode === "beside" && !model.then) drawDoubts(context, model.info.verdict, colours);
    if (layers.truth) drawTruth(context, model.info.truth ?? [], pixel, colours);
  }

  // Of the map that is drawn, only what differs from another one stays. That one is drawn on black first, too: the
  // half-transparent pixels of its edges would not cancel what the same ones became on black.
  drawDifference(context, map, window_m) {
    const {width, height} = this.canvas;
    const canvas = Object.assign(this.ground_canvas, {width, height});
    const other = canvas.getContext("2d", {alpha: false});  // is black
    this.useMetres(other);
    this.drawMap(other, map, window_m);
    context.globalCompositeOperation = "difference";
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.drawImage(canvas, 0, 0);
    context.globalCompositeOperation = "source-over";
    this.useMetres(context);
  }

  // What is the same in most frames of a run that is played: maps, and the path but for its last piece.
  drawGround(context, window_m, pixel) {
    const {model, colours, layers} = this;
    if (!model.timeline || model.then || this.mode !== "beside" || context.is_figure) {
      this.drawMaps(context, window_m, pixel);
      if (model.timeline && !model.then && !context.is_figure && layers.path) this.tracedPath(pixel).drawChunks(context, window_m, pixel, colours, layers.floating);
      return;
    }
    const path = this.tracedPath(pixel);
    if (this.ground?.path !== path || this.ground.current !== path.current) {
      const {width, height} = this.canvas;
      const canvas = this.ground_canvas;
      if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, {width, height});
      const on_ground = canvas.getContext("2d", {alpha: false});
      this.drawMaps(on_ground, window_m, pixel);
      if (layers.path) path.drawChunks(on_ground, window_m, pixel, colours, layers.floating);
      this.ground = {path, current: path.current};
    }
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.drawImage(this.ground_canvas, 0, 0);
    this.useMetres(context);
  }

  drawOn(context, loop_age_s, now_ms) {
    const {model, camera, colours, layers} = this;
    const pixel = 1 / camera.px;
    const window_m = this.windowOf();
    this.drawGround(context, window_m, pixel);
    if (model.fleet) drawFleet(context, model, window_m, pixel, colours, layers, camera.turn_rad, now_ms);
    else if (layers.path) this.drawPath(context, window_m, pixel);
    if ((layers.moved && !model.then) || (layers.loops && loop_age_s < POINTED_AT_S)) this.drawMoved(context, window_m, pixel);
    drawChanges(context, model.info.changes, pixel, colours);
    const {off_at_m: doubt_m, way_back} = (!model.then && model.info.verdict) || {};
    if (layers.doubts) drawWayBack(context, way_back, pixel, colours);
    if (layers.path && Array.isArray(doubt_m)) drawDoubt(context, doubt_m, pixel, colours);
    if (layers.loops) drawLoops(context, (model.then ?? model.info).loops, loop_age_s, pixel, colours);
    if (layers.robots) for (const other of this.others) this.drawOther(context, other, window_m, pixel);
    if (model.robot && !model.is_nowhere) {
      const scan = model.timeline ? model.scan : model.robot;
      if (layers.rays && scan && this.isOfMoment(scan)) drawScan(context, scan, model.map, pixel, colours);
      drawRobot(context, model.robot, pixel, {...colours, robot: model.is_old ? colours.dim : colours.robot}, layers.uncertainty);
    }
    if (this.edits && !context.is_figure) drawEdits(context, this.edits, window_m, pixel, colours);
    if (layers.marks) drawMarks(context, model.info.marks, pixel, colours, camera.turn_rad);
    const draft = this.boxed ? boxCorners(this, this.boxed.from, this.boxed.to) : this.draft;
    if (draft.length > 0) drawDraft(context, draft, pixel, colours);
    if (this.marks && this.by_keys) drawAim(context, this.aim(), pixel, colours, camera.turn_rad);
    if (this.placed) drawPlace(context, this.placed, pixel, colours);
    if (this.measured.length === 2) drawMeasure(context, this.measured, pixel, colours, camera.turn_rad);
  }

  // A scan that was asked for while the run is played may come a moment late.
  isOfMoment({utime}) {
    const {timeline} = this.model;
    return !timeline || Math.abs(Number(utime) * 1e-6 - timeline.time_s[timeline.at]) < 0.5;
  }

  drawPath(context, window_m, pixel) {
    const {model, colours, layers: {floating}} = this;
    if (model.then) return drawPath(context, model.pathThen(), [], window_m, pixel, colours, floating);
    if (!model.timeline) return drawPath(context, model.path, model.tail, window_m, pixel, colours, floating);
    if (context.is_figure) return drawPath(context, model.timeline.points(pixel), [], window_m, pixel, colours, floating);
    this.tracedPath(pixel).drawRest(context, window_m, pixel, colours, floating);
  }

  // Of a run that has ended, no finer than a pixel.
  tracedPath(pixel) {
    const step_m = 2 ** Math.floor(Math.log2(pixel));  // so that a turn of the wheel does not trace it anew
    if (this.timeline_path?.step_m !== step_m) this.timeline_path = new TimelinePath(this.model.timeline, step_m);
    return this.timeline_path;
  }

  drawMoved(context, window_m, pixel) {
    const {model, colours} = this;
    drawMoved(context, model.timeline ? this.tracedPath(pixel).moved() : model.moved, window_m, pixel, colours);
  }

  // The robot whose map is drawn over this one, in the colour of its walls.
  drawOther(context, {robot, path, tail, timeline, info}, window_m, pixel) {
    const {colours, camera} = this;
    const other = this.mode === "difference" ? colours.text : colours.ray_free;
    const own = {...colours, path: other, robot: other};
    const points = timeline ? timeline.points(pixel) : path;
    if (this.layers.path) drawPath(context, points, tail, window_m, pixel, own, this.layers.floating);
    if (!robot) return;
    drawRobot(context, robot, pixel, own, this.layers.uncertainty);
    drawText(context, info.robot, robot, pixel, own, camera.turn_rad);
  }

  drawMap(context, map, {x0, y0, x1, y1}) {
    const side_m = BLOCK_CELLS * map.cell_size_m;
    const cell_px = this.camera.px * this.ratio * map.cell_size_m;
    context.imageSmoothingEnabled = cell_px < 3 || this.camera.turn_rad !== 0;
    const level = context.is_figure ? 0 : REDUCTIONS.findIndex((reduction) => cell_px * reduction >= FINEST_CELL_PX);
    for (const {x, y, pictures} of map.blocks.values()) {
      const [left, bottom] = [x * side_m, y * side_m];
      if (left > x1 || left + side_m < x0 || bottom > y1 || bottom + side_m < y0) continue;
      context.save();
      context.translate(left, bottom + side_m);
      context.scale(1, -1);
      context.drawImage(pictures.at(level), 0, 0, side_m, side_m);
      context.restore();
    }
  }
}
