// Signs of the kinds of places, in a box of 24 x 24: on the map, and in the list.

const PATHS = {
  victim: "M12 3.5a2.6 2.6 0 1 1 0 5.2 2.6 2.6 0 0 1 0-5.2zM7 11h10M12 9v6M12 15l-3.5 5.5M12 15l3.5 5.5",
  hazard: "M12 4 21 19.5H3zM12 10v4.5M12 17v.2",
  door: "M6 20.5v-17h12v17zM14.5 12v.5",
  room: "M4 20V4h16v16zM10 20v-6h4v6",
  dock: "M13 3 6.5 13.5H11L10 21l7-11h-4.5z",
  "keep-out": "M12 4a8 8 0 1 1 0 16 8 8 0 0 1 0-16zM7.5 12h9",
  slow: "M5 17a8 8 0 1 1 14 0M12 15 8 9.5",
  place: "M12 21s6-6 6-11a6 6 0 1 0-12 0c0 5 6 11 6 11zM12 9.8v.4",
};

const pathOf = (kind) => PATHS[Object.hasOwn(PATHS, kind) ? kind : "place"];

// On a disc, upright whichever way the map is turned.
export function drawIcon(context, kind, {x_m, y_m}, pixel, fill, line, angle_rad) {
  context.save();
  context.translate(x_m, y_m);
  context.rotate(-angle_rad);
  context.scale(pixel, -pixel);
  context.fillStyle = fill;
  context.strokeStyle = line;
  context.beginPath();
  context.arc(0, 0, 11, 0, 2 * Math.PI);
  context.fill();
  context.lineWidth = 1.5;
  context.stroke();
  context.scale(0.66, 0.66);
  context.translate(-12, -12);
  Object.assign(context, {lineWidth: 2.4, lineCap: "round", lineJoin: "round"});
  context.stroke(Object.assign(new Path2D(pathOf(kind)), {d: pathOf(kind)}));
  context.restore();
}

export function makeIcon(kind) {
  const space = "http://www.w3.org/2000/svg";
  const icon = document.createElementNS(space, "svg");
  icon.setAttribute("viewBox", "0 0 24 24");
  icon.setAttribute("aria-hidden", "true");
  icon.setAttribute("class", "icon");
  icon.appendChild(document.createElementNS(space, "path")).setAttribute("d", pathOf(kind));
  return icon;
}
