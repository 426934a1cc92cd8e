// Edits of a copy of a finished map: it is cropped, erased and turned. What is drawn here is a preview; the viewer keeps
// the edits beside the map, and makes the edited one of them.

import {findWalls} from "./map_model.js";
import {LEAST_CORNERS, MOST_CORNERS, drawOutline, endsOutline} from "./marks.js";
import {readToken} from "./wire.js";

const $ = (id) => document.getElementById(id);
const MOST_ERASURES = 100;  // as map_edits.hpp has it
const MOST_BYTES = 60000;   // of a message to the viewer
const ANSWER_MS = 3000;     // that the viewer may take to say what it was told
const STRAIGHT_DEG = 0.05;  // less is no turn: a cell in 50 m

const toDegrees = (angle_rad) => Math.round((angle_rad * 180e3) / Math.PI) / 1000;
const round = ({x_m, y_m}) => [Number(x_m.toFixed(3)), Number(y_m.toFixed(3))];

// The same text for the same edits, with what the viewer needs and nothing else.
const textOf = ({crop_m, erase = [], turn_deg = 0}) =>
  JSON.stringify({...(crop_m && {crop_m}), erase: erase.map(({becomes, outline_m}) => ({becomes, outline_m})), turn_deg});

const EMPTY = textOf({});

const isOutline = (points) => Array.isArray(points) && points.length <= MOST_CORNERS &&
  points.every((point) => Array.isArray(point) && point.length === 2 && point.every(Number.isFinite));

// Of what this browser has kept, which another page of this address may have written. Null where it is none.
function readKept(key) {
  try {
    const edits = JSON.parse(localStorage.getItem(key));
    const outlines = [edits.crop_m ?? [], ...edits.erase.map(({outline_m}) => outline_m)];
    return outlines.every(isOutline) && Number.isFinite(edits.turn_deg) ? textOf(edits) : null;
  } catch {
    return null;
  }
}

const HINTS = {
  crop: "Drag a rectangle around what is to stay.",
  free: "Outline what people left: click its corners, and the first one again. Walls in it become free.",
  unexplored: "Outline what is not there, as behind glass: click its corners, and the first one again.",
};

