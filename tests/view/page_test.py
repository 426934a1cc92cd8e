#!/usr/bin/env python3
"""The page of map_viewer in a browser (headless Chromium), beside a stack that maps a simulated building.

usage: tests/view/page_test.py BIN_DIR [PICTURES_DIR]
Leaves pictures of the page in PICTURES_DIR. Exit code 77 where there is no Chromium, or no Selenium to drive it:
Debian's chromium, chromium-driver and python3-selenium (scripts/setup --view). With npm, Foxglove's own client and the
reader of MCAP files look at a run as well.
"""

import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import urllib.parse

SKIPPED = 77
HERE = pathlib.Path(__file__).parent
WHOLE_WITHIN_S = 1.0  # what a late page may take

try:
    from harness import BIN, PATIENCE_S, Browser, Stack, await_that, check, free_port
    from selenium.webdriver import ActionChains
except ImportError as error:
    print(f"skipped: {error}: scripts/setup --view")
    sys.exit(SKIPPED)

import changes
import edits
import fleet
import marks
import pieces
import states
import timeline

# The map alone, a pixel a cell: size and grey values from the upper left.
MAP_PIXELS = """
const callback = arguments[0];
import('/main.js').then(({robots}) => {
  const canvas = robots[0].model.map.toCanvas();
  const {data} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  callback({width: canvas.width, height: canvas.height,
            grey: Array.from({length: data.length / 4}, (_, i) => data[4 * i]).join(',')});
});
"""

# How bright walls and free cells are on the canvas that is seen, on average.
SEEN = """
const callback = arguments[0];
import('/main.js').then(({robots}) => {
  const {model, view} = robots[0];
  view.layers.rays = false;
  view.fit();
  view.camera.px = 40;
  view.draw(performance.now());
  const context = view.canvas.getContext('2d');
  const sums = {wall: [0, 0], free: [0, 0]};
  const cell = model.map.cell_size_m;
  for (const tile of model.map.tiles.values()) {
    tile.cells.forEach((byte, index) => {
      const kind = byte < 20 ? 'wall' : byte > 245 ? 'free' : null;
      const x_m = (tile.x * 64 + (index & 63) + 0.5) * cell, y_m = (tile.y * 64 + (index >> 6) + 0.5) * cell;
      const x = view.canvas.width / 2 + (x_m - view.camera.x_m) * 40 * view.ratio;
      const y = view.canvas.height / 2 - (y_m - view.camera.y_m) * 40 * view.ratio;
      if (!kind || index % 7 || x < 0 || y < 0 || x >= view.canvas.width || y >= view.canvas.height) return;
      const [red, green, blue] = context.getImageData(x, y, 1, 1).data;
      sums[kind][0] += (red + green + blue) / 3;
      sums[kind][1] += 1;
    });
  }
  callback({wall: sums.wall[0] / sums.wall[1], free: sums.free[0] / sums.free[1], num: sums.wall[1]});
});
"""

# Of the places of the path that are in view, how many there are, and how many have its colour: from nearby and from
# afar, without what is drawn over it.
PATH_SEEN = """
const callback = arguments[0];
import('/main.js').then(({robots}) => {
  const {model, view} = robots[0];
  const [robot, loops] = [model.robot, model.info.loops];
  model.robot = null;
  model.info.loops = [];
  const wanted = [1, 3, 5].map((at) => parseInt(view.colours.path.slice(at, at + 2), 16));
  const count = () => {
    view.stale = true;
    view.draw(performance.now());
    const context = view.canvas.getContext('2d');
    const seen = [0, 0];
    for (const {x_m, y_m, state} of model.path) {
      const x = view.canvas.width / 2 + (x_m - view.camera.x_m) * view.camera.px * view.ratio;
      const y = view.canvas.height / 2 - (y_m - view.camera.y_m) * view.camera.px * view.ratio;
      if (state === 'LOST' || x < 0 || y < 0 || x >= view.canvas.width || y >= view.canvas.height) continue;
      const {data} = context.getImageData(x, y, 1, 1);
      seen[0] += 1;
      seen[1] += wanted.every((value, i) => Math.abs(value - data[i]) < 80);
    }
    return seen;
  };
  view.fit();
  const afar = count();
  view.camera.px *= 8;
  const nearby = count();
  model.robot = robot;
  model.info.loops = loops;
  view.fit();
  callback({afar, nearby, num: model.path.length});
});
"""


