// The page: a map for each robot, the panel of the one that is chosen, and the tools.

import {showDownloads} from "./downloads.js";
import {Editor} from "./edits.js";
import {NO_MARKS, isFleet, lookAtFleets, showFleet} from "./fleet.js";
import {formatDistance} from "./layers.js";
import {DEFAULT_LAYERS, DEFAULT_PX, MapView} from "./map_view.js";
import {Marker} from "./marks.js";
import {showPanel, showState} from "./panel.js";
import {composeFigure, composePicture, scaleOf} from "./picture.js";
import {Player} from "./player.js";
import {RobotModel} from "./robot_model.js";
import {describeCorrection, describeState} from "./state.js";
import {Connection, hasPose} from "./wire.js";

const $ = (id) => document.getElementById(id);
const TOAST_MS = 3000;
const NEWS_MS = 8000;
const TROUBLE_MS = 1500;  // that an error is shown after the last one
const SCANS_OF_PIN = 20;  // in which a robot is found near it, or not
const STATE_MS = 250;  // between two looks at how long ago something came
const LINK_MS = 500;   // between two changes of the address: browsers allow a hundred in half a minute
const robots = [];  // {model, view, changed, connection}
let chosen = 0;
let default_mode = "beside";
const player = new Player((number) => robots[chosen].model.goTo(number));

function addRobot(index) {
  const parent = $("maps").appendChild(document.createElement("div"));
  parent.className = "map";
  parent.style.setProperty("--index", index);
  const model = new RobotModel();
  const is_linked = index === (wanted.has("robot") ? robots[0]?.model.info.robots.indexOf(wanted.get("robot")) : 0);
  model.wants_then = wanted.get("map") !== "last";
  const robot = {model, view: new MapView(parent, model), changed: new Set(), parent, is_linked};
  for (const type of ["connection", "map", "robot", "path", "samples", "info", "timeline", "moment", "then"]) {
    model.addEventListener(type, () => robot.changed.add(type));
  }
  model.addEventListener("corrected", ({detail}) => toast(describeCorrection(detail)));
  model.addEventListener("news", ({detail}) => toast(detail, NEWS_MS));
  model.addEventListener("info", () => {
    if (model.shows_then && !model.then) model.goTo(model.timeline.at);  // since now it is known
    label(robot);
    openFleet(robot, index);
  });
  model.addEventListener("moment", ({detail}) => {
    robot.connection.say(`scan ${detail}`);
    if (model.shows_then || model.then) robot.connection.say(`then ${model.shows_then ? detail : model.timeline.num - 1}`);
  });
  model.addEventListener("connection", () => { if (model.connected) model.goTo(model.timeline?.at); });
  model.addEventListener("timeline", () => openFinished(robot));
  robot.view.addEventListener("chosen", () => { if (index !== chosen) choose(index); });
  robot.view.addEventListener("follows", () => showTools());
  robot.view.addEventListener("pointed", ({detail}) => showCursor(robot, detail));
  robot.view.addEventListener("placed", ({detail: {x_m, y_m, yaw_rad}}) => {
    robot.connection.say(`start ${x_m.toFixed(3)} ${y_m.toFixed(3)} ${yaw_rad.toFixed(4)}`);
    toast("the matcher was told where the robot is");
    robot.pinned = {x_m, y_m, num_scans: 0};
  });
  model.addEventListener("robot", () => tellPinned(robot));
  robot.view.addEventListener("marked", ({detail}) => (editor.is_open ? editor : marker).take(detail));
  robot.view.addEventListener("boxed", ({detail: {from, to}}) => editor.crop(from, to));
  robot.view.addEventListener("moment", ({detail}) => {
    choose(index);
    player.setPlaying(false);
    player.goTo(detail);
  });
  robots.push(robot);
  robot.connection = new Connection(index, is_linked ? Number(wanted.get("piece")) || 0 : 0, model);
  Object.assign(robot.view.layers, robots[0].view.layers);
}

