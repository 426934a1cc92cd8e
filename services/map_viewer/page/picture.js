// A picture of what is seen, for people who did not see the page: with title, origin, scale and legend.

import {SvgContext} from "./svg.js";

const HEAD_PX = 82;
const FOOT_PX = 48;

// Of what is drawn there.
function keyOf({model, layers}) {
  const {fleet, info, then, robot} = model;
  const facts = then ? model.factsThen() : info;
  if (fleet) return [["wall", "wall"], ["free", "free"], ...fleet.map(({colour, name}) => [`fleet_${colour}`, name])];
  return [["wall", "wall"], ["free", "free"], layers.path && ["path", "path"],
          layers.floating && facts.floating > 0 && ["floating", "not joined"], layers.loops && facts.loops.length > 0 && ["loop", "loop"],
          layers.path && facts.lost > 0 && ["bad", "lost"], layers.rays && robot?.rays.length > 0 && ["ray_wall", "ray that ends at a wall"],
          robot && ["robot", "robot"], layers.doubts && !then && info.verdict?.off_at_m && ["warn", "where the map may be off"]].filter(Boolean);
}

// A run by its folder, and not by where that lies.
const nameOf = ({robot, shown_piece}) => {
  const names = robot.replace(/\/pieces\/\d+$/, "").split("/").filter((name) => name && name !== ".");
  return `${names.at(-1) ?? "map"}${shown_piece > 1 ? `, piece ${shown_piece}` : ""}`;
};

// In the words of overview.png.
function describeOrigin({made_from, recorded, version}) {
  if (!made_from) return "";
  return `made from ${made_from}${recorded ? `, recorded on ${recorded.slice(0, 10)}` : ""}${version ? `, by version ${version}` : ""}`;
}

// A round length that is between 60 and 150 pixels long.
export function scaleOf(px) {
  const metres = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200].find((length) => length * px >= 60) ?? 500;
  return {metres, width_px: metres * px};
}

const sizeOf = ({canvas, ratio}) => ({width: canvas.width / ratio, height: canvas.height / ratio + HEAD_PX + FOOT_PX});

// text: how the robot is, in a line. drawMap: draws what is seen into the part between head and foot.
function compose(context, view, text, drawMap) {
  const {colours, camera, model: {info}} = view;
  const {width, height} = sizeOf(view);
  context.fillStyle = colours.panel;
  context.fillRect(0, 0, width, height);
  drawMap(0, HEAD_PX, width, height - HEAD_PX - FOOT_PX);
  context.fillStyle = colours.text;
  context.font = "600 18px system-ui, sans-serif";
  context.fillText(nameOf(info), 16, 28, width - 32);
  context.font = "14px system-ui, sans-serif";
  context.fillText(text, 16, 50, width - 32);
  context.fillText(describeOrigin(info), 16, 70, width - 32);
  const {metres, width_px} = scaleOf(camera.px);
  const top = height - FOOT_PX;
  context.fillRect(16, top + 30, width_px, 4);
  context.fillText(`${metres} m`, 16, top + 22);
  context.lineWidth = 1;
  let x = 16 + Math.max(width_px, 60) + 32;
  for (const [colour, word] of keyOf(view)) {
    context.fillStyle = colours[colour];
    context.fillRect(x, top + 16, 22, 14);
    context.strokeStyle = colours.text;
    context.strokeRect(x + 0.5, top + 16.5, 21, 13);
    context.fillStyle = colours.text;
    context.fillText(word, x + 30, top + 28);
    x += 30 + context.measureText(word).width + 20;
  }
}

export function composePicture(view, text) {
  const picture = document.createElement("canvas");
  const {width, height} = sizeOf(view);
  Object.assign(picture, {width: width * view.ratio, height: height * view.ratio});
  const context = picture.getContext("2d");
  context.scale(view.ratio, view.ratio);
  compose(context, view, text, (...part) => context.drawImage(view.canvas, ...part));
  return picture;
}

// The same as an SVG: lines and words are such, and a cell of the map is a pixel.
export function composeFigure(view, text, now_ms) {
  const {width, height} = sizeOf(view);
  const context = new SvgContext(width, height);
  compose(context, view, text, (...part) => {
    if (view.mode !== "beside") return context.drawImage(view.canvas, ...part);  // colours of two maps are mixed there
    context.enter(...part, view.canvas);
    view.drawOn(context, Infinity, now_ms);
    context.leave();
  });
  return context.toBlob();
}
