// Places with names: drawn on the map, listed in the panel, and added, moved or removed by a click or a touch.

import {drawIcon, makeIcon} from "./icons.js";
import {drawText} from "./layers.js";

const $ = (id) => document.getElementById(id);
const KINDS = ["victim", "hazard", "door", "room", "dock", "keep-out", "slow"];
export const LEAST_CORNERS = 3;
export const MOST_CORNERS = 64;
const NEAR_PX = 8;  // so near to a corner is on it

const colourOf = ({kind, floating}, colours) =>
  floating ? colours.floating : {victim: colours.bad, hazard: colours.warn, "keep-out": colours.bad, slow: colours.warn}[kind] ?? colours.path;

const titleOf = ({kind, name}) => (name ? `${kind} ${name}` : kind);

// Where the name of a place stands.
const middleOf = ({points}) => ({x_m: points.reduce((sum, [x]) => sum + x, 0) / points.length,
                                 y_m: points.reduce((sum, [, y]) => sum + y, 0) / points.length});

// Whether a place ends an outline: it is its first corner, or the last one once more.
export const endsOutline = (draft, {x_m, y_m}, px) => draft.length >= LEAST_CORNERS &&
  [draft[0], draft.at(-1)].some(([x, y]) => Math.hypot(x - x_m, y - y_m) * px < NEAR_PX);

