// A picture of what is seen, for people who did not see the page: with title, scale and key.

const HEAD_PX = 64;
const FOOT_PX = 48;
const KEY = [["wall", "wall"], ["free", "free"], ["path", "path"], ["floating", "not joined"], ["loop", "loop"], ["bad", "lost"]];
const keyOf = ({fleet}) => (fleet ? [...KEY.slice(0, 2), ...fleet.map(({colour, name}) => [`fleet_${colour}`, name])] : KEY);

// A round length that is between 60 and 150 pixels long.
export function scaleOf(px) {
  const metres = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200].find((length) => length * px >= 60) ?? 500;
  return {metres, width_px: metres * px};
}

export function composePicture(view, title, text) {
  const {canvas, colours, ratio, camera} = view;
  const picture = document.createElement("canvas");
  picture.width = canvas.width;
  picture.height = canvas.height + (HEAD_PX + FOOT_PX) * ratio;
  const context = picture.getContext("2d");
  context.scale(ratio, ratio);
  const [width, height] = [canvas.width / ratio, canvas.height / ratio + HEAD_PX];
  context.fillStyle = colours.panel;
  context.fillRect(0, 0, width, height + FOOT_PX);
  context.drawImage(canvas, 0, HEAD_PX, width, height - HEAD_PX);
  context.fillStyle = colours.text;
  context.font = "600 18px system-ui, sans-serif";
  context.fillText(title || "map", 16, 28, width - 32);
  context.font = "14px system-ui, sans-serif";
  context.fillText(text, 16, 50, width - 32);
  const {metres, width_px} = scaleOf(camera.px);
  context.fillRect(16, height + 30, width_px, 4);
  context.fillText(`${metres} m`, 16, height + 22);
  let x = 16 + Math.max(width_px, 60) + 32;
  for (const [colour, word] of keyOf(view.model)) {
    context.fillStyle = colours[colour];
    context.fillRect(x, height + 16, 22, 14);
    context.strokeStyle = colours.text;
    context.strokeRect(x + 0.5, height + 16.5, 21, 13);
    context.fillStyle = colours.text;
    context.fillText(word, x + 30, height + 28);
    x += 30 + context.measureText(word).width + 20;
  }
  return picture;
}
