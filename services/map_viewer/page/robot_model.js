// All that the page knows of one robot, and who is to be told when it changes.

import {MapModel} from "./map_model.js";

const MOST_SAMPLES = 1024;
const MOST_TAIL = 4000;
const TAIL_STEP_M = 0.1;

export class RobotModel extends EventTarget {
  constructor() {
    super();
    this.map = new MapModel();
    this.cursor = {epoch: 0n, version: 0n};
    this.robot = null;
    this.path = [];
    this.path_generation = 0;
    this.tail = [];  // where the robot was seen since the path was told last
    this.samples = [];
    this.info = {services: [], loops: [], robots: [""], robot: ""};
    this.num_news = null;  // that were told so far
    this.connected = false;
    this.trouble = "";     // what the page could not show, if anything
    this.changed = true;  // since it was drawn
  }

  tell(type, detail) {
    this.changed = true;
    this.dispatchEvent(new CustomEvent(type, {detail}));
  }

  setConnected(connected) {
    this.connected = connected;
    if (connected) this.samples = [];  // they come again
    if (connected) this.trouble = "";
    this.tell("connection");
  }

  take(record) {
    this[`take_${record.kind}`](record);
    this.tell(record.kind);
  }

  take_map({anew, epoch, version, complete, cell_size_m, tiles}) {
    if (anew) {
      this.map.clear();
      this.cursor = {epoch: 0n, version: 0n};
    }
    this.map.cell_size_m = cell_size_m;
    for (const tile of tiles) this.map.take(tile);
    if (!complete) return;
    const corrected = this.cursor.epoch !== 0n && epoch !== this.cursor.epoch;
    this.cursor = {epoch, version};
    if (corrected) this.tell("corrected");
  }

  take_robot(robot) {
    if (![robot.x_m, robot.y_m, robot.yaw_rad].every(Number.isFinite)) return;  // it is nowhere
    this.robot = robot;
    const last = this.tail.at(-1);
    if (robot.state === "LOST") return;
    if (last && Math.hypot(robot.x_m - last.x_m, robot.y_m - last.y_m) < TAIL_STEP_M) return;
    this.tail.push({x_m: robot.x_m, y_m: robot.y_m, state: robot.floating ? "FLOATING" : "OK"});
    if (this.tail.length > MOST_TAIL) this.tail.shift();
  }

  take_path({generation, first, points}) {
    if (generation !== this.path_generation || first < this.path.length) this.path.length = 0;
    this.path_generation = generation;
    this.path.push(...points);
    const end = this.path.at(-1);
    if (!end) return;
    const ways_m = this.tail.map(({x_m, y_m}) => Math.hypot(x_m - end.x_m, y_m - end.y_m));
    this.tail.splice(0, 1 + ways_m.lastIndexOf(Math.min(...ways_m)));
  }

  take_samples({samples}) { this.samples = [...this.samples, ...samples].slice(-MOST_SAMPLES); }

  take_info(info) {
    this.info = {services: [], loops: [], ...info};
    const {number, text} = info.news ?? {number: 0, text: ""};
    if (this.num_news !== null && number > this.num_news) this.tell("news", text);
    this.num_news = number;
  }
}