# Tells the page what no viewer should: numbers that are none. A frame later: what it shows, and whether it still draws.
NO_NUMBERS = """
const callback = arguments[0];
import('/main.js').then(({robots}) => {
  const {model} = robots[0];
  const info = model.info;
  const service = {...info.services[0], name: 'strange', p50_ms: null, p99_ms: NaN, max_ms: 1, resident_mb: null,
                   silent_s: null, counters: {}};
  model.take({...info, kind: 'info', services: [service], scan_times_ms: [[null, null], [NaN, Infinity]]});
  model.take({kind: 'robot', utime: 0n, state: 'OK', x_m: NaN, y_m: 1, yaw_rad: 0, fitness: NaN, covariance: {},
              axis: {}, rays: [], critical: []});
  requestAnimationFrame(() => requestAnimationFrame(() => {
    const shown = document.querySelector('[data-name="strange"] .took').textContent;
    const x_m = model.robot.x_m;
    const {draw} = robots[0].view;
    robots[0].view.draw = () => { throw new Error('cannot be drawn'); };
    requestAnimationFrame(() => requestAnimationFrame(() => {
      const says = document.getElementById('state').textContent;
      robots[0].view.draw = draw;
      model.trouble = '';
      model.take({...info, kind: 'info'});
      requestAnimationFrame(() => requestAnimationFrame(() => callback({shown, x_m, says, draws: !model.changed})));
    }));
  }));
});
"""


# Tells the page of a robot that floats, and then that it was joined. What it says, and whether the path is dashed.
FLOATING = """
const callback = arguments[0];
import('/main.js').then(({robots}) => {
  const {model, view} = robots[0];
  const {robot, info} = model;
  const text = (id) => document.getElementById(id).textContent;
  const soon = (then) => requestAnimationFrame(() => requestAnimationFrame(then));
  const dashes = [];
  const context = view.canvas.getContext('2d');
  const {setLineDash} = context;
  context.setLineDash = (dash) => { dashes.push(dash.length); setLineDash.call(context, dash); };
  model.take({...robot, kind: 'robot', floating: true, trajectory: 3});
  model.take({...info, kind: 'info', services: [], scan_age_s: 0, match_age_s: 0});
  soon(() => {
    const floats = text('why');
    const number = model.num_news + 1;
    model.is_corrected = true;
    model.take({...info, kind: 'info', news: {number, text: 'joined: trajectory 3 with the map'}});
    model.take({...robot, kind: 'robot', floating: false, trajectory: 3});
    soon(() => {
      context.setLineDash = setLineDash;
      callback({floats, is_dashed: dashes.includes(2), after: text('why'), toast: text('toast')});
    });
  });
});
"""

