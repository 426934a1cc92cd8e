// What is drawn on as on a canvas, and becomes an SVG: as much of that as this page uses. A path is drawn with the
// transform that it began with.

const SPACE = "http://www.w3.org/2000/svg";
const STYLE = {globalAlpha: 1, fillStyle: "#000", strokeStyle: "#000", lineWidth: 1, lineJoin: "miter", lineCap: "butt",
               font: "10px sans-serif", textAlign: "start", imageSmoothingEnabled: true, dashes: []};
const ANCHORS = {start: "start", center: "middle"};
const ruler = document.createElement("canvas").getContext("2d");
const short = (number) => Number(number.toFixed(4));

export class SvgContext {
  constructor(width, height) {
    Object.assign(this, STYLE, {is_figure: true, matrix: new DOMMatrix(), saved: [], d: "", canvas: {width, height}});
    this.document = document.implementation.createDocument(SPACE, "svg");  // of which no browser shows or loads anything
    this.root = this.into = this.document.documentElement;
    this.set(this.root, {width, height, viewBox: `0 0 ${width} ${height}`});
  }

  set(element, attributes) {
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    return element;
  }

  add(name, attributes) {
    const element = this.set(this.into.appendChild(this.document.createElementNS(SPACE, name)), attributes);
    const {a, b, c, d, e, f} = this.matrix;
    if (!this.matrix.isIdentity) element.setAttribute("transform", `matrix(${[a, b, c, d, e, f].map((v) => Number(v.toPrecision(8))).join(" ")})`);
    if (this.globalAlpha !== 1) element.setAttribute("opacity", this.globalAlpha);
    return element;
  }

  // All until `leave` is drawn in this part, which has units of its own.
  enter(x, y, width, height, canvas) {
    this.into = this.add("svg", {x, y, width, height, viewBox: `0 0 ${canvas.width} ${canvas.height}`});
    this.canvas = canvas;
  }
  leave() {
    this.into = this.root;
    this.setTransform(1, 0, 0, 1, 0, 0);
  }

  save() { this.saved.push({...Object.fromEntries(Object.keys(STYLE).map((name) => [name, this[name]])), matrix: DOMMatrix.fromMatrix(this.matrix)}); }
  restore() { Object.assign(this, this.saved.pop()); }
  getTransform() { return DOMMatrix.fromMatrix(this.matrix); }
  setTransform(...numbers) { this.matrix = new DOMMatrix(numbers); }
  translate(x, y) { this.matrix.translateSelf(x, y); }
  scale(x, y) { this.matrix.scaleSelf(x, y); }
  rotate(angle_rad) { this.matrix.rotateSelf((angle_rad * 180) / Math.PI); }
  setLineDash(dashes) { this.dashes = dashes; }

  beginPath() { this.d = ""; }
  moveTo(x, y) { this.d += `M${short(x)} ${short(y)}`; }
  lineTo(x, y) { this.d += `${this.d ? "L" : "M"}${short(x)} ${short(y)}`; }
  closePath() { this.d += "Z"; }
  arc(x, y, radius) { this.ellipse(x, y, radius, radius, 0); }  // a whole one
  ellipse(x, y, rx, ry, angle_rad) {
    const [dx, dy] = [rx * Math.cos(angle_rad), rx * Math.sin(angle_rad)];
    const half = `A${short(rx)} ${short(ry)} ${short((angle_rad * 180) / Math.PI)} 0 1`;
    this.d += `M${short(x - dx)} ${short(y - dy)}${half} ${short(x + dx)} ${short(y + dy)}${half} ${short(x - dx)} ${short(y - dy)}`;
  }

  // path: a Path2D whose `d` is known; else what was begun.
  stroke(path = this) {
    if (!path.d) return;
    this.add("path", {d: path.d, fill: "none", stroke: this.strokeStyle, "stroke-width": this.lineWidth, "stroke-linejoin": this.lineJoin,
                      "stroke-linecap": this.lineCap, ...(this.dashes.length && {"stroke-dasharray": this.dashes.map(short).join(" ")})});
  }
  fill() { if (this.d) this.add("path", {d: this.d, fill: this.fillStyle}); }
  fillRect(x, y, width, height) { this.add("rect", {x, y, width, height, fill: this.fillStyle}); }
  strokeRect(x, y, width, height) {
    this.add("rect", {x, y, width, height, fill: "none", stroke: this.strokeStyle, "stroke-width": this.lineWidth});
  }

  measureText(text) { return Object.assign(ruler, {font: this.font}).measureText(text); }
  fillText(text, x, y, most = Infinity) {
    const narrowed = this.measureText(text).width > most ? {textLength: most, lengthAdjust: "spacingAndGlyphs"} : {};
    const [, weight, size, family] = /^(?:(\d+) )?(\d+)px (.*)$/.exec(this.font);
    this.add("text", {x, y, fill: this.fillStyle, "font-weight": weight ?? 400, "font-size": size, "font-family": family,
                      "text-anchor": ANCHORS[this.textAlign], ...narrowed}).textContent = text;
  }

  drawImage(canvas, x, y, width = canvas.width, height = canvas.height) {
    this.add("image", {x, y, width, height, href: canvas.toDataURL(), preserveAspectRatio: "none",
                       ...(!this.imageSmoothingEnabled && {"image-rendering": "pixelated"})});
  }

  toBlob() { return new Blob([new XMLSerializer().serializeToString(this.root)], {type: "image/svg+xml"}); }
}
