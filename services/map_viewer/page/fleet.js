// The robots of a fleet on their common map: whose path is whose, where each of them is now, and a list of them.

import {CHI_95, drawPath, drawRobot, drawText, ellipseOf, isMeasured} from "./layers.js";
import {hasPose} from "./wire.js";

const $ = (id) => document.getElementById(id);
const TAU = 2 * Math.PI;
const JOIN_MS = 8000;   // that a join is pointed at, as its news are shown
const MOST_NAMES = 4;   // of robots in a line
const [NAME_PX, LINE_PX] = [4.5, 25];  // half of a letter, and a line of drawText
const MOST_LAYOUTS = 1000000n;  // of a map: each adds one to its epoch
const whole = new Intl.NumberFormat("en");
// Of the style sheet; a ninth robot has the first one again.
export const COLOURS = Array.from({length: 8}, (_, i) => `fleet-${i}`);
export const NO_MARKS = "places are added on the page of a robot: the fleet hears of them from there";

export const isFleet = ({info}) => Boolean(info.fleet);

const stateOf = ({heard, floating}) => (!heard ? "silent" : floating ? "floating" : "joined");

// Where the robot is by its own pose, which this page hears as well; null where it does not, or is on another map.
function placeByPose({name, heard, epoch, T_common_map: [x_m, y_m, yaw_rad]}, models) {
  const own = models.find(({info}) => info.robot === name);
  if (!own?.robot || !heard || !own.connected || own.is_old || !own.info.live || !hasPose(own.robot.state)) return null;
  const num_layouts = own.cursor.epoch - BigInt(epoch);
  if (num_layouts < 0n || num_layouts > MOST_LAYOUTS) return null;
  const [cos, sin] = [Math.cos(yaw_rad), Math.sin(yaw_rad)];
  const {robot} = own;
  return {x_m: x_m + cos * robot.x_m - sin * robot.y_m, y_m: y_m + sin * robot.x_m + cos * robot.y_m,
          yaw_rad: yaw_rad + robot.yaw_rad};
}

function placeByKeyframe({newest}) {
  if (!newest) return null;
  const [x_m, y_m, yaw_rad] = newest;
  return {x_m, y_m, yaw_rad};
}

// Looks at each fleet where its robots are now: model.fleet is a list of them, null where the model is no fleet.
export function lookAtFleets(models, now_ms) {
  for (const model of models) {
    const before = model.fleet;
    if (!isFleet(model)) {
      model.fleet = null;
      continue;
    }
    const {robots, joins} = model.info.fleet;
    model.fleet = robots.map((told, index) => ({
      ...told, state: stateOf(told), colour: index % COLOURS.length, at: placeByPose(told, models) ?? placeByKeyframe(told)}));
    if (before && joins.number > model.num_joins) model.joined_at_ms = now_ms;
    model.num_joins = joins.number;
    const places = (list) => JSON.stringify(list?.map(({at}) => at));
    if (isPointedAt(model, now_ms) || places(before) !== places(model.fleet)) model.changed = true;
  }
}

const isPointedAt = ({joined_at_ms}, now_ms) => now_ms - joined_at_ms < JOIN_MS + 100;  // and is drawn once without it

export const colourOf = ({colour}, colours) => colours[`fleet_${colour}`];

function drawPaths(context, {fleet, lines}, window_m, pixel, colours, with_floating) {
  const owners = new Map(fleet.flatMap((robot) => robot.trajectories.map((trajectory) => [trajectory, robot])));
  for (const [trajectory, points] of lines) {
    if (!with_floating && points[0].state === "FLOATING") continue;
    const robot = owners.get(trajectory);
    const is_newest = robot?.at && robot.trajectories.at(-1) === trajectory;
    const tail = is_newest ? [{...robot.at, state: robot.floating ? "FLOATING" : "OK"}] : [];
    const colour = robot ? colourOf(robot, colours) : colours.path;
    drawPath(context, points, tail, window_m, pixel, {...colours, path: colour, floating: colour, good: colour}, with_floating);
  }
}

// The paths, and where each robot is, with its name: hollow where it floats, grey where it is silent.
export function drawFleet(context, model, window_m, pixel, colours, layers, turn_rad, now_ms) {
  if (layers.path) drawPaths(context, model, window_m, pixel, colours, layers.floating);
  for (const robot of model.fleet) {
    if (!robot.at) continue;
    const colour = robot.heard ? colourOf(robot, colours) : colours.dim;
    const [xx, xy, , yy] = robot.covariance;
    const drawn = {...robot.at, floating: robot.floating, state: "OK", axis: {x: 0, y: 0}, covariance: {xx, xy, yy}};
    drawRobot(context, drawn, pixel, {...colours, robot: colour, floating: colour}, layers.uncertainty);
  }
  drawNames(context, model.fleet, pixel, colours, turn_rad);
  const age_s = (now_ms - model.joined_at_ms) / 1000;
  if (age_s < JOIN_MS / 1000) drawJoins(context, model.info.fleet.joins.places, age_s % 1, pixel, colours);
}

