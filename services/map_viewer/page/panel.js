// The numbers beside the map, of the robot that is chosen.

import {drawFitness, drawTimes} from "./charts.js";
import {CHI_95, ellipseOf, isMeasured} from "./layers.js";
import {isFleet} from "./fleet.js";
import {formatTime} from "./player.js";
import {SILENT_S, describeState, localises, seconds, toAxisDegrees} from "./state.js";

const TROUBLE = /malformed|refused|dropped|failed|lost|missing|late|contradicted|cut|ignored|unknown/;
const $ = (id) => document.getElementById(id);
const whole = new Intl.NumberFormat("en");

function show(id, text) {
  if ($(id).textContent !== text) $(id).textContent = text;
}

// A number with so many digits behind the point; a dash for what is none.
const fixed = (value, digits) => (Number.isFinite(value) ? value.toFixed(digits).replace(/^-(0\.0+)$/, "$1") : "–");

const milliseconds = (time_ms) => fixed(time_ms, time_ms < 10 ? 2 : 0);

const NOWHERE = {x_m: NaN, y_m: NaN, yaw_rad: NaN, fitness: NaN, covariance: {xx: 0, xy: 0, yy: 0, yaw: 0}};

function showPose(model) {
  const robot = model.is_nowhere ? NOWHERE : model.robot;
  if (!robot) return;
  const degrees = (radians) => (radians * 180) / Math.PI;
  const {long_m, short_m, angle_rad} = ellipseOf(robot.covariance);
  const known = isMeasured(robot.covariance);
  show("along", known && long_m > 1.05 * short_m ? `± along ${toAxisDegrees(angle_rad)}°` : "± along");
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
  details.innerHTML = `<summary><span class="health"></span><span class="title"></span>
    <span class="said"></span><span class="took"></span></summary><table></table>`;
  details.querySelector(".title").textContent = name;
  details.dataset.name = name;
  return details;
}

