// One robot's map on the screen: camera, pointers and the drawing of a frame.

import {BLOCK_CELLS, makePalette} from "./map_model.js";
import {drawGrid, drawLoops, drawMeasure, drawPath, drawRobot, drawScan} from "./layers.js";

const NEAREST_PX = 400;  // pixels of a metre
const FURTHEST_PX = 0.2;

const rgb = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));

// The colours of the style sheet, by their names with _ for -.
function readColours() {
  const style = getComputedStyle(document.documentElement);
  const names = ["ground", "grid", "grid-strong", "free", "wall", "path", "ray-wall", "ray-new", "ray-free", "scan",
                 "robot", "good", "warn", "bad", "loop", "floating", "text"];
  return Object.fromEntries(names.map((name) => [name.replace("-", "_"), style.getPropertyValue(`--${name}`).trim()]));
}

export class MapView extends EventTarget {
  constructor(parent, model) {
    super();
    this.model = model;
    this.canvas = parent.appendChild(document.createElement("canvas"));
    this.parent = parent;
    this.camera = {x_m: 0, y_m: 0, px: 40};  // middle of the view, and pixels of a metre
    this.follows = true;
    this.shows_rays = true;
    this.measures = false;
    this.measured = [];  // ends of the distance that is measured
    this.pointers = new Map();
    this.loop_closed_at = -Infinity;
    this.readTheme();
    new ResizeObserver(() => this.resize()).observe(parent);
    this.listen();
    model.addEventListener("corrected", () => { this.loop_closed_at = performance.now(); });
  }

  readTheme() {
    this.colours = readColours();
    this.model.map.setPalette(makePalette(rgb(this.colours.free), rgb(this.colours.wall)));
    this.stale = true;
  }

  resize() {
    this.ratio = window.devicePixelRatio || 1;
    const {width, height} = this.parent.getBoundingClientRect();
    this.canvas.width = Math.round(width * this.ratio);
    this.canvas.height = Math.round(height * this.ratio);
    this.stale = true;
  }

  // What of the view no panel covers [css pixels].
  clearArea() {
    const {width, height} = this.parent.getBoundingClientRect();
    const area = {x0: 0, y0: 0, x1: width, y1: height};
    const panel = document.querySelector("#panel:not(.folded)");
    if (!panel || document.querySelectorAll(".map").length > 1) return area;
    const box = panel.getBoundingClientRect();
    box.width < width / 2 ? (area.x1 = box.left) : (area.y1 = box.top);
    return area;
  }

  // Shows all of the map in the part of the view that is clear.
  fit() {
    const extent = this.model.map.extent();
    if (!extent) return;
    const area = this.clearArea();
    const margin = 48;
    const px = Math.min((area.x1 - area.x0 - 2 * margin) / (extent.x1 - extent.x0),
                        (area.y1 - area.y0 - 2 * margin) / (extent.y1 - extent.y0));
    this.camera.px = Math.max(FURTHEST_PX, Math.min(NEAREST_PX, px));
    this.centre((extent.x0 + extent.x1) / 2, (extent.y0 + extent.y1) / 2);
    this.setFollows(false);
  }

  // Where the camera is to be, for a place to be in the middle of what is clear.
  cameraFor(x_m, y_m) {
    const {width, height} = this.parent.getBoundingClientRect();
    const area = this.clearArea();
    return {x_m: x_m - (area.x0 + area.x1 - width) / 2 / this.camera.px,
            y_m: y_m + (area.y0 + area.y1 - height) / 2 / this.camera.px};
  }

  centre(x_m, y_m) {
    Object.assign(this.camera, this.cameraFor(x_m, y_m));
    this.stale = true;
  }

  // Glides after the robot; a robot that is far off is jumped to.
  follow() {
    const {robot} = this.model;
    if (!this.follows || !robot) return;
    const wanted = this.cameraFor(robot.x_m, robot.y_m);
    const behind_px = Math.hypot(wanted.x_m - this.camera.x_m, wanted.y_m - this.camera.y_m) * this.camera.px;
    if (behind_px < 0.5) return;
    const share = behind_px > 2000 ? 1 : 0.25;
    this.camera.x_m += share * (wanted.x_m - this.camera.x_m);
    this.camera.y_m += share * (wanted.y_m - this.camera.y_m);
    this.stale = true;
  }

  setFollows(follows) {
    if (this.follows === follows) return;
    this.follows = follows;
    this.dispatchEvent(new Event("follows"));
  }

  setMeasures(measures) {
    this.measures = measures;
    this.measured = [];
    this.parent.dataset.tool = measures ? "measure" : "";
    this.stale = true;
  }

  // A place of the window on the map.
  toMap(client_x, client_y) {
    const box = this.canvas.getBoundingClientRect();
    return {
      x_m: this.camera.x_m + (client_x - box.left - box.width / 2) / this.camera.px,
      y_m: this.camera.y_m - (client_y - box.top - box.height / 2) / this.camera.px,
    };
  }