// Beside each robot, and above the names of others that are there already.
function drawNames(context, fleet, pixel, colours, turn_rad) {
  const [right, up] = [{x: Math.cos(turn_rad), y: Math.sin(turn_rad)}, {x: -Math.sin(turn_rad), y: Math.cos(turn_rad)}];
  const taken = [];
  for (const {name, at} of fleet) {
    if (!at) continue;
    const on = (axis) => (at.x_m * axis.x + at.y_m * axis.y) / pixel;
    const box = {middle_px: on(right), up_px: on(up), half_px: NAME_PX * name.length + 8};
    const covers = (other) => Math.abs(other.middle_px - box.middle_px) < other.half_px + box.half_px &&
                              Math.abs(other.up_px - box.up_px) < LINE_PX - 1;  // not what rounding leaves
    for (let other = taken.find(covers); other; other = taken.find(covers)) box.up_px = other.up_px + LINE_PX;
    taken.push(box);
    const raised_m = box.up_px * pixel - (at.x_m * up.x + at.y_m * up.y);
    drawText(context, name, {x_m: at.x_m + raised_m * up.x, y_m: at.y_m + raised_m * up.y}, pixel, colours, turn_rad);
  }
}

function drawJoins(context, places, turn, pixel, colours) {
  context.strokeStyle = colours.good;
  context.lineWidth = 3 * pixel;
  for (const [x_m, y_m] of places) {
    for (const [radius, alpha] of [[14, 1], [14 + 40 * turn, 1 - turn]]) {
      context.globalAlpha = alpha;
      context.beginPath();
      context.arc(x_m, y_m, radius * pixel, 0, TAU);
      context.stroke();
    }
  }
  context.globalAlpha = 1;
}

function listNames(robots) {
  const names = robots.slice(0, MOST_NAMES).map(({name}) => name).join(", ");
  return robots.length > MOST_NAMES ? `${names} and ${robots.length - MOST_NAMES} more` : names;
}

// What the badge says of a fleet, as describeState does of a robot.
export function describeFleet({info}) {
  const {robots} = info.fleet;
  const [joined, floating, silent] = ["joined", "floating", "silent"].map((state) => robots.filter((robot) => stateOf(robot) === state));
  return {tone: silent.length > 0 ? "warn" : floating.length > 0 ? "floating" : "good",
          text: `${joined.length} OF ${robots.length} JOINED`,
          why: [["floating: not joined to the map yet", floating], ["not heard for ten seconds", silent]]
            .filter(([, list]) => list.length > 0).map(([what, list]) => `${listNames(list)} ${what}`).join("; ")};
}

// How far off the robot may be on the common map.
function describeDoubt({floating, covariance: [xx, xy, , yy]}) {
  if (floating) return "";
  if (!isMeasured({xx})) return "the map begins with it";
  return `± ${((100 * ellipseOf({xx, xy, yy}).long_m) / CHI_95).toFixed(1)} cm`;
}

// Those that the panel lists: of the page of a fleet its robots, of the page of a robot its fleet.
function listRows(model, models) {
  if (model.fleet) {
    return model.fleet.map((robot) => ({...robot, says: [`${whole.format(robot.keyframes)} keyframes`, describeDoubt(robot)]}));
  }
  return models.flatMap((fleet) => (fleet.fleet ?? []).filter(({name}) => name === model.info.robot).map((robot) => ({
    ...robot, name: fleet.info.robot, says: [`the common map of ${fleet.fleet.length} robots`]})));
}

// The list in the panel. choose: (index of a model) opens its page.
export function showFleet(model, models, choose) {
  const rows = listRows(model, models);
  const section = $("fleet");
  section.hidden = rows.length === 0;
  section.querySelector("h2").textContent = model.fleet ? "Robots" : "Fleet";
  section.querySelector("p").textContent = model.fleet ? NO_MARKS : "";
  const list = section.querySelector("ul");
  const names = JSON.stringify([models.map(({info}) => info.robot), rows.map(({name}) => name)]);
  if (list.dataset.shown !== names) list.replaceChildren(...rows.map(({name}) => makeRow(name, models, choose)));
  list.dataset.shown = names;
  rows.forEach(({colour, state, says}, index) => {
    const row = list.children[index];
    row.dataset.state = state;
    row.style.setProperty("--colour", `var(--fleet-${colour})`);
    row.querySelector(".state").textContent = state;
    row.querySelector(".says").textContent = says.filter(Boolean).join(" · ");
  });
}

function makeRow(name, models, choose) {
  const row = document.createElement("li");
  row.innerHTML = `<span class="swatch"></span><button></button><span class="state"></span><span class="says"></span>`;
  const button = row.querySelector("button");
  const index = models.findIndex(({info}) => info.robot === name);
  button.textContent = name;
  button.disabled = index < 0;
  button.title = index < 0 ? "Its page is not here: name it with --robots" : "Open its page";
  button.addEventListener("click", () => choose(index));
  return row;
}
