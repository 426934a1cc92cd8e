// The bar below a run that has ended: a slider over its scans, what happened when, and play.

import {hasPose} from "./wire.js";

const $ = (id) => document.getElementById(id);
const SPEEDS = [1, 4, 16, 64, 256];
const WHOLE_S = 60;  // in which a run is played at first
const COLOURS = {LOST: "--bad", "NO RAYS": "--bad", DEGENERATE: "--warn", FLOATING: "--floating", loop: "--loop", break: "--bad", joined: "--good"};

export function formatTime(seconds) {
  const whole = Math.max(0, Math.floor(seconds));
  const two = (number) => String(number).padStart(2, "0");
  const minutes = `${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}`;
  return whole < 3600 ? minutes : `${Math.floor(whole / 3600)}:${minutes}`;
}

export class Player {
  // show: called with the number of the scan that is to be shown.
  constructor(show) {
    this.show = show;
    this.timeline = null;
    this.info = null;  // with which the marks were made
    this.marks = [];
    this.playing = false;
    this.clock_s = 0;
    this.speed = 1;
    $("play").addEventListener("click", () => this.setPlaying(!this.playing));
    $("speed").addEventListener("click", () => this.setSpeed(SPEEDS[(SPEEDS.indexOf(this.speed) + 1) % SPEEDS.length]));
    $("moment").addEventListener("input", () => this.goTo(Number($("moment").value)));
  }

  // Of another run, or of none.
  take(timeline, info) {
    if (timeline !== this.timeline) {
      this.timeline = timeline;
      this.info = null;
      this.setPlaying(false);
      document.body.classList.toggle("finished", Boolean(timeline));
      if (!timeline) return;
      $("moment").max = timeline.num - 1;
      $("whole_time").textContent = `/ ${formatTime(timeline.duration_s)}`;
      this.setSpeed(SPEEDS.find((speed) => timeline.duration_s / speed <= WHOLE_S) ?? SPEEDS.at(-1));
    }
    if (timeline && info !== this.info) this.marks = timeline.marks(info);
    this.info = info;
    if (timeline) this.drawMarks();
    this.tell();
  }

  setSpeed(speed) {
    this.speed = speed;
    $("speed").textContent = `${speed}×`;
    $("speed").setAttribute("aria-label", `Speed: ${speed} times`);
  }

  setPlaying(playing) {
    this.playing = playing && Boolean(this.timeline);
    if (this.playing && this.timeline.is_at_end) this.goTo(0);
    if (this.timeline) this.clock_s = this.timeline.clock_s[this.timeline.at];
    this.last_ms = performance.now();
    $("play").setAttribute("aria-label", this.playing ? "Pause" : "Play");
    $("play").title = this.playing ? "Pause (space)" : "Play (space)";
    $("play").classList.toggle("playing", this.playing);
  }

  goTo(number) {
    if (!this.timeline) return;
    this.show(number);
    this.clock_s = this.timeline.clock_s[this.timeline.at];
    this.tell();
  }

  step(scans) { if (this.timeline) this.goTo(this.timeline.at + scans); }

  // To be called each frame.
  tick(now_ms) {
    if (!this.playing) return;
    this.clock_s += ((now_ms - this.last_ms) / 1000) * this.speed;
    this.last_ms = now_ms;
    const at = this.timeline.find(this.clock_s);
    if (at !== this.timeline.at) this.show(at);
    this.tell();
    if (this.timeline.is_at_end) this.setPlaying(false);
  }

  tell() {
    const {timeline} = this;
    if (!timeline) return;
    const text = formatTime(timeline.clock_s[timeline.at]);
    if ($("time").textContent === text && Number($("moment").value) === timeline.at) return;
    $("moment").value = timeline.at;
    $("moment").setAttribute("aria-valuetext", `${text} of ${formatTime(timeline.duration_s)}, scan ${timeline.at + 1} of ${timeline.num}`);
    $("time").textContent = text;
  }

  // Bars where the robot was lost, floated or was held in one direction only, paler where few scans were; ticks at loops,
  // breaks and joins.
  drawMarks() {
    const canvas = $("marks");
    const ratio = window.devicePixelRatio || 1;
    const {width, height} = canvas.getBoundingClientRect();
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    const context = canvas.getContext("2d");
    const style = getComputedStyle(document.documentElement);
    const colours = Object.fromEntries(Object.entries(COLOURS).map(([what, name]) => [what, style.getPropertyValue(name)]));
    const {timeline} = this;
    const scale = canvas.width / Math.max(1, timeline.num - 1);
    for (const state of ["DEGENERATE", "FLOATING", "NO RAYS", "LOST"]) {
      context.fillStyle = colours[state];
      for (let x = 0; x < canvas.width; ++x) {
        const share = timeline.shareOf(state, x / canvas.width, (x + 1) / canvas.width);
        if (share === 0) continue;
        context.globalAlpha = state === "DEGENERATE" ? Math.max(0.15, 0.7 * share) : 1;
        context.fillRect(x, canvas.height / 2, hasPose(state) ? 1 : 2 * ratio, canvas.height / 2);
      }
    }
    context.globalAlpha = 1;
    for (const {at, kind} of this.marks) {
      context.fillStyle = colours[kind];
      context.fillRect(Math.round(at * scale) - ratio, 0, (kind === "loop" ? 1.5 : 3) * ratio, canvas.height / 2);
    }
  }
}