export function drawOutline(context, points, is_closed) {
  context.beginPath();
  points.forEach(([x, y], index) => (index === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  if (is_closed) context.closePath();
}

export function drawMarks(context, marks, pixel, colours, angle_rad) {
  for (const mark of marks) {
    context.strokeStyle = context.fillStyle = colourOf(mark, colours);
    context.lineWidth = 2 * pixel;
    if (mark.points.length > 1) {
      drawOutline(context, mark.points, true);
      context.globalAlpha = 0.18;
      context.fill();
      context.globalAlpha = 1;
      context.stroke();
    } else {
      const [x, y] = mark.points[0];
      if (mark.sigma_m > 11 * pixel) {  // standard deviation of the place
        context.beginPath();
        context.arc(x, y, mark.sigma_m, 0, 2 * Math.PI);
        context.stroke();
      }
    }
    drawIcon(context, mark.kind, middleOf(mark), pixel, colourOf(mark, colours), colours.panel, angle_rad);
    drawText(context, titleOf(mark), middleOf(mark), pixel, colours, angle_rad);
  }
}

// The corners of an outline that is being made.
export function drawDraft(context, draft, pixel, colours) {
  context.strokeStyle = context.fillStyle = colours.text;
  context.lineWidth = 2 * pixel;
  context.setLineDash([6 * pixel, 4 * pixel]);
  drawOutline(context, draft, draft.length >= LEAST_CORNERS);
  context.stroke();
  context.setLineDash([]);
  for (const [x, y] of draft) context.fillRect(x - 4 * pixel, y - 4 * pixel, 8 * pixel, 8 * pixel);
}

// What Enter points at.
export function drawAim(context, {x_m, y_m}, pixel, colours, angle_rad) {
  const [right, up] = [Math.cos(angle_rad) * pixel, Math.sin(angle_rad) * pixel];
  for (const [colour, width] of [[colours.panel, 4], [colours.text, 1.5]]) {
    context.strokeStyle = colour;
    context.lineWidth = width * pixel;
    context.beginPath();
    for (const [x, y] of [[right, up], [-up, right], [-right, -up], [up, -right]]) {
      context.moveTo(x_m + 4 * x, y_m + 4 * y);
      context.lineTo(x_m + 14 * x, y_m + 14 * y);
    }
    context.stroke();
  }
}

// The form that adds places to the robot that is chosen, and the list of those that are there. view: () => its MapView;
// send: (mark) tells the viewer; without points a place is removed.
export class Marker {
  constructor(view, send) {
    this.view = view;
    this.send = send;
    this.undone = [];  // what to send for the last changes to be as they were before
    for (const kind of KINDS) $("kinds").append(new Option(kind, kind));
    $("mark_done").addEventListener("click", () => this.finishOutline());
    $("mark_undo").addEventListener("click", () => this.undo());
    $("mark_outline").addEventListener("change", () => this.setDraft([]));
    $("mark_form").addEventListener("submit", (event) => {
      event.preventDefault();
      document.activeElement.blur();  // from now on Enter says where it is
    });
  }

  get is_open() { return !$("mark_form").hidden; }

  toggle(open = !this.is_open) {
    $("mark_form").hidden = !open;
    $("mark").setAttribute("aria-pressed", open);
    this.view().setMarks(open);
    this.setDraft([]);
  }

  setDraft(corners) {
    this.view().draft = corners;
    this.view().stale = true;
    this.showButtons();
  }

  showButtons() {
    const {draft} = this.view();
    $("mark_done").hidden = !$("mark_outline").checked;
    $("mark_done").disabled = draft.length < LEAST_CORNERS;
    $("mark_undo").disabled = draft.length === 0 && this.undone.length === 0;
  }

  // Somebody has pointed at a place of the map.
  take({x_m, y_m}) {
    const point = [Number(x_m.toFixed(3)), Number(y_m.toFixed(3))];
    if (!$("mark_outline").checked) return this.add([point]);
    if (endsOutline(this.view().draft, {x_m, y_m}, this.view().camera.px)) return this.finishOutline();
    if (this.view().draft.length < MOST_CORNERS) this.setDraft([...this.view().draft, point]);
  }

  finishOutline() {
    if (this.view().draft.length < LEAST_CORNERS) return;
    this.add(this.view().draft);
    this.setDraft([]);
  }

  add(points) {
    const kind = $("mark_kind").value.trim().toLowerCase().replace(/[^a-z0-9-]+/g, "-").slice(0, 31) || "place";
    const id = `${kind.slice(0, 24)}-${crypto.getRandomValues(new Uint32Array(1))[0].toString(36)}`;
    this.send({id, kind, name: $("mark_name").value.trim(), points});
    this.undone.push({id, kind: "", name: "", points: []});
    $("mark_name").value = "";
    this.showButtons();
  }

  remove({id, kind, name, points}) {
    this.send({id, kind: "", name: "", points: []});
    this.undone.push({id, kind, name, points});
    this.showButtons();
  }

  undo() {
    if (this.view().draft.length > 0) return this.setDraft(this.view().draft.slice(0, -1));
    const last = this.undone.pop();
    if (last) this.send(last);
    this.showButtons();
  }

  // The list, as the viewer has it by now.
  show(marks, is_live) {
    $("places").parentElement.hidden = marks.length === 0;
    const list = JSON.stringify([marks, is_live]);
    if ($("places").dataset.shown === list) return;
    $("places").dataset.shown = list;
    $("places").replaceChildren(...marks.map((mark) => {
      const row = document.createElement("li");
      row.dataset.id = mark.id;
      const jump = row.appendChild(document.createElement("button"));
      jump.className = "jump";
      jump.append(makeIcon(mark.kind), titleOf(mark));
      jump.title = "Show it on the map";
      jump.addEventListener("click", () => {
        const {x_m, y_m} = middleOf(mark);
        const view = this.view();
        view.setFollows(false);
        view.fits = false;
        view.centre(x_m, y_m);
      });
      const what = row.appendChild(document.createElement("span"));
      what.textContent = mark.floating ? "floating"
        : mark.points.length > 1 ? "outline" : `± ${mark.sigma_m.toFixed(2)} m${mark.sightings > 1 ? `, ${mark.sightings} ×` : ""}`;
      if (is_live) {
        const remove = row.appendChild(document.createElement("button"));
        remove.className = "remove";
        remove.textContent = "remove";
        remove.addEventListener("click", () => this.remove(mark));
      }
      return row;
    }));
  }
}
