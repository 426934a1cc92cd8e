"""Places with names on the page: added by a click and by a touch, listed, undone, removed; and seen when the run has ended."""

import contextlib
import pathlib
import socket
import subprocess
import tempfile

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

from harness import BIN, PATIENCE_S, Browser, Stack, await_that, check

# Taps the map at places of it [m]. Callback: whether the tool was on.
TAP = """
const [places, kind, name, is_outline, callback] = arguments;
import('/main.js').then(({robots}) => {
  const {view} = robots[0];
  view.canvas.setPointerCapture = () => {};
  view.setFollows(false);
  view.fits = false;
  Object.assign(view.camera, {x_m: 0, y_m: 0, px: 40});
  if (document.getElementById('mark_form').hidden) document.getElementById('mark').click();
  document.getElementById('mark_kind').value = kind;
  document.getElementById('mark_name').value = name;
  if (document.getElementById('mark_outline').checked !== is_outline) document.getElementById('mark_outline').click();
  const box = view.canvas.getBoundingClientRect();
  const was_on = view.marks;
  for (const [x_m, y_m] of places) {
    const place = {clientX: box.left + box.width / 2 + 40 * x_m, clientY: box.top + box.height / 2 - 40 * y_m,
                   pointerId: 5, pointerType: is_outline ? 'mouse' : 'touch'};
    for (const type of ['pointerdown', 'pointerup']) view.canvas.dispatchEvent(new PointerEvent(type, place));
  }
  callback(was_on);
});
"""

MARKS = """
const callback = arguments[0];
import('/main.js').then(({robots}) => {
  const {view, model} = robots[0];
  const [x_m, y_m] = model.info.marks[0]?.points[0] ?? [0, 0];
  const wanted = view.cameraFor(x_m, y_m);
  callback({marks: model.info.marks, off_m: Math.hypot(view.camera.x_m - wanted.x_m, view.camera.y_m - wanted.y_m),
            rows: [...document.querySelectorAll('#places li .jump')].map((row) => row.textContent),
            removes: document.querySelectorAll('#places .remove').length,
            is_offered: getComputedStyle(document.getElementById('mark')).display !== 'none'});
});
"""

# Callback: at what a key points.
AIM = """
const callback = arguments[0];
import('/main.js').then(({robots}) => {
  const {x_m, y_m} = robots[0].view.aim();
  callback([x_m, y_m]);
});
"""

# How many pixels of the canvas changed with the layer of places on and off.
DRAWN_MARKS = """
const callback = arguments[0];
import('/main.js').then(({robots}) => {
  const {view} = robots[0];
  Object.assign(view.camera, {x_m: 0, y_m: 0, px: 40});
  const [on, off] = [true, false].map((shown) => {
    view.layers.marks = shown;
    view.stale = true;
    view.draw(performance.now());
    return view.canvas.getContext('2d').getImageData(0, 0, view.canvas.width, view.canvas.height).data;
  });
  view.layers.marks = true;
  let num = 0;
  for (let i = 0; i < on.length; i += 4) num += on[i] !== off[i] || on[i + 1] !== off[i + 1] || on[i + 2] !== off[i + 2];
  callback(num);
});
"""


def tap(browser, places, kind, name="", is_outline=False):
    return browser.driver.execute_async_script(TAP, places, kind, name, is_outline)


def is_there(http):
    address, port = http.split(":")
    with contextlib.suppress(OSError), socket.create_connection((address, int(port)), 1):
        return True
    return False