const cornersOf = (crop_m) => {
  if (crop_m.length !== 2) return crop_m;
  const [[x0, y0], [x1, y1]] = crop_m;
  return [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
};

// The corners of a rectangle along the edges of the screen, from two that lie opposite.
export function boxCorners(view, from, to) {
  const [a, b] = [from, to].map(({x_m, y_m}) => view.turn(x_m, y_m));
  return [[a.right_m, a.up_m], [b.right_m, a.up_m], [b.right_m, b.up_m], [a.right_m, b.up_m]].map(
    ([right_m, up_m]) => round(view.turnBack(right_m, up_m)));
}

export function drawEdits(context, {crop_m, erase = []}, {x0, x1, y0, y1}, pixel, colours) {
  context.lineWidth = 2 * pixel;
  for (const {becomes, outline_m} of erase) {
    drawOutline(context, outline_m, true);
    context.fillStyle = becomes === "free" ? colours.free : colours.ground;
    context.strokeStyle = colours.loop;
    context.globalAlpha = 0.75;
    context.fill();
    context.globalAlpha = 1;
    context.stroke();
  }
  if (!crop_m) return;
  const corners = cornersOf(crop_m);
  const outside = new Path2D();
  outside.rect(x0, y0, x1 - x0, y1 - y0);
  corners.forEach(([x, y], index) => (index === 0 ? outside.moveTo(x, y) : outside.lineTo(x, y)));
  outside.closePath();
  context.fillStyle = colours.ground;
  context.globalAlpha = 0.8;
  context.fill(outside, "evenodd");
  context.globalAlpha = 1;
  drawOutline(context, corners, true);
  context.strokeStyle = colours.good;
  context.stroke();
}

// The form that edits the map of the run that is chosen. view: () => its MapView; send: (text) tells the viewer.
export class Editor {
  constructor(view, send, query) {
    this.view = view;
    this.send = send;
    this.query = query;  // () => which run it is, for a request
    this.undone = [];  // edits as they were, the last before now at the end
    this.redone = [];
    $("edit_tool").addEventListener("change", () => this.setDraft([]));
    $("edit_done").addEventListener("click", () => this.finishOutline());
    $("edit_turn").addEventListener("click", () => this.toggleTurn());
    $("edit_undo").addEventListener("click", () => this.undo());
    $("edit_redo").addEventListener("click", () => this.redo());
    $("edit_reset").addEventListener("click", () => this.change({}));
    $("edit_form").addEventListener("submit", (event) => event.preventDefault());
    addEventListener("keydown", (event) => {
      if (!this.is_open || !(event.ctrlKey || event.metaKey) || !["z", "y"].includes(event.key.toLowerCase())) return;
      event.preventDefault();
      event.shiftKey || event.key.toLowerCase() === "y" ? this.redo() : this.undo();
    });
  }

  get is_open() { return !$("edit_form").hidden; }
  get crops() { return $("edit_tool").value === "crop"; }

  // Under which this browser keeps the edits, where the viewer takes none: one may only look, or the folder is not to be
  // written. Empty where it takes them.
  get key() {
    const {info, cursor} = this.view().model;
    return info.edits && !info.looks ? "" : `edits ${info.robot} ${cursor.epoch}`;
  }

  // What the viewer was told last, or what it says.
  get edits() {
    const kept = this.key && readKept(this.key);
    if (kept) return JSON.parse(kept);
    const said = textOf(this.view().model.info.edits?.edits ?? {});
    if (said === this.told || !(performance.now() - this.told_at_ms < ANSWER_MS)) this.told = null;
    return JSON.parse(this.told ?? said);
  }

  toggle(open = !this.is_open) {
    $("edit_form").hidden = !open;
    $("edit").setAttribute("aria-pressed", open);
    this.view().setMarks(open);
    this.told = null;
    this.undone = [];
    this.redone = [];
    if (!open) return (this.view().edits = null);
    const {turn_deg} = this.edits;
    if (turn_deg !== 0 && this.view().camera.turn_rad === 0) this.view().camera.turn_rad = -turn_deg * Math.PI / 180;
    if (this.view().fits) this.view().fit();
    this.setDraft([]);
  }

  setDraft(corners) {
    this.view().draft = corners;
    this.view().boxes = this.is_open && this.crops;
    this.show();
  }

  // Somebody has pointed at a place of the map.
  take(place) {
    const {draft, camera} = this.view();
    if (this.crops && draft.length === 0) return this.setDraft([round(place)]);
    if (this.crops) return this.crop({x_m: draft[0][0], y_m: draft[0][1]}, place);
    if (endsOutline(draft, place, camera.px)) return this.finishOutline();
    if (draft.length < MOST_CORNERS) this.setDraft([...draft, round(place)]);
  }

  crop(from, to) {
    const crop_m = boxCorners(this.view(), from, to);
    const least_m = 2 * this.view().model.map.cell_size_m;
    const [[ax, ay], [bx, by], [cx, cy]] = crop_m;
    if (Math.min(Math.hypot(bx - ax, by - ay), Math.hypot(cx - bx, cy - by)) >= least_m) this.change({...this.edits, crop_m});
    this.setDraft([]);
  }

  finishOutline() {
    const {draft} = this.view();
    if (this.crops || draft.length < LEAST_CORNERS) return;
    const erasure = {becomes: $("edit_tool").value, outline_m: draft};
    this.change({...this.edits, erase: [...this.edits.erase, erasure]});
    this.setDraft([]);
  }

  // The view turns along, so that the map lies there as it will.
  toggleTurn() {
    const {edits} = this;
    const view = this.view();
    const turn_deg = edits.turn_deg === 0 ? toDegrees(-findWalls(view.model.map)) : 0;
    this.is_straight = edits.turn_deg === 0 && Math.abs(turn_deg) < STRAIGHT_DEG;
    if (!this.is_straight) this.change({...edits, turn_deg});
    if (!this.is_straight && (turn_deg === 0) === (view.camera.turn_rad !== 0)) view.toggleTurn();
    this.show();
  }

  change(edits) {
    const text = textOf(edits);
    const before = textOf(this.edits);
    if (text === before) return;
    this.is_full = (edits.erase?.length ?? 0) > MOST_ERASURES || text.length > MOST_BYTES;
    if (!this.is_full) {
      this.undone.push(before);
      this.redone = [];
      this.tell(text);
    }
    this.show();
  }

  tell(text) {
    this.is_straight = this.is_full = false;
    if (this.key) return localStorage.setItem(this.key, text);
    this.told = text;
    this.told_at_ms = performance.now();
    this.send(`edits ${text}`);
  }

  undo() {
    if (this.view().draft.length > 0) return this.setDraft(this.view().draft.slice(0, -1));
    this.step(this.undone, this.redone);
  }

  redo() { this.step(this.redone, this.undone); }

  step(from, to) {
    if (from.length === 0) return;
    to.push(textOf(this.edits));
    this.tell(from.pop());
    this.show();
  }

  // What the viewer says by now.
  show() {
    if (!this.is_open) return;
    const view = this.view();
    const {edits} = this;
    const {state, why} = view.model.info.edits ?? {};
    view.edits = edits;
    view.stale = true;
    $("edit_hint").textContent = HINTS[$("edit_tool").value];
    $("edit_done").hidden = this.crops;
    $("edit_done").disabled = view.draft.length < LEAST_CORNERS;
    $("edit_turn").setAttribute("aria-pressed", edits.turn_deg !== 0);
    $("edit_undo").disabled = view.draft.length === 0 && this.undone.length === 0;
    $("edit_redo").disabled = this.redone.length === 0;
    $("edit_reset").disabled = textOf(edits) === EMPTY;
    const parts = [edits.crop_m && "cropped", edits.erase.length > 0 && `${edits.erase.length} erased`,
                   edits.turn_deg !== 0 && `turned by ${edits.turn_deg.toFixed(1)}°`].filter(Boolean);
    const is_kept = Boolean(this.key);
    const is_written = state === "written" && !this.told;
    const text = this.is_straight ? "The walls lie along the axes already."
      : this.is_full ? "There is no room for more edits."
      : state === "failed" && !is_kept ? why
      : parts.length === 0 ? "Nothing is changed. The map itself always stays as it is."
      : is_kept ? `${parts.join(", ")}; this browser keeps it. slam_eval export --edits edits.json makes the map of it.`
      : `${parts.join(", ")}; ${is_written ? "map_edited.png is beside the map" : "is being written"}`;
    if ($("edit_state").textContent !== text) $("edit_state").textContent = text;  // a reader of screens says it once
    $("edit_state").dataset.tone = (state === "failed" && !is_kept) || this.is_full ? "bad" : "";
    const link = $("edit_download");
    link.hidden = !((is_written || is_kept) && parts.length > 0);
    link.textContent = is_kept ? "Download edits" : "Download edited map";
    link.download = is_kept ? "edits.json" : "map_edited.tar";
    link.href = is_kept ? `data:application/json,${encodeURIComponent(textOf(edits))}` : `files/map_edited.tar?${this.query()}`;
  }
}