// What came of a pin. The first scan after it may have been on its way before.
function tellPinned(robot) {
  const {pinned, model: {robot: found}} = robot;
  if (!pinned || ++pinned.num_scans < 2) return;
  const is_found = hasPose(found.state);
  if (!is_found && pinned.num_scans < SCANS_OF_PIN) return;
  robot.pinned = null;
  const off_m = Math.hypot(found.x_m - pinned.x_m, found.y_m - pinned.y_m);
  toast(is_found ? `found at ${found.x_m.toFixed(1)}, ${found.y_m.toFixed(1)} m, ${formatDistance(off_m)} from the pin` :
        "not found there: no scan since then fits the map near the pin", NEWS_MS);
}

$("changes").addEventListener("click", ({target}) => {
  const {x_m, y_m} = target.closest("button")?.dataset ?? {};
  if (x_m === undefined) return;
  const {view} = robots[chosen];
  view.fits = false;
  view.setFollows(false);
  view.setScale(Math.max(view.camera.px, 60));
  view.centre(Number(x_m), Number(y_m));
});
$("pieces").addEventListener("click", ({target}) => {
  const piece = Number(target.closest("button")?.dataset.piece);
  if (!piece) return;
  robots[chosen].connection.showPiece(piece);
  view().fit();
});
const marker = new Marker(() => view(), (mark) => robots[chosen].connection.say(`mark ${JSON.stringify(mark)}`));

const editor = new Editor(() => view(), (text) => robots[chosen].connection.say(text), () => robots[chosen].connection.query());

// The first robot tells of the others.
function label({model, parent}) {
  while (robots.length < model.info.robots.length) addRobot(robots.length);
  document.body.classList.toggle("several", robots.length > 1);
  if (robots.length < 2) return;
  if (!parent.querySelector(".label")) {
    const shown = parent.appendChild(document.createElement("span"));
    shown.className = "label";
    shown.innerHTML = `<span class="name"><bdi></bdi></span><span class="badge"></span>`;
    if (robots.every((robot) => robot.parent.querySelector(".label"))) openSeveral();
  }
  parent.querySelector("bdi").textContent = model.info.robot;
}

// Several robots, once all are known, as a link has them.
function openSeveral() {
  const named = robots.findIndex(({is_linked}) => wanted.has("robot") && is_linked);
  const mode = [...$("mode").options].find(({value}) => value === wanted.get("mode"))?.value ?? default_mode;
  if (mode !== document.body.dataset.mode) setMode($("mode").value = mode);
  choose(named < 0 ? chosen : named);
  if (named >= 0) readLink(view());
}

// The page of a fleet comes first, alone: the maps of its robots have other frames.
function openFleet(robot, index) {
  if (robot.is_open_fleet || !isFleet(robot.model)) return;
  robot.is_open_fleet = true;
  $("linked").checked = false;
  default_mode = "alone";
  choose(index);
  openSeveral();
  if (!robot.view.is_linked) robot.view.fit();
}

// How each robot is: on its map, where there are several, and by how it is drawn.
function showHealth({model, parent}) {
  const {tone, text} = describeState(model, performance.now());
  const is_old = Boolean(model.robot) && (!hasPose(model.robot.state) || (tone === "bad" && model.info.live !== false));
  if (is_old !== model.is_old) model.changed = true;
  model.is_old = is_old;
  const badge = parent.querySelector(".badge");
  if (!badge || badge.textContent === text) return;
  badge.textContent = text;
  badge.dataset.tone = tone;
}

// A run that has ended is seen as a whole, unless somebody looks at a place of it already.
function openFinished(robot) {
  const {view, model} = robot;
  if (!model.timeline) return;
  if (view.follows && !view.is_linked) view.fit();
  model.goTo((robot.is_linked ? wanted_moment : null) ?? model.timeline.at);
  if (robot.is_linked) wanted_moment = null;
}

function choose(index) {
  if (index !== chosen && marker.is_open) marker.toggle(false);
  if (index !== chosen && editor.is_open) editor.toggle(false);
  chosen = index;
  robots.forEach(({parent}, i) => parent.classList.toggle("active", i === index));
  robots[index].changed.add("all");
  showTools();
}

const view = () => robots[chosen].view;

// News stay where a loop is closed meanwhile.
function toast(text, long_ms = TOAST_MS) {
  if (long_ms < NEWS_MS && performance.now() < toast.news_until_ms) return;
  if (long_ms === NEWS_MS) toast.news_until_ms = performance.now() + NEWS_MS;
  $("toast").textContent = text;
  $("toast").classList.add("shown");
  clearTimeout(toast.timer);
  toast.timer = setTimeout(() => $("toast").classList.remove("shown"), long_ms);
}