function showService(details, service) {
  const has_ended = service.state === "finished";
  const is_silent = service.silent_s > SILENT_S && !has_ended;
  details.querySelector(".health").dataset.health = is_silent ? "silent" : has_ended ? "ended" : "well";
  details.querySelector(".took").textContent = service.max_ms > 0 ? `${milliseconds(service.p50_ms)} ms` : "";
  details.querySelector(".said").textContent =
    is_silent ? `silent for ${fixed(service.silent_s, 0)} s` : service.state;
  if (!details.open) return;
  const times_ms = [service.p50_ms, service.p99_ms, service.max_ms];
  const rows = [["state", service.state], ...Object.entries(service.counters).map(([name, count]) => [name, whole.format(count)]),
                ["median / 99 % / longest [ms]", times_ms.map(milliseconds).join(" / ")],
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

const SCANS_OF_CHART = 300;

function showFitness({samples, timeline}) {
  const shown = timeline ? timeline.samples(SCANS_OF_CHART) : samples.slice(-SCANS_OF_CHART);
  drawFitness($("fitness_chart"), shown);
  const [from, to] = [shown[0], shown.at(-1)];
  if (timeline) {
    show("fitness_from", formatTime(timeline.clock_s[timeline.at + 1 - shown.length]));
    show("fitness_to", formatTime(timeline.clock_s[timeline.at]));
  } else {
    show("fitness_from", to?.time_s > from?.time_s ? `−${seconds(to.time_s - from.time_s)}` : "");
    show("fitness_to", "now");
  }
}

function showInfo(model) {
  const {info} = model;
  const facts = {...info, ...(model.then && model.factsThen())};
  const times_ms = info.scan_times_ms ?? [];
  showCounts(facts);
  show("loops", whole.format(Math.max(facts.loops.length, facts.loops_closed ?? 0)));
  show("scan_time", times_ms.length ? `${fixed(times_ms.at(-1)[0], 2)} ms` : "–");
  show("time_from", times_ms.length > 1 ? `−${seconds(times_ms.length)}` : "");
  drawTimes($("time_chart"), times_ms);
  showServices(info.services);
  showVerdict(model.then ? null : info.verdict);
  showPieces(info);
  showChanges(info);
}

// The numbers of summary.json by the same names. Who has none of these scans needs no word for them.
function showCounts(info) {
  show("scans", whole.format(info.scans ?? 0));
  show("lost", whole.format(info.lost ?? 0));
  for (const name of ["floating", "without_rays", "left_out"]) {
    const count = info[name] ?? 0;
    show(name, whole.format(count));
    $(name).parentElement.hidden = !(count > 0);
  }
}

// The pieces of the map of a run that has ended, and where they lie. A click shows one: main.js.
function showPieces({pieces = [], shown_piece}) {
  $("pieces").parentElement.hidden = pieces.length < 2;
  const list = JSON.stringify([pieces, shown_piece]);
  if ($("pieces").dataset.shown === list) return;
  $("pieces").dataset.shown = list;
  $("pieces").replaceChildren(...pieces.map(({piece, scans, way_m, folder}) => {
    const row = document.createElement("li");
    row.className = piece === shown_piece ? "shown" : "";
    const can_be_shown = folder && piece !== shown_piece;
    row.innerHTML = `<${can_be_shown ? "button" : "span"}></${can_be_shown ? "button" : "span"}><span></span><span></span>`;
    const texts = [`piece ${piece}${piece === shown_piece ? ", shown" : ""}`,
                   `${whole.format(scans)} scans · ${fixed(way_m, 0)} m`, folder ?? "too small: no folder"];
    texts.forEach((text, i) => { row.children[i].textContent = text; });
    row.children[0].dataset.piece = piece;
    return row;
  }));
}

// What has changed since the map was made, the largest first. A click goes there: main.js.
function showChanges({changes = []}) {
  $("changes").parentElement.hidden = changes.length === 0;
  const list = JSON.stringify(changes);
  if ($("changes").dataset.shown === list) return;
  $("changes").dataset.shown = list;
  $("changes").replaceChildren(...changes.map(({kind, x_m, y_m, length_m, width_m, places}) => {
    const row = document.createElement("li");
    const button = row.appendChild(document.createElement("button"));
    Object.assign(button.dataset, {kind, x_m, y_m});
    button.title = "Go there";
    button.textContent = `${kind} · ${fixed(length_m, 1)} × ${fixed(width_m, 1)} m · ${whole.format(places)} places`;
    return row;
  }));
}

function showVerdict(verdict) {
  const lines = (verdict?.lines ?? []).map(String);
  if ($("verdict").dataset.shown === lines.join("\n")) return;
  $("verdict").dataset.shown = lines.join("\n");
  $("verdict").replaceChildren(...lines.map((line) => {
    const paragraph = document.createElement("p");
    paragraph.textContent = line;
    return paragraph;
  }));
}

// How much of the run there is, in a line.
function describeRun(model) {
  const {info, way_m, map, timeline} = model;
  const scans = info.scans ?? 0;
  const words = scans > 0 ? [`${whole.format(scans)} ${isFleet({info}) ? "keyframes" : "scans"}`] : [];
  if (timeline && !timeline.is_at_end) words[0] = `scan ${whole.format(timeline.at + 1)} of ${whole.format(timeline.num)}`;
  if (timeline) words.push(formatTime(timeline.clock_s[timeline.at]));
  const metres = model.then ? model.factsThen().way_m : info.way_m ?? way_m;
  if (metres > 0) words.push(metres < 1000 ? `${fixed(metres, 0)} m` : `${fixed(metres / 1000, 2)} km`);
  const area_m2 = map.area_m2();
  if (area_m2 > 0) words.push(`${whole.format(Math.round(area_m2))} m²`);
  return words.join(" · ");
}

// The badge, and the words beside it. Who cannot see it is told when it changes, not each second.
export function showState(model, now_ms) {
  const {tone, text, why} = describeState(model, now_ms);
  const title = `${text} · ${model.info.robot || "CRSM map"}`;
  if (document.title !== title) document.title = title;
  $("last_known").hidden = !model.is_old || model.is_nowhere;
  $("state").dataset.tone = tone;
  show("state", text);
  show("why", why);
  const spoken = `${text.replace(/ for .*/, "")}. ${why.replace(/ for \d.*/, "")}`;
  show("spoken", spoken);
}

// Shows what has changed of a model; all of it where `all` says so.
export function showPanel(model, changed, all) {
  const {info} = model;
  if ($("name").textContent !== info.robot) $("name").firstElementChild.textContent = info.robot;
  $("name").hidden = !info.robot;
  show("counts", describeRun(model));
  $("panel").classList.toggle("finished", info.live === false);
  document.body.classList.toggle("simulated", (info.truth ?? []).length > 0);
  document.body.classList.toggle("fleet", isFleet(model));
  document.body.classList.toggle("marking", info.live === true && !info.looks);
  document.body.classList.toggle("knows_then", Boolean(info.knows_then));
  document.body.classList.toggle("editing", info.live === false);
  document.body.classList.toggle("localising", localises(model) && info.live !== false && !info.looks);
  if (all || changed.has("robot") || changed.has("moment")) showPose(model);
  if (all || changed.has("samples") || changed.has("moment") || changed.has("timeline")) showFitness(model);
  if (all || changed.has("info") || changed.has("then") || (model.then && changed.has("moment"))) showInfo(model);
  if (all || changed.has("map")) show("area", whole.format(Math.round(model.map.area_m2())));
}