# Tells the page of a loop that moves the path by 0.3 m; of a path that is only thinned; and of another map. What is
# said, and how many places were moved each time. Then that the map is drawn anew and no loop was closed; and that another
# piece is shown: what is said then, and by the badge.
MOVED = """
const callback = arguments[0];
import('/main.js').then(async ({robots}) => {
  const {model} = robots[0];
  const {socket} = robots[0].connection;
  const {onmessage} = socket;
  socket.onmessage = null;  // only the test tells it something
  const toast = () => document.getElementById('toast').textContent;
  const info = model.info;
  const drawAnew = (told) => {
    model.take({kind: 'map', anew: false, epoch: model.cursor.epoch + 1n, version: model.cursor.version, complete: true,
                cell_size_m: model.map.cell_size_m, tiles: []});
    model.cursor.epoch -= 1n;
    model.take({...info, kind: 'info', services: [], scan_age_s: 0, match_age_s: 0, ...told});
  };
  const kept = model.path.slice();
  const take = (points) => model.take({kind: 'path', generation: ++model.path_generation + 1, first: 0, points});
  model.moved = [];
  take(kept.map((point) => ({...point, y_m: point.y_m + 0.3})));
  drawAnew({loops_closed: info.loops_closed + 1});
  const seen = {places: kept.length, moved: model.moved.length, toast: toast()};
  take(model.path.filter((_, i) => i % 2 === 0));
  seen.thinned = model.moved.length;
  model.is_another_map = true;
  take(kept);
  seen.another = model.moved.length;
  take(kept.map((point) => ({...point, x_m: point.x_m + 0.1})));
  seen.again = model.moved.length;
  drawAnew({loops_closed: info.loops_closed});
  seen.no_loop = toast();
  const news = {number: model.num_news + 1, text: 'another piece is the larger one now'};
  drawAnew({another_piece: true, news});
  model.take({...model.robot, kind: 'robot', state: 'OK', floating: false});
  await drawn();
  const state = document.getElementById('state');
  Object.assign(seen, {switched: toast(), state: state.textContent, tone: state.dataset.tone});
  model.take({...info, kind: 'info'});
  take(kept);
  socket.onmessage = onmessage;
  callback(seen);
});
"""

# Draws all maps over the first one, and side by side again. Callback: the names that are drawn there, with the layer of
# other robots and without, and how many labels are seen, and what the badges say, once each of these is drawn.
OVER = """
const callback = arguments[0];
import('/main.js').then(async ({robots}) => {
  const {view} = robots[0];
  const mode = document.getElementById('mode');
  const badges = () => [...document.querySelectorAll('.badge')].map((badge) => badge.textContent);
  const box = document.querySelector('[data-layer=robots]');
  const context = view.canvas.getContext('2d');
  const {fillText} = context;
  const names = () => {
    const names = [];
    context.fillText = (text, ...rest) => { names.push(text); fillText.call(context, text, ...rest); };
    view.stale = true;
    view.draw(performance.now());
    context.fillText = fillText;
    return names;
  };
  const states = {};
  const show = async (value) => {
    mode.value = value;
    mode.dispatchEvent(new Event('change'));
    await drawn();
    states[value] = badges();
  };
  const beside = names();
  await show('overlay');
  document.getElementById('fit').click();
  const over = names();
  box.click();
  const labels = [...document.querySelectorAll('.label')].filter((label) => label.checkVisibility()).length;
  const without = names();
  box.click();
  await show('difference');
  const difference = names();
  await show('beside');
  callback({beside, over, without, difference, labels, states, shown: robots.length});
});
"""

# The maps alone, with only what differs: how bright the brightest pixel is, 0 to 255, from afar, from nearby and turned,
# and once a tile of the other map is all wall.
DIFFERENCE = """
const callback = arguments[0];
import('/main.js').then(({robots}) => {
  const {view} = robots[0];
  const {map} = robots[1].model;
  const {truth} = view.layers;
  const {width, height} = view.canvas;
  const mode = document.getElementById('mode');
  const show = (value) => {
    mode.value = value;
    mode.dispatchEvent(new Event('change'));
  };
  const context = view.canvas.getContext('2d');
  const brightest = (zoom, turn_rad) => {
    view.camera.turn_rad = turn_rad;
    view.fit();
    view.camera.px *= zoom;
    view.draw(performance.now());
    view.drawMaps(context, view.windowOf(), 1 / view.camera.px);
    const {data} = context.getImageData(0, 0, width, height);
    return data.reduce((most, value, i) => (i % 4 < 3 ? Math.max(most, value) : most), 0);
  };
  view.layers.truth = false;
  show('difference');
  const equal = [[0.4, 0], [1, 0], [3.7, 0], [20, 0], [1, 0.3], [3.7, 0.3]].map((at) => brightest(...at));
  const [key, tile] = map.tiles.entries().next().value;
  const cells = tile.cells.slice();
  tile.cells.fill(0);
  map.stale.add(key);
  const changed = brightest(1, 0);
  tile.cells.set(cells);
  map.stale.add(key);
  view.layers.truth = truth;
  show('beside');
  callback({equal, changed});
});
"""