function showCursor({view}, {x_m, y_m}) {
  const distance_m = view.distance_m();
  $("cursor").textContent = `${x_m.toFixed(2)}, ${y_m.toFixed(2)} m` +
    (distance_m === null ? "" : `   ·   ${formatDistance(distance_m)}`);
}

function showScale({camera}) {
  const {metres, width_px} = scaleOf(camera.px);
  $("scale").firstElementChild.style.width = `${width_px}px`;
  $("scale").lastElementChild.textContent = `${metres} m`;
}

function showTools() {
  const {follows, fits, measures, places, layers, camera} = view();
  $("follow").setAttribute("aria-pressed", follows);
  $("fit").setAttribute("aria-pressed", fits);
  $("measure").setAttribute("aria-pressed", measures);
  $("then").setAttribute("aria-pressed", view().model.wants_then);
  $("place").setAttribute("aria-pressed", places);
  $("mark").setAttribute("aria-disabled", isFleet(view().model));
  if (marker.is_open && !view().marks) marker.toggle(false);
  if (editor.is_open && !view().marks) editor.toggle(false);
  $("turn").setAttribute("aria-pressed", camera.turn_rad !== 0);
  for (const box of document.querySelectorAll("[data-layer]")) box.checked = layers[box.dataset.layer];
}

function saveBlob(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

const describeView = () => `${$("state").textContent}  ${$("counts").textContent}`;

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  for (const {view, changed} of robots) {
    view.readTheme();
    changed.add("all");
  }
  if (robots.length > 1) robots[0].view.showOver(robots[0].view.mode, robots[0].view.others);
}

// Several maps side by side, or all over the first one.
function setMode(mode) {
  document.body.dataset.mode = mode;
  choose(mode === "alone" ? chosen : 0);
  for (const {view} of robots) view.readTheme();
  robots[0].view.showOver(mode === "alone" ? "beside" : mode, robots.slice(1).map(({model}) => model));
}

function setLayer(layer, shown) {
  for (const {view} of robots) {
    view.layers[layer] = shown;
    view.stale = true;
  }
}

const TOOLS = {
  follow: () => view().setFollows(!view().follows),
  fit: () => view().fit(),
  zoom_in: () => view().zoomMiddle(1.4),
  zoom_out: () => view().zoomMiddle(1 / 1.4),
  measure: () => view().setMeasures(!view().measures),
  place: () => { if (document.body.classList.contains("localising")) view().setPlaces(!view().places); },
  mark: () => {
    if (isFleet(view().model)) return toast(NO_MARKS, NEWS_MS);
    if (document.body.classList.contains("marking")) marker.toggle();
  },
  edit: () => { if (document.body.classList.contains("editing")) editor.toggle(); },
  layers: (event) => {
    const list = $("layer_list");
    list.hidden = !list.hidden;
    $("layers").setAttribute("aria-expanded", !list.hidden);
    if (!list.hidden && !(event.detail > 0)) list.querySelector("input").focus();
  },
  turn: () => view().toggleTurn(),
  then: () => {
    for (const {model} of robots) {
      model.wants_then = !model.wants_then;
      model.goTo(model.timeline?.at);
    }
  },
  screen: () => (document.fullscreenElement ? document.exitFullscreen() : document.documentElement.requestFullscreen()),
  save: (event) => {
    const [canvas, name] = event.shiftKey ? [view().model.map.toCanvas(), "map.png"] : [composePicture(view(), describeView()), "view.png"];
    canvas.toBlob((blob) => saveBlob(blob, name));
  },
  figure: () => saveBlob(composeFigure(view(), describeView(), performance.now()), "view.svg"),
  theme: () => {
    chosen_theme = document.documentElement.dataset.theme === "light" ? "dark" : "light";
    setTheme(chosen_theme);
    localStorage.setItem("theme", chosen_theme);
  },
  help: () => $("key").showModal(),
  fold: () => {
    $("fold").setAttribute("aria-expanded", !$("panel").classList.toggle("folded"));
    for (const {view} of robots) if (view.fits) view.fit();
  },
};
const KEYS = {h: "then", f: "follow", a: "fit", "+": "zoom_in", "=": "zoom_in", "-": "zoom_out", m: "measure", o: "place", k: "mark", e: "edit", l: "layers", w: "turn",
              x: "screen", s: "save", v: "figure", t: "theme", p: "fold", "?": "help"};
