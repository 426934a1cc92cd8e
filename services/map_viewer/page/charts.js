// Running curves.

const BAD_STATES = {LOST: "--bad", "NO RAYS": "--bad", DEGENERATE: "--warn"};

function begin(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const {width, height} = canvas.getBoundingClientRect();
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const context = canvas.getContext("2d");
  context.scale(ratio, ratio);
  const style = getComputedStyle(document.documentElement);
  return {context, width, height, colour: (name) => style.getPropertyValue(name)};
}

function drawLevels({context, width, height, colour}, levels, toY) {
  context.strokeStyle = colour("--edge");
  context.fillStyle = colour("--dim");
  context.font = "10px system-ui, sans-serif";
  for (const [value, label] of levels) {
    const y = Math.round(toY(value)) + 0.5;
    context.beginPath();
    context.moveTo(0, y);
    context.lineTo(width, y);
    context.stroke();
    context.fillText(label, 2, y < height / 2 ? y + 11 : y - 3);
  }
}

function drawCurve({context, width}, values, toY, colour, fill_to_y = null) {
  if (values.length < 2) return;
  const step = width / (values.length - 1);
  context.beginPath();
  values.forEach((value, i) => context.lineTo(i * step, toY(value)));
  context.strokeStyle = colour;
  context.lineWidth = 1.5;
  context.lineJoin = "round";
  context.stroke();
  if (fill_to_y === null) return;
  context.lineTo(width, fill_to_y);
  context.lineTo(0, fill_to_y);
  context.globalAlpha = 0.14;
  context.fillStyle = colour;
  context.fill();
  context.globalAlpha = 1;
}

// The fitness of the last scans, 0 to 1; behind it a bar where a scan was lost or left an axis open.
export function drawFitness(canvas, samples) {
  const chart = begin(canvas);
  const {context, width, height, colour} = chart;
  const toY = (fitness) => 2 + (1 - fitness) * (height - 4);
  const shown = samples.slice(-Math.max(2, Math.round(width)));
  const step = width / Math.max(1, shown.length - 1);
  context.globalAlpha = 0.3;
  shown.forEach(({state}, i) => {
    if (!BAD_STATES[state]) return;
    context.fillStyle = colour(BAD_STATES[state]);
    context.fillRect((i - 0.5) * step, 0, Math.max(1, step), height);
  });
  context.globalAlpha = 1;
  drawLevels(chart, [[1, "1"], [0.5, "0.5"], [0, "0"]], toY);
  drawCurve(chart, shown.map(({fitness}) => fitness), toY, colour("--ray-wall"), toY(0));
}

// Milliseconds of a scan in all stages, once a second: median and 99th percentile.
export function drawTimes(canvas, times_ms) {
  const chart = begin(canvas);
  const {height, colour} = chart;
  const highest = Math.max(0.1, ...times_ms.map(([, p99]) => p99).filter(Number.isFinite));
  const power = 10 ** Math.floor(Math.log10(highest));
  const top = [1, 2, 5, 10].map((factor) => factor * power).find((value) => value >= highest);
  const toY = (value) => 2 + (1 - value / top) * (height - 4);
  drawLevels(chart, [[top, `${+top.toPrecision(2)} ms`], [top / 2, ""], [0, "0"]], toY);
  drawCurve(chart, times_ms.map(([, p99]) => p99), toY, colour("--ray-new"));
  drawCurve(chart, times_ms.map(([median]) => median), toY, colour("--path"), toY(0));
}
