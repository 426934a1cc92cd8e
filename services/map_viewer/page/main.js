// The page: a map for each robot, the panel of the one that is chosen, and the tools.

import {MapView} from "./map_view.js";
import {showPanel} from "./panel.js";
import {RobotModel} from "./robot_model.js";
import {Connection} from "./wire.js";

const $ = (id) => document.getElementById(id);
const TOAST_MS = 3000;
const NEWS_MS = 8000;
const robots = [];  // {model, view, changed}
let chosen = 0;

function addRobot(index) {
  const parent = $("maps").appendChild(document.createElement("div"));
  parent.className = "map";
  const model = new RobotModel();
  const robot = {model, view: new MapView(parent, model), changed: new Set(), parent};
  for (const type of ["connection", "map", "robot", "path", "samples", "info"]) {
    model.addEventListener(type, () => robot.changed.add(type));
  }
  model.addEventListener("corrected", () => toast("loop closed: the map was corrected"));
  model.addEventListener("news", ({detail}) => toast(detail, NEWS_MS));
  model.addEventListener("info", () => label(robot));
  robot.view.addEventListener("chosen", () => choose(index));
  robot.view.addEventListener("follows", () => showTools());
  robot.view.addEventListener("pointed", ({detail}) => showCursor(robot, detail));
  robots.push(robot);
  new Connection(index, model);
}

// The first robot tells of the others.
function label({model, parent}) {
  while (robots.length < model.info.robots.length) addRobot(robots.length);
  if (robots.length < 2 || parent.querySelector(".label")) return;
  const name = parent.appendChild(document.createElement("span"));
  name.className = "label";
  name.textContent = model.info.robot;
  choose(chosen);
}

function choose(index) {
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
    (distance_m === null ? "" : `   ·   ${distance_m.toFixed(distance_m < 10 ? 3 : 2)} m`);
}

function showScale({camera}) {
  const metres = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200].find((length) => length * camera.px >= 60) ?? 500;
  $("scale").firstElementChild.style.width = `${metres * camera.px}px`;
  $("scale").lastElementChild.textContent = `${metres} m`;
}

function showTools() {
  const {follows, measures, shows_rays} = view();
  $("follow").setAttribute("aria-pressed", follows);
  $("measure").setAttribute("aria-pressed", measures);
  $("rays").setAttribute("aria-pressed", shows_rays);
}

function saveCanvas(canvas, name) {
  canvas.toBlob((blob) => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = `${name}.png`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  });
}

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  for (const {view, changed} of robots) {
    view.readTheme();
    changed.add("all");
  }
}

const TOOLS = {
  follow: () => view().setFollows(!view().follows),
  fit: () => view().fit(),
  zoom_in: () => view().zoomMiddle(1.4),
  zoom_out: () => view().zoomMiddle(1 / 1.4),
  measure: () => view().setMeasures(!view().measures),
  rays: () => {
    view().shows_rays = !view().shows_rays;
    view().stale = true;
  },
  save: (event) => {
    event.shiftKey ? saveCanvas(view().model.map.toCanvas(), "map") : saveCanvas(view().canvas, "view");
  },
  theme: () => {
    setTheme(document.documentElement.dataset.theme === "light" ? "dark" : "light");
    localStorage.setItem("theme", document.documentElement.dataset.theme);
  },
  help: () => $("key").showModal(),
  fold: () => $("fold").setAttribute("aria-expanded", !$("panel").classList.toggle("folded")),
};
const KEYS = {f: "follow", a: "fit", "+": "zoom_in", "=": "zoom_in", "-": "zoom_out", m: "measure", r: "rays",
              s: "save", t: "theme", p: "fold", "?": "help"};
const ARROWS = {ArrowLeft: [60, 0], ArrowRight: [-60, 0], ArrowUp: [0, 60], ArrowDown: [0, -60]};

function use(tool, event) {
  TOOLS[tool](event);
  showTools();
}

for (const tool of Object.keys(TOOLS)) $(tool).addEventListener("click", (event) => use(tool, event));
addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || $("key").open) return;
  const tool = KEYS[event.key.toLowerCase()];
  if (tool) use(tool, event);
  if (ARROWS[event.key]) view().move(...ARROWS[event.key]);
  if (event.key === "Escape") view().setMeasures(false);
});

// Whatever a frame throws, the next one is drawn; the page says that something was not.
function frame(now_ms) {
  requestAnimationFrame(frame);
  for (const robot of robots) attempt(robot.model, () => robot.view.draw(now_ms));
  const {model, changed} = robots[chosen];
  if (changed.size > 0) {
    const shown = new Set(changed);
    changed.clear();
    attempt(model, () => showPanel(model, shown, shown.has("all") || shown.has("connection")));
  }
  attempt(model, () => showScale(view()));
}

function attempt(model, show) {
  try {
    show();
  } catch (error) {
    if (model.trouble === error.message) return;
    console.error(error);
    model.trouble = error.message;
    model.tell("info");
  }
}

setTheme(localStorage.getItem("theme") ?? (matchMedia("(prefers-color-scheme: light)").matches ? "light" : "dark"));
addRobot(0);
choose(0);
addEventListener("resize", () => robots[chosen].changed.add("all"));
requestAnimationFrame(frame);

export {robots};