const ARROWS = {ArrowLeft: [60, 0], ArrowRight: [-60, 0], ArrowUp: [0, 60], ArrowDown: [0, -60]};

function use(tool, event) {
  TOOLS[tool](event);
  showTools();
}

for (const tool of Object.keys(TOOLS)) $(tool).addEventListener("click", (event) => use(tool, event));
$("screen").hidden = !document.fullscreenEnabled;  // an iPhone has none

// The legend says what each tool is, as a finger cannot hover; and a small screen has some only there.
for (const tool of $("tools").children) {
  if (tool.id === "help" || tool.hidden) continue;
  const entry = $("tool_list").appendChild(document.createElement("button"));
  entry.className = tool.className;
  entry.append(tool.firstElementChild.cloneNode(true), tool.title);
  entry.addEventListener("click", (event) => {
    $("key").close();
    use(tool.id, event);
  });
}
$("mode").addEventListener("change", () => setMode($("mode").value));
for (const box of document.querySelectorAll("[data-layer]")) {
  box.addEventListener("change", () => setLayer(box.dataset.layer, box.checked));
}
addEventListener("keydown", (event) => {
  if (event.key === "?" && $("key").open) return $("key").close();
  if (event.ctrlKey || event.metaKey || event.altKey || $("key").open) return;
  if (event.target.closest?.("#mark_form, #edit_form select") && event.key !== "Escape") return;  // it is typed
  const in_field = event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement;
  const key = event.key.toLowerCase();
  if (KEYS[key]) use(KEYS[key], event);
  if (view().marks) view().by_keys = view().stale = true;
  if (event.key === "Enter" && !event.target.closest?.("button, a, input, select, summary")) view().takeAim();
  if (key === "r") setLayer("rays", !view().layers.rays);
  if (key === "," || key === ".") player.step(key === "." ? 1 : -1);
  if (key === " " && !event.target.closest?.("button, a, summary, select, input:not([type=range])")) player.setPlaying(!player.playing);
  if (ARROWS[event.key] && !in_field) view().move(...ARROWS[event.key].map((px) => (event.shiftKey ? px / 10 : px)));
  if (event.key === "Escape") {
    view().setMeasures(false);
    view().setPlaces(false);
    view().setMarks(false);
    $("layer_list").hidden = true;
    $("layers").setAttribute("aria-expanded", false);
  }
  showTools();
});

// What was clicked does not keep the keys: space plays then. By the Tab key it still gets them.
addEventListener("click", ({detail, target}) => {
  if (detail > 0) target.closest("button, summary, input[type=checkbox], input[type=range]")?.blur();
});

// Beside the token, the address keeps what is looked at: who opens it again, or elsewhere, sees the same.
const wanted = new URLSearchParams(location.hash.slice(1));
let wanted_moment = wanted.has("scan") ? Number(wanted.get("scan")) : null;
let chosen_theme = [wanted.get("theme"), localStorage.getItem("theme")].find((theme) => theme === "light" || theme === "dark");

addEventListener("hashchange", () => location.reload());  // a link was pasted

function readLink(view) {
  const number = (key) => Number(wanted.get(key) ?? NaN);
  if (Number.isFinite(number("turn"))) view.camera.turn_rad = number("turn");
  if (number("px") > 0) view.setScale(number("px"));
  const has_place = [number("x"), number("y")].every(Number.isFinite);
  view.is_linked = has_place || ["all", "follow"].includes(wanted.get("view"));
  if (has_place) Object.assign(view.camera, {x_m: number("x"), y_m: number("y")});
  if (has_place) view.setFollows(false);
  else if (wanted.get("view") === "all") view.fit();
}

function readLayers({layers}) {
  if (!wanted.has("layers")) return;
  const shown = wanted.get("layers").split(" ");
  for (const layer of Object.keys(layers)) layers[layer] = shown.includes(layer);
}

