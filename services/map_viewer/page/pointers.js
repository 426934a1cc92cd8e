// What pointers do on a map: one drags, two pinch, and a short press taps.

const TAP_PX = 5;  // a pointer that moves less has not moved

const boxOf = (view, {x, y}, event) => ({from: view.toMap(x, y), to: view.toMap(event.clientX, event.clientY)});

export function listenToPointers(view) {
  const {canvas, pointers} = view;
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    view.zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), event.clientX, event.clientY);
  }, {passive: false});
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, {x: event.clientX, y: event.clientY, way_px: 0, began: {x: event.clientX, y: event.clientY}});
    view.by_keys = false;
    view.boxed = null;
    view.dispatchEvent(new Event("chosen"));
    if (view.places && pointers.size === 1) {
      view.placed = {...view.toMap(event.clientX, event.clientY), yaw_rad: view.model.robot?.yaw_rad ?? 0};
      view.stale = true;
    }
  });
  canvas.addEventListener("pointermove", (event) => movePointer(view, event));
  for (const type of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(type, (event) => {
      const pointer = pointers.get(event.pointerId);
      pointers.delete(event.pointerId);
      const is_meant = type === "pointerup";
      if (view.placed) view.place(is_meant);
      else if (view.boxed) view.takeBox(is_meant);
      else if (is_meant && pointer?.way_px < TAP_PX) view.tap(event);
    });
  }
}

function movePointer(view, event) {
  const place = view.toMap(event.clientX, event.clientY);
  view.dispatchEvent(new CustomEvent("pointed", {detail: place}));
  if (view.measures && view.measured.length === 2 && !view.measured.done) {
    view.measured[1] = place;
    view.stale = true;
  }
  const pointer = view.pointers.get(event.pointerId);
  if (!pointer) return;
  if (view.placed) return view.lookAt(place);
  const right = event.clientX - pointer.x;
  const down = event.clientY - pointer.y;
  const way_px = pointer.way_px + Math.hypot(right, down);
  const other = [...view.pointers.entries()].find(([id]) => id !== event.pointerId)?.[1];
  if (other) {
    const before = Math.hypot(pointer.x - other.x, pointer.y - other.y);
    const after = Math.hypot(event.clientX - other.x, event.clientY - other.y);
    if (before > 0) view.zoom(after / before, (event.clientX + other.x) / 2, (event.clientY + other.y) / 2);
    view.move(right / 2, down / 2);
  } else if (way_px >= TAP_PX && view.boxes && !pointer.pinched) {
    view.boxed = boxOf(view, pointer.began, event);
    view.stale = true;
  } else if (way_px >= TAP_PX) {
    view.move(right, down);
  }
  Object.assign(pointer, {x: event.clientX, y: event.clientY, way_px, pinched: pointer.pinched || Boolean(other)});
  if (other) other.pinched = true;
}
