// The numbers beside the map, of the robot that is chosen.

import {drawFitness, drawTimes} from "./charts.js";
import {ellipseOf, isMeasured} from "./layers.js";

const CHI_95 = Math.sqrt(5.991);
const SILENT_S = 3;  // three statuses are missing
const TROUBLE = /malformed|refused|dropped|failed|lost|missing|late|contradicted|cut|ignored|unknown/;
const $ = (id) => document.getElementById(id);
const whole = new Intl.NumberFormat("en");

function show(id, text) {
  if ($(id).textContent !== text) $(id).textContent = text;
}

// A number with so many digits behind the point; a dash for what is none.
const fixed = (value, digits) => (Number.isFinite(value) ? value.toFixed(digits) : "–");

export function describeState({robot, connected, trouble}) {
  if (trouble) return {state: "off", text: `page error: ${trouble}`};
  if (!connected) return {state: "off", text: "no connection"};
  if (!robot) return {state: "none", text: "waiting for scans"};
  if (robot.state !== "DEGENERATE") return {state: robot.state, text: robot.state};
  const axis_deg = Math.round((Math.atan2(robot.axis.y, robot.axis.x) * 180) / Math.PI + 180) % 180;
  return {state: robot.state, text: `DEGENERATE along ${axis_deg}°`};
}

// What the robot's pose is worth on the map, where it is none of it; else nothing.
export function describeFloating({robot}) {
  return robot?.floating ? `floating: not joined to the map yet (trajectory ${robot.trajectory})` : "";
}

function showPose({robot}) {
  if (!robot) return;
  const degrees = (radians) => (radians * 180) / Math.PI;
  const {long_m, short_m} = ellipseOf(robot.covariance);
  const known = isMeasured(robot.covariance);
  show("x", fixed(robot.x_m, 2));
  show("y", fixed(robot.y_m, 2));
  show("yaw", fixed(degrees(robot.yaw_rad), 1));
  show("sigma_long", known ? fixed((100 * long_m) / CHI_95, 1) : "–");
  show("sigma_short", known ? fixed((100 * short_m) / CHI_95, 1) : "–");
  show("sigma_yaw", known ? fixed(degrees(Math.sqrt(robot.covariance.yaw)), 2) : "–");
  show("fitness", fixed(robot.fitness, 3));
}

function makeService(name) {
  const details = document.createElement("details");
  details.innerHTML = `<summary><span class="health"></span><span class="title"></span><span class="took"></span>
    <span class="said"></span></summary><table></table>`;
  details.querySelector(".title").textContent = name;
  details.dataset.name = name;
  return details;
}

function showService(details, service) {
  details.querySelector(".health").dataset.health = service.silent_s > SILENT_S ? "silent" : "well";
  details.querySelector(".took").textContent = service.max_ms > 0 ? `${fixed(service.p50_ms, 2)} ms` : "";
  details.querySelector(".said").textContent =
    service.silent_s > SILENT_S ? `silent for ${fixed(service.silent_s, 0)} s` : service.state;
  if (!details.open) return;
  const times_ms = [service.p50_ms, service.p99_ms, service.max_ms];
  const rows = [...Object.entries(service.counters).map(([name, count]) => [name, whole.format(count)]),
                ["p50 / p99 / max [ms]", times_ms.map((time_ms) => fixed(time_ms, 2)).join(" / ")],
                ["memory", `${fixed(service.resident_mb, 1)} MB`], ["process", `${service.pid}, ${service.version}`]];
  details.querySelector("table").replaceChildren(...rows.map(([name, value]) => {
    const row = document.createElement("tr");
    row.className = TROUBLE.test(name) && value !== "0" ? "trouble" : "";
    for (const text of [name, value]) row.appendChild(document.createElement("td")).textContent = text;
    return row;
  }));
}

function showServices(services) {
  const list = $("services");
  const shown = new Map([...list.children].map((details) => [details.dataset.name, details]));
  const wanted = services.map((service) => {
    const details = shown.get(service.name) ?? makeService(service.name);
    showService(details, service);
    return details;
  });
  const same = wanted.length === list.children.length && wanted.every((details, i) => details === list.children[i]);
  if (!same) list.replaceChildren(...wanted);
}

function showInfo(model) {
  const {info} = model;
  const times_ms = info.scan_times_ms ?? [];
  show("scans", whole.format(info.scans ?? 0));
  show("lost", whole.format(info.lost ?? 0));
  show("loops", whole.format(Math.max(info.loops.length, info.loops_closed ?? 0)));
  show("scan_time", times_ms.length ? `${fixed(times_ms.at(-1)[0], 2)} ms` : "–");
  drawTimes($("time_chart"), times_ms);
  showServices(info.services);
}

// Shows what has changed of a model; all of it where `all` says so.
export function showPanel(model, changed, all) {
  const {state, text} = describeState(model);
  $("state").dataset.state = state;
  show("state", text);
  show("floating", describeFloating(model));
  show("name", model.info.live === false ? `finished run ${model.info.robot}` : model.info.robot);
  show("counts", model.cursor.version > 0n ? `map version ${whole.format(model.cursor.version)}` : "");
  $("panel").classList.toggle("finished", model.info.live === false);
  if (all || changed.has("robot")) showPose(model);
  if (all || changed.has("samples")) drawFitness($("fitness_chart"), model.samples);
  if (all || changed.has("info")) showInfo(model);
  if (all || changed.has("map")) show("area", whole.format(Math.round(model.map.area_m2())));
}