def test_marks():
    with tempfile.TemporaryDirectory(prefix="crsm_view_") as folder:
        out = pathlib.Path(folder)
        stack = Stack(out)
        browser = finished = None
        try:
            stack.start_all()
            browser = Browser(f"http://{stack.http}/")
            stack.start("laser_publisher", "sim:demo", "--rate", "10")
            await_that(lambda: browser.state()["state"] == "OK", "a map is made")
            click = lambda what: browser.driver.execute_script("document.getElementById(arguments[0]).click()", what)
            names = lambda: browser.run(MARKS)["rows"]
            check(tap(browser, [[0.5, 0.25]], "victim", "in the <b>hall</b>"), "the tool is on")
            await_that(lambda: names() == ["victim in the <b>hall</b>"], "a touch adds a place, which is listed by its name")
            seen = browser.run(MARKS)["marks"][0]
            check(abs(seen["points"][0][0] - 0.5) < 0.02 and abs(seen["points"][0][1] - 0.25) < 0.02, f"it lies there: {seen}")
            tap(browser, [[0.0, -1.0], [1.0, -1.0], [1.0, 0.0], [3.0, 3.0]], "keep-out", "stairs", True)
            click("mark_undo")
            click("mark_done")
            await_that(lambda: len(names()) == 2, "clicks make an outline")
            check(len(browser.run(MARKS)["marks"][1]["points"]) == 3, "without the corner that was undone")
            check(browser.run(DRAWN_MARKS) > 500, "places are drawn")
            browser.picture("marks")
            tap(browser, [[-1.0, -1.0]], "Fire Door!")
            await_that(lambda: names()[2:] == ["fire-door-"], "a kind of one's own is written as kinds are")
            click("mark_undo")
            await_that(lambda: len(names()) == 2, "undo takes it back")
            browser.driver.execute_script("document.querySelector('#places .remove').click()")
            await_that(lambda: names() == ["keep-out stairs"], "a place is removed")
            click("mark_undo")
            await_that(lambda: len(names()) == 2, "and undo brings it back")
            press = lambda *keys: ActionChains(browser.driver).send_keys(*keys).perform()
            browser.driver.execute_script("document.getElementById('mark_kind').value = 'dock'; document.activeElement.blur()")
            press(Keys.ARROW_RIGHT)
            press(Keys.ENTER)
            await_that(lambda: names()[2:] == ["dock"], "Enter adds a place at the middle of the view")
            aim, there = browser.run(AIM), browser.run(MARKS)["marks"][2]["points"][0]
            check(abs(aim[0] - there[0]) < 0.02 and abs(aim[1] - there[1]) < 0.02, f"where the cross is: {aim}, {there}")
            check(browser.driver.execute_script("return document.querySelectorAll('#places .icon path').length") == 3,
                  "kinds have signs in the list")
            browser.picture("marks_signs")
            click("mark_undo")
            await_that(lambda: len(names()) == 2, "and undo takes it back")
            stack.kill("map_updater")
            tap(browser, [[1.5, 0.0]], "door")
            stack.start_updater("--resume")
            await_that(lambda: "door" in names(), "one that was said while the owner of the map was away is there, too")
            browser.driver.execute_script("document.querySelector('#places .jump').click()")
            here = browser.run(MARKS)
            check(here["off_m"] < 0.01 and here["removes"] == 3, "the list leads to a place")
            check(browser.errors() == [], "the console has no errors")
            stack.end()
            stack.processes.clear()
            subprocess.run([BIN / "slam_eval", "export", out], check=True, stdout=subprocess.DEVNULL, timeout=PATIENCE_S)
            check((out / "map.tif").stat().st_size > 1000, "the run has a GeoTIFF of them")
            finished = subprocess.Popen([BIN / "map_viewer", out, "--http", stack.http], stderr=subprocess.DEVNULL)
            browser.driver.get("about:blank")
            await_that(lambda: is_there(stack.http), "map_viewer shows the run")
            browser.driver.get(f"http://{stack.http}/")
            await_that(lambda: len(names()) == 3, "a run that has ended shows its places")
            ended = browser.run(MARKS)
            check(ended["removes"] == 0 and not ended["is_offered"], "which nobody changes any more")
        finally:
            if browser:
                browser.driver.quit()
            stack.end()
            if finished:
                finished.terminate()
                finished.wait(PATIENCE_S)