function writeLink() {
  const {camera, follows, fits, layers} = view();
  const {timeline, info} = view().model;
  if (info.live === undefined) return;  // what the link says is not shown yet
  const link = new URLSearchParams();
  if (wanted.has("token")) link.set("token", wanted.get("token"));
  if (chosen > 0) link.set("robot", info.robots[chosen]);
  if (robots[chosen].connection.piece > 0) link.set("piece", robots[chosen].connection.piece);
  if (timeline && !timeline.is_at_end) link.set("scan", timeline.at);
  if (!view().model.wants_then) link.set("map", "last");
  if (!follows && !fits) {
    link.set("x", camera.x_m.toFixed(2));
    link.set("y", camera.y_m.toFixed(2));
  } else if (fits !== (info.live === false || isFleet(view().model))) {
    link.set("view", fits ? "all" : "follow");
  }
  if (!fits && (!follows || camera.px !== DEFAULT_PX)) link.set("px", camera.px.toPrecision(4));
  if (camera.turn_rad) link.set("turn", camera.turn_rad.toFixed(4));
  const shown = Object.keys(layers).filter((layer) => layers[layer]);
  if (shown.join() !== DEFAULT_LAYERS.join()) link.set("layers", shown.join(" "));
  if (document.body.dataset.mode && document.body.dataset.mode !== default_mode) link.set("mode", document.body.dataset.mode);
  if (chosen_theme) link.set("theme", chosen_theme);
  const hash = link.size > 0 ? `#${link}` : "";
  if (hash !== location.hash) history.replaceState(null, "", hash || location.pathname);
}

// Every map shows the place that the chosen one shows.
function linkCameras() {
  if (robots.length < 2 || !$("linked").checked) return;
  const {camera} = view();
  for (const {view: other} of robots) {
    if (other === view() || Object.keys(camera).every((key) => camera[key] === other.camera[key])) continue;
    Object.assign(other.camera, camera);
    other.setFollows(false);
    other.fits = false;
    other.stale = true;
  }
}

// Whatever a frame throws, the next one is drawn; the page says that something was not.
function frame(now_ms) {
  requestAnimationFrame(frame);
  const {model, changed} = robots[chosen];
  attempt(model, () => player.tick(now_ms));
  linkCameras();
  attempt(model, () => lookAtFleets(robots.map((robot) => robot.model), now_ms));
  for (const robot of robots) attempt(robot.model, () => robot.view.draw(now_ms));
  if (changed.size > 0) {
    const shown = new Set(changed);
    changed.clear();
    attempt(model, () => showPanel(model, shown, shown.has("all") || shown.has("connection")));
    attempt(model, () => marker.show(model.info.marks, model.info.live === true && !model.info.looks && !isFleet(model)));
    attempt(model, () => editor.show());
    attempt(model, () => showFleet(model, robots.map((robot) => robot.model), choose));
    if (["all", "timeline", "info"].some((type) => shown.has(type))) {
      attempt(model, () => player.take(model.timeline, model.info));
      for (const {view} of robots) if (view.fits) view.fit();  // around what is shown now
      attempt(model, () => showDownloads(robots[chosen]));
    }
    frame.state_at_ms = 0;
  }
  if (!(now_ms - frame.state_at_ms < STATE_MS)) {
    frame.state_at_ms = now_ms;
    if (model.trouble && now_ms - model.trouble_at_ms > TROUBLE_MS) model.trouble = "";
    for (const robot of robots) attempt(robot.model, () => showHealth(robot));
    attempt(model, () => showState(model, performance.now()));
    for (const robot of robots) attempt(robot.model, () => robot.view.describe());
  }
  if (!(now_ms - frame.link_at_ms < LINK_MS)) {
    frame.link_at_ms = now_ms;
    writeLink();
  }
  attempt(model, () => showScale(view()));
}

function attempt(model, show) {
  try {
    show();
  } catch (error) {
    model.trouble_at_ms = performance.now();
    if (model.trouble === error.message) return;
    console.error(error);
    model.trouble = error.message;
    model.tell("info");
  }
}

setTheme(chosen_theme ?? (matchMedia("(prefers-color-scheme: light)").matches ? "light" : "dark"));
addRobot(0);
readLayers(robots[0].view);
if (!wanted.has("robot")) readLink(robots[0].view);
choose(0);
if (matchMedia("(max-height: 520px)").matches) TOOLS.fold();  // a phone that lies: the map first
addEventListener("resize", () => robots[chosen].changed.add("all"));
requestAnimationFrame(frame);

export {robots, player};