def read_png(path):
    """Width, height and grey values of an 8-bit grey PNG."""
    import zlib  # no package for pictures is needed for one kind of them
    content = path.read_bytes()
    at, data, width, height = 8, b"", 0, 0
    while at < len(content):
        size, kind = int.from_bytes(content[at:at + 4], "big"), content[at + 4:at + 8]
        body = content[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height = int.from_bytes(body[:4], "big"), int.from_bytes(body[4:8], "big")
        data += body if kind == b"IDAT" else b""
        at += 12 + size
    lines, grey, above = zlib.decompress(data), bytearray(), bytearray(width)
    for row in range(height):
        kind, line = lines[row * (width + 1)], bytearray(lines[row * (width + 1) + 1:(row + 1) * (width + 1)])
        for i in range(width):
            left, up, corner = (line[i - 1] if i else 0), above[i], (above[i - 1] if i else 0)
            guess = left + up - corner
            nearest = min((left, up, corner), key=lambda value: abs(guess - value))
            line[i] = (line[i] + (0, left, up, (left + up) // 2, nearest)[kind]) & 255
        grey += line
        above = line
    return width, height, bytes(grey)


def compare_with_picture(browser, map_png):
    """The page's map is that of map.png. Where both are still being made they meet: a loop that the last scans closed
    reaches the page and the exporter at times of their own, and changes no version."""
    def is_same():
        seen = browser.run(MAP_PIXELS)
        width, height, grey = read_png(map_png)
        return (seen["width"], seen["height"]) == (width, height) and bytes(map(int, seen["grey"].split(","))) == grey
    await_that(is_same, "each of its pixels is that of map.png")


def test_growth(stack, browser):
    await_that(lambda: browser.state()["version"] > 100, "the map grows")
    first = browser.state()
    await_that(lambda: abs(browser.state()["x_m"] - first["x_m"]) + abs(browser.state()["y_m"] - first["y_m"]) > 1,
               "the robot moves")
    check(browser.state()["tiles"] > 0 and browser.state()["path"] > 10, "there are tiles and a path")
    await_that(lambda: browser.state()["services"] >= 6, "all services are told of")
    await_that(lambda: browser.state()["loops"] > 0, "a loop is closed")
    await_that(lambda: "the map was corrected" in browser.state()["toast"], "and the page says so")
    browser.picture("dark")


def test_kills(stack, browser):
    stack.kill("map_viewer")
    await_that(lambda: not browser.state()["connected"], "the page knows that the viewer was killed")
    stack.start_viewer()
    version = browser.state()["version"]
    await_that(lambda: browser.state()["version"] > version + 20, "the page goes on with the viewer that came back")
    stack.kill("map_updater")
    stack.start_updater("--resume")
    version = browser.state()["version"]
    await_that(lambda: browser.state()["version"] > version + 20, "it goes on after the owner of the map was killed")


def test_whole_soon(url):
    late = Browser("about:blank")
    try:
        took_s = []
        while len(took_s) < 5 and min(took_s, default=PATIENCE_S) > WHOLE_WITHIN_S:  # the machine has other work, too
            began = time.monotonic()
            late.driver.get(url)
            while late.state()["version"] == 0 and time.monotonic() - began < PATIENCE_S:
                pass
            took_s.append(time.monotonic() - began)
        check(min(took_s) < WHOLE_WITHIN_S, f"a page that comes late, or again, is whole in {min(took_s):.2f} s")
    finally:
        late.driver.quit()


def test_tools(browser):
    body = browser.driver.find_element("tag name", "body")
    seen = browser.run(SEEN)
    check(seen["num"] > 100 and seen["wall"] > seen["free"] + 100, "walls are bright on the dark canvas")
    body.send_keys("t")
    time.sleep(0.2)
    seen = browser.run(SEEN)
    check(seen["wall"] < seen["free"] - 100, "and dark on the light one")
    body.send_keys("a")
    time.sleep(0.3)
    browser.picture("light")
    body.send_keys("?")
    check(browser.driver.find_element("id", "key").is_displayed(), "the key opens")
    browser.picture("key")
    browser.driver.switch_to.active_element.send_keys("?")
    check(not browser.driver.find_element("id", "key").is_displayed(), "and closes by the same key")
    body.send_keys("m")
    measure = browser.driver.find_element("id", "measure")
    check(measure.get_attribute("aria-pressed") == "true", "distances are measured")
    canvas = browser.driver.find_element("css selector", ".map canvas")
    actions = ActionChains(browser.driver)
    for offset in (-100, 100):
        actions.move_to_element_with_offset(canvas, offset, 0).click()
    actions.move_by_offset(1, 0).perform()
    cursor = browser.driver.find_element("id", "cursor").text
    check(cursor.count(" m") == 2, f"and shown: {cursor}")
    body.send_keys("t")


def test_draws_whatever_comes(browser):
    seen = browser.run(NO_NUMBERS)
    check(seen["shown"] == "– ms", "a time that is no number is shown as a dash")
    check(isinstance(seen["x_m"], (int, float)), "a robot that is nowhere is not taken")
    check(seen["says"] == "page error: cannot be drawn", "a frame that cannot be drawn is said")
    check(seen["draws"], "and the next ones are drawn")
    errors = browser.errors()
    check(len(errors) == 1 and "cannot be drawn" in errors[0], "the console has it once")


def test_floating(browser):
    seen = browser.run(FLOATING)
    check(seen["floats"] == "floating: not joined to the map yet (trajectory 3)", "what floats is said")
    check(seen["is_dashed"], "and dashed")
    check("floating" not in seen["after"] and seen["toast"] == "joined: trajectory 3 with the map", "and so is a join, for a while")


def test_moved(browser):
    seen = browser.run(MOVED)
    check(seen["moved"] > 0.9 * seen["places"] > 10 and "by up to 0.30 m" in seen["toast"], f"what a loop moves is said: {seen['toast']}")
    check(seen["thinned"] == seen["moved"] and seen["another"] == 0 and seen["again"] > 0,
          f"and neither a path that is thinned nor one on another map is moved: {seen}")
    check(seen["toast"].startswith("loop closed") and seen["no_loop"] == "the map was corrected by up to 0.10 m",
          "a loop is only said where one was closed")
    check((seen["switched"], seen["state"], seen["tone"]) == ("another piece is the larger one now", "ANOTHER PIECE", "warn"),
          "that another piece is shown is said, and is not OK")


def test_phone(url):
    phone = Browser(url, "412,915")
    try:
        await_that(lambda: phone.state()["version"] > 0, "a phone shows the map")
        overflow = phone.driver.execute_script("return document.documentElement.scrollWidth - innerWidth")
        check(overflow <= 0, "nothing is wider than its screen")
        phone.driver.find_element("id", "fit").click()
        time.sleep(0.5)
        phone.picture("phone")
        check(phone.errors() == [], "its console has no errors")
    finally:
        phone.driver.quit()


def test_asks_nobody_else(stack, browser):
    check(browser.errors() == [], "the console has no errors")
    ours = (f"http://{stack.http}/", f"ws://{stack.http}/", f"blob:http://{stack.http}/")
    foreign = {address for address in browser.asked_for() if not address.startswith(ours)}
    check(foreign == set(), f"nothing is asked for elsewhere: {foreign or 'nothing'}")


def test_live(stack):
    stack.start_all()
    url = f"http://{stack.http}/"
    stack.start("laser_publisher", "sim:block", "--rate", "6")
    browser = Browser(url)
    try:
        browser.driver.execute_script("localStorage.setItem('theme', 'dark')")
        browser.driver.get(url)
        test_growth(stack, browser)
        test_kills(stack, browser)
        check(stack.processes.pop("laser_publisher").wait(10 * PATIENCE_S) == 0, "all scans are mapped")

        def is_written():
            summary = json.loads((stack.out / "summary.json").read_text())
            return summary["scans"] == summary["map_version"] == browser.state()["version"]
        await_that(is_written, "page and exporter have the last version")
        compare_with_picture(browser, stack.out / "map.png")
        test_whole_soon(url)
        test_tools(browser)
        test_moved(browser)
        test_floating(browser)
        check(browser.errors() == [], "the console has no errors")
        test_draws_whatever_comes(browser)
        test_phone(url)
        states.test_every_state(url, read_axe_core())
        states.test_fuzz(url)
        test_asks_nobody_else(stack, browser)
    finally:
        browser.driver.quit()


def install_packages(here):
    """The clients that package-lock.json names. None where npm is not here, or does not reach its registry."""
    packages = BIN.parent / "view_packages"
    packages.mkdir(exist_ok=True)
    for name in ("package.json", "package-lock.json"):
        shutil.copy(here / name, packages)
    if not shutil.which("npm"):
        return None
    done = subprocess.run(["npm", "ci", "--prefer-offline", "--ignore-scripts", "--no-audit", "--no-fund"],
                          cwd=packages, capture_output=True, text=True, check=False)
    if "EUSAGE" in done.stderr or "EINTEGRITY" in done.stderr:  # the lockfile is wrong, and no registry is to blame
        raise AssertionError(done.stderr)
    return packages if done.returncode == 0 else None


def read_axe_core():
    """The code of axe-core, which looks for what keeps people from reading a page; empty where npm does not bring it."""
    packages = install_packages(HERE)
    if not packages:
        print("  skipped: npm is not here, or does not reach its registry: no axe-core (scripts/setup --npm)")
        return ""
    return (packages / "node_modules/axe-core/axe.min.js").read_text()


def test_foxglove(out, http):
    """By programs that others wrote, where npm brings them."""
    packages = install_packages(HERE)
    if not packages:
        print("  skipped: npm is not here, or does not reach its registry: no client of Foxglove's own (scripts/setup --npm)")
        return
    mcap = out / "run.mcap"
    subprocess.run([BIN / "map_viewer", out, "--mcap", mcap], check=True)
    seen = subprocess.run(["node", HERE / "foxglove_client.mjs", http.rsplit(":", 1)[1], out / "map.png", mcap],
                          env={**os.environ, "NODE_MODULES": str(packages / "node_modules")}, capture_output=True,
                          text=True, check=False)
    check(seen.returncode == 0, f"Foxglove's client and MCAP's reader see the same map: {seen.stdout}{seen.stderr}")


def test_path(browser):
    seen = browser.run(PATH_SEEN)
    for where in ("afar", "nearby"):
        num, num_drawn = seen[where]
        check(num > 100 and num_drawn > 0.95 * num,  # the marker of the start covers some
              f"of {num} places of the path that are seen from {where}, {num_drawn} are drawn")
    check(seen["afar"][0] == seen["num"] > seen["nearby"][0], "and from afar that is all of it")


def test_several(results):
    """Two runs on one page."""
    http = f"127.0.0.1:{free_port(socket.SOCK_STREAM)}"
    other = results.parent / "other"
    shutil.copytree(results, other)
    viewer = subprocess.Popen([BIN / "map_viewer", results, other, "--http", http], stderr=subprocess.DEVNULL)
    browser = Browser("about:blank")
    try:
        await_that(lambda: socket.socket().connect_ex(("127.0.0.1", int(http.rsplit(":", 1)[1]))) == 0, "two runs")
        browser.driver.get(f"http://{http}/")
        await_that(lambda: browser.run("""
            const callback = arguments[0];
            import('/main.js').then(({robots}) => callback(
                robots.length === 2 && robots.every(({model}) => model.timeline)));"""), "are side by side")
        seen = browser.run(OVER)
        named = [str(other)]
        check((seen["beside"], seen["over"], seen["without"], seen["difference"]) == ([], named, [], named),
              "one over the other, the other robot is drawn with its name")
        check(seen["labels"] == 2, f"and both are named: {seen}")
        for mode in ("overlay", "difference", "beside"):
            check(seen["states"][mode] == ["GOOD"] * 3, f"and how they are, once they are drawn: {mode}")
        seen = browser.run(DIFFERENCE)
        check(max(seen["equal"]) <= 2 and seen["changed"] > 200,  # 2: what rounding may do
              f"with only what differs equal maps are black, and a wall that one lacks is bright: {seen}")
        check(browser.errors() == [], "the console has no errors")
        for link, mode, names in (("mode=difference", "difference", [str(results)]),
                                  (f"robot={urllib.parse.quote(str(other), '')}", "beside", [str(other)]),
                                  ("mode=beside", "beside", [str(results)])):
            browser.driver.execute_script(f"location.hash = '{link}';")
            await_that(lambda: browser.driver.execute_script("""
                return [document.body.dataset.mode ?? 'beside', document.getElementById('name').textContent];""") == [mode, *names],
                       f"a link shows what it says: {link}")
        browser.driver.set_window_size(412, 915)
        time.sleep(0.5)
        covered = browser.run(timeline.COVERED)
        check(covered["covers"] == [] and covered["is_inside"], f"on a phone nothing covers the map of either: {covered}")
        browser.picture("two_phone")
    finally:
        browser.driver.quit()
        viewer.send_signal(signal.SIGINT)
        viewer.wait(PATIENCE_S)


def test_finished(out):
    http = f"127.0.0.1:{free_port(socket.SOCK_STREAM)}"
    results = out / "finished"
    subprocess.run([BIN / "slam_offline", "sim:demo", "--out", results], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    viewer = subprocess.Popen([BIN / "map_viewer", results, "--http", http], stderr=subprocess.DEVNULL)
    browser = Browser("about:blank")
    try:
        port = int(http.rsplit(":", 1)[1])
        await_that(lambda: socket.socket().connect_ex(("127.0.0.1", port)) == 0, "a finished run")
        browser.driver.get(f"http://{http}/#map=last")
        await_that(lambda: browser.state()["version"] > 0, "is shown without a bus")
        compare_with_picture(browser, results / "map.png")
        test_path(browser)
        timeline.test_timeline(browser, f"http://{http}/")
        timeline.test_seen_afar(browser)
        timeline.test_phone(f"http://{http}/")
        test_foxglove(results, http)
        test_several(results)
    finally:
        browser.driver.quit()
        viewer.send_signal(signal.SIGINT)
        check(viewer.wait(PATIENCE_S) == 0, "the viewer ends when it is asked to")


def main():
    if not (shutil.which("chromium") and shutil.which("chromedriver")):
        print("skipped: there is no Chromium: scripts/setup --view")
        return SKIPPED
    with tempfile.TemporaryDirectory(prefix="crsm_view_") as folder:
        out = pathlib.Path(folder)
        stack = Stack(out)
        try:
            test_finished(out)
            changes.test_changes(out)
            edits.test_edits(out, read_png)
            pieces.test_pieces(out, compare_with_picture)
            pieces.test_another_piece()
            states.test_token(out / "finished")
            test_live(stack)
            states.test_by_evidence()
            states.test_start_pose()
            marks.test_marks()
            fleet.test_fleet(read_axe_core())
        except AssertionError as error:
            print(f"FAILED: {error}")
            return 1
        finally:
            stack.end()
    return 0


if __name__ == "__main__":
    sys.exit(main())