  // What lies there stays there, unless the robot is followed.
  zoom(factor, client_x, client_y) {
    const before = this.toMap(client_x, client_y);
    this.camera.px = Math.max(FURTHEST_PX, Math.min(NEAREST_PX, this.camera.px * factor));
    const after = this.toMap(client_x, client_y);
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
    this.camera.x_m -= right_px / this.camera.px;
    this.camera.y_m += down_px / this.camera.px;
    this.stale = true;
  }

  listen() {
    const canvas = this.canvas;
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), event.clientX, event.clientY);
    }, {passive: false});
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, {x: event.clientX, y: event.clientY, way_px: 0});
      this.dispatchEvent(new Event("chosen"));
    });
    canvas.addEventListener("pointermove", (event) => this.point(event));
    for (const type of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(type, (event) => {
        const pointer = this.pointers.get(event.pointerId);
        this.pointers.delete(event.pointerId);
        if (type === "pointerup" && pointer?.way_px < 5 && this.measures) this.mark(event);
      });
    }
  }

  // A pointer has moved: one drags, two pinch.
  point(event) {
    const place = this.toMap(event.clientX, event.clientY);
    this.dispatchEvent(new CustomEvent("pointed", {detail: place}));
    if (this.measures && this.measured.length === 2 && !this.measured.done) {
      this.measured[1] = place;
      this.stale = true;
    }
    const pointer = this.pointers.get(event.pointerId);
    if (!pointer) return;
    const right = event.clientX - pointer.x;
    const down = event.clientY - pointer.y;
    const other = [...this.pointers.entries()].find(([id]) => id !== event.pointerId)?.[1];
    if (other) {
      const before = Math.hypot(pointer.x - other.x, pointer.y - other.y);
      const after = Math.hypot(event.clientX - other.x, event.clientY - other.y);
      if (before > 0) this.zoom(after / before, (event.clientX + other.x) / 2, (event.clientY + other.y) / 2);
      this.move(right / 2, down / 2);
    } else if (pointer.way_px + Math.hypot(right, down) >= 5) {
      this.move(right, down);
    }
    Object.assign(pointer, {x: event.clientX, y: event.clientY, way_px: pointer.way_px + Math.hypot(right, down)});
  }

  mark(event) {
    const place = this.toMap(event.clientX, event.clientY);
    const ends = this.measured.done ? [] : this.measured;
    this.measured = ends.length === 0 ? [place, place] : Object.assign([ends[0], place], {done: true});
    this.stale = true;
  }

  distance_m() {
    const [from, to] = this.measured;
    return from ? Math.hypot(to.x_m - from.x_m, to.y_m - from.y_m) : null;
  }

  // Draws, if anything has changed. Whether it has.
  draw(now_ms) {
    const {model} = this;
    this.follow();
    const loop_age_s = (now_ms - this.loop_closed_at) / 1000;
    if (!(this.stale || model.changed || loop_age_s < 3.1)) return false;
    this.stale = model.changed = false;
    model.map.paint();
    this.drawOn(this.canvas.getContext("2d"), loop_age_s);
    return true;
  }

  drawOn(context, loop_age_s) {
    const {model, camera, colours} = this;
    const {width, height} = this.canvas;
    const scale = camera.px * this.ratio;
    const pixel = 1 / camera.px;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = colours.ground;
    context.fillRect(0, 0, width, height);
    context.setTransform(scale, 0, 0, -scale, width / 2 - camera.x_m * scale, height / 2 + camera.y_m * scale);
    const half = {x: width / 2 / scale, y: height / 2 / scale};
    const window_m = {x0: camera.x_m - half.x, x1: camera.x_m + half.x,
                      y0: camera.y_m - half.y, y1: camera.y_m + half.y};
    drawGrid(context, window_m, pixel, colours);
    this.drawMap(context, window_m);
    drawPath(context, model.path, model.tail, window_m, pixel, colours);
    drawLoops(context, model.info.loops, loop_age_s, pixel, colours);
    if (model.robot) {
      if (this.shows_rays) drawScan(context, model.robot, model.map, pixel, colours);
      drawRobot(context, model.robot, pixel, colours);
    }
    if (this.measured.length === 2) drawMeasure(context, this.measured, pixel, colours);
  }

  drawMap(context, {x0, y0, x1, y1}) {
    const {map} = this.model;
    const side_m = BLOCK_CELLS * map.cell_size_m;
    context.imageSmoothingEnabled = this.camera.px * this.ratio * map.cell_size_m < 3;
    for (const {x, y, canvas} of map.blocks.values()) {
      const left = x * side_m;
      const bottom = y * side_m;
      if (left > x1 || left + side_m < x0 || bottom > y1 || bottom + side_m < y0) continue;
      context.save();
      context.translate(left, bottom + side_m);
      context.scale(1, -1);
      context.drawImage(canvas, 0, 0, side_m, side_m);
      context.restore();
    }
  }
}
