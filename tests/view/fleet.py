"""The page of a fleet: three robots in one flat, which float first and then join; each has its colour, its path and its page."""

import pathlib
import re
import signal
import socket
import subprocess
import tempfile

from harness import BIN, PATIENCE_S, Browser, await_that, check, free_port

WORLD = pathlib.Path(__file__).parents[2] / "common/worlds/demo.world"
ROBOTS = ["robot1/", "robot2/", "robot3/"]

# What the page shows of the fleet: the list, the badge, which maps are seen, and what is told of the robots.
FLEET = """
const callback = arguments[0];
import('/main.js').then(({robots}) => {
  const {model} = robots[0];
  const text = (id) => document.getElementById(id).textContent;
  const rows = [...document.querySelectorAll('#fleet li')].map((row) => ({
    name: row.querySelector('button').textContent, state: row.querySelector('.state').textContent,
    says: row.querySelector('.says').textContent, is_link: !row.querySelector('button').disabled,
    colour: getComputedStyle(row.querySelector('.swatch')).borderTopColor}));
  const at = (robot) => robot?.at ?? null;
  callback({rows, state: text('state'), why: text('why'), tone: document.getElementById('state').dataset.tone,
            toast: text('toast'), name: text('name'), fits: robots[0].view.fits,
            news: model.news ?? [], seen: robots.filter(({parent}) => parent.checkVisibility()).map(({model}) => model.info.robot),
            at: Object.fromEntries((model.fleet ?? []).map((robot) => [robot.name, at(robot)])),
            told: model.info.fleet ?? null, places: model.info.fleet?.joins.places ?? [],
            off_path_m: (model.info.fleet?.joins.places ?? []).map(([x_m, y_m]) => Math.min(
                ...model.path.map((point) => Math.hypot(point.x_m - x_m, point.y_m - y_m)))),
            pose: document.getElementById('x').checkVisibility(),
            marks: model.info.marks.map(({name, id}) => `${id} ${name}`),
            removes: document.querySelectorAll('#places .remove').length,
            form: document.getElementById('mark_form').checkVisibility(),
            disabled: document.getElementById('mark').ariaDisabled});
});
"""

# Keeps each line of news, which the page shows for some seconds only.
KEEP_NEWS = """
const callback = arguments[0];
import('/main.js').then(({robots}) => {
  const {model} = robots[0];
  model.news = [];
  model.addEventListener('news', ({detail}) => model.news.push(detail));
  callback();
});
"""

# Draws the fleet. Callback: of each robot its colour, of how many places of its path that are seen, how many have it, and
# the longest line that is drawn in it [m]; the names that are drawn; and how many lines are dashed.
DRAWN_FLEET = """
const callback = arguments[0];
import('/main.js').then(async ({robots}) => {
  const {model, view} = robots[0];
  view.fit();
  await drawn();
  const context = view.canvas.getContext('2d');
  const {moveTo, lineTo, fillText, setLineDash, stroke} = context;
  const lines = [], names = [];
  let dashed = 0, last = null, line = [];
  context.moveTo = (x, y) => { last = [x, y]; moveTo.call(context, x, y); };
  context.lineTo = (x, y) => { line.push(Math.hypot(x - last[0], y - last[1])); last = [x, y]; lineTo.call(context, x, y); };
  context.stroke = (...rest) => { lines.push([context.strokeStyle, Math.max(0, ...line)]); line = []; stroke.apply(context, rest); };
  context.fillText = (text, ...rest) => { names.push(text); fillText.call(context, text, ...rest); };
  context.setLineDash = (dash) => { dashed += dash.length > 0; setLineDash.call(context, dash); };
  const {camera} = view;
  view.stale = true;
  view.draw(performance.now());
  Object.assign(context, {moveTo, lineTo, fillText, setLineDash, stroke});
  const {data, width, height} = context.getImageData(0, 0, view.canvas.width, view.canvas.height);
  const seen = model.fleet.map(({name, colour, trajectories}) => {
    const tint = view.colours[`fleet_${colour}`];
    const wanted = [1, 3, 5].map((at) => parseInt(tint.slice(at, at + 2), 16));
    const points = model.path.filter(({trajectory}) => trajectories.includes(trajectory));
    const is_drawn = ({x_m, y_m}) => {
      const x = Math.round(width / 2 + (x_m - camera.x_m) * camera.px * view.ratio);
      const y = Math.round(height / 2 - (y_m - camera.y_m) * camera.px * view.ratio);
      return [-1, 0, 1].some((up) => [-1, 0, 1].some((right) => wanted.every((value, i) =>
          Math.abs(value - data[4 * ((y + up) * width + x + right) + i]) < 60)));
    };
    return {name, tint, num: points.length, num_drawn: points.filter(is_drawn).length,
            longest_m: Math.max(0, ...lines.filter(([style]) => style === tint).map(([, longest_m]) => longest_m))};
  });
  callback({seen, names, dashed});
});
"""

# Tells the page of a fleet as no fleet is: the first robot is silent, and the last one has a name that is markup.
# Callback: the rows, the badge, the colours in which robots are filled, and how many pictures the page has.
STRANGE = """
const callback = arguments[0];
import('/main.js').then(async ({robots}) => {
  const {model, view, connection} = robots[0];
  const {onmessage} = connection.socket;
  connection.socket.onmessage = null;
  const {info} = model;
  const told = structuredClone(info.fleet);
  told.robots[0].heard = false;
  told.robots.at(-1).name = '<img src=x onerror=alert(1)>';
  const context = view.canvas.getContext('2d');
  const {fill} = context;
  const fills = new Set();
  context.fill = (...rest) => { fills.add(context.fillStyle); fill.apply(context, rest); };
  model.take({...info, kind: 'info', fleet: told});
  await drawn();
  context.fill = fill;
  const rows = [...document.querySelectorAll('#fleet li')].map((row) => [row.querySelector('button').textContent,
                                                                         row.querySelector('.state').textContent]);
  const seen = {rows, state: document.getElementById('state').textContent, why: document.getElementById('why').textContent,
                is_grey: fills.has(view.colours.dim), pictures: document.querySelectorAll('img').length};
  model.take({...info, kind: 'info'});
  connection.socket.onmessage = onmessage;
  callback(seen);
});
"""

SAY_MARK = """
const callback = arguments[0];
import('/main.js').then(({robots}) => {
  const {x_m, y_m} = robots[1].model.robot;
  robots[1].connection.say(`mark ${JSON.stringify({id: 'hatch', kind: 'door', name: 'hatch', points: [[x_m, y_m]]})}`);
  callback();
});
"""

AXE = """
const callback = arguments[0];
axe.run(document, {resultTypes: ['violations']}).then(({violations}) => callback(
    violations.map(({id, nodes}) => `${id}: ${nodes.map(({html}) => html).join(' ')}`)));
"""


def move_aside(waypoint, by_m):
    word, x_m, y_m = waypoint.split()[:3]
    return f"{word} {float(x_m) + by_m:.2f} {float(y_m) + by_m:.2f}"


def write_worlds(folder):
    """The flat of sim:demo, driven from three places on, once the other way round, and for longer than the test takes."""
    lines = WORLD.read_text(encoding="utf-8").splitlines()
    walls = [line for line in lines if not line.startswith("waypoint")]
    way = [line for line in lines if line.startswith("waypoint")][:-1]  # the last one is the first
    back = way[::-1]
    for number, drive in enumerate((way, back[12:] + back[:12], way[20:] + way[:20])):
        path = folder / f"{number}.world"
        aside = [move_aside(line, 0.2 * number - 0.2) for line in 4 * drive]  # so that no path covers another one
        path.write_text("\n".join([*walls, *aside]) + "\n", encoding="utf-8")
        yield f"sim:{path}"


def click(browser, what):
    browser.driver.execute_script("document.querySelector(arguments[0]).click()", what)
    return browser.run(f"const callback = arguments[0]; drawn().then(() => {{ {FLEET.replace('const callback = arguments[0];', '')} }});")


def test_growth(browser):
    """They float, until the first one joins."""
    seen = lambda: browser.run(FLEET)
    await_that(lambda: [row["name"] for row in seen()["rows"]] == ROBOTS and all(seen()["at"].values()),
               "the robots of a fleet are listed, and are somewhere")
    browser.run(KEEP_NEWS)
    browser.run(SAY_MARK)
    now = seen()
    check(now["seen"] == ["fleet/"] and now["fits"] and not now["pose"], "the page of the fleet comes first, alone, without a robot's numbers")
    check(len({row["colour"] for row in now["rows"]}) == 3, "each robot has a colour of its own")
    await_that(lambda: "floating" in [row["state"] for row in seen()["rows"]] and re.match("[12] OF 3 JOINED", seen()["state"]),
               "one floats at first, and the badge says so")
    drawn = browser.run(DRAWN_FLEET)
    check(drawn["dashed"] > 0 and set(ROBOTS) <= set(drawn["names"]), f"which is dashed, and they are named: {drawn['names']}")
    browser.picture("fleet_floating")
    await_that(lambda: any(re.search(r"robot\d/ joined at -?\d+\.\d, -?\d+\.\d", line) for line in seen()["news"]),
               "one joins, which is said, and where")
    now = seen()
    check(0 < len(now["places"]) == sum(off_m < 0.3 for off_m in now["off_path_m"]),  # keyframes are 0.2 m apart
          f"and the place is marked, on a path: {now['places']}, {now['off_path_m']} m off")
    check(any("{:.1f}, {:.1f}".format(*place) in line for place in now["places"] for line in now["news"]), "it is the same one")


def off_m(seen):
    """How far robots are from their newest keyframes, at most."""
    return max(abs(seen["at"][told["name"]][f"{axis}_m"] - told["newest"][i]) for told in seen["told"]["robots"]
               for i, axis in enumerate("xy"))


def test_joined(browser, axe_core):
    seen = lambda: browser.run(FLEET)
    await_that(lambda: seen()["state"] == "3 OF 3 JOINED", "all have joined")
    now = seen()
    check(now["tone"] == "good" and [row["state"] for row in now["rows"]] == ["joined"] * 3, "which is good")
    doubts = [re.search(r"\d keyframes · (± \d+\.\d cm|the map begins with it)$", row["says"]) for row in now["rows"]]
    check(all(doubts) and len({doubt[1] for doubt in doubts}) > 1, f"keyframes and doubt are told: {[row['says'] for row in now['rows']]}")
    await_that(lambda: 0.0 < off_m(seen()) < 1.5,  # the way since; a join is told a moment before the map is moved
               "each robot is where its pose is on the common map, a bit off its newest keyframe")
    drawn = browser.run(DRAWN_FLEET)
    for robot in drawn["seen"]:
        check(robot["num"] > 30 and robot["num_drawn"] > 0.6 * robot["num"],  # paths of others, robots and names cover some
              f"the path of {robot['name']} is drawn in its colour: {robot}")
        check(0.0 < robot["longest_m"] < 3.0, "and leads to no other robot")
    await_that(lambda: seen()["marks"] == ["robot1/hatch robot1: hatch"], "the fleet shows the place of a robot")
    now = click(browser, "#mark")
    check((now["disabled"], now["form"], now["removes"]) == ("true", False, 0) and now["toast"].startswith("places are added on the page of a robot"),
          f"and takes none itself, which it says: {now['toast']}")
    for theme in ("dark", "light"):
        click(browser, "#theme")
        if axe_core:
            browser.driver.execute_script(axe_core)
            found = browser.driver.execute_async_script(AXE)
            check(found == [], f"axe-core finds nothing: {found}")
        browser.picture(f"fleet_{theme}")


def test_links(browser):
    now = click(browser, "#fleet li:nth-child(2) button")
    check(now["seen"] == ["robot2/"] and now["name"] == "robot2/" and now["pose"] and now["disabled"] == "false",
          "a robot of the list leads to its page, where places can be added")
    check([row["name"] for row in now["rows"]] == ["fleet/"] and now["rows"][0]["is_link"], "which names its fleet")
    browser.picture("fleet_robot")
    await_that(lambda: "robot=robot2" in browser.driver.current_url, "the address keeps it")
    browser.driver.refresh()
    await_that(lambda: browser.run(FLEET)["seen"] == ["robot2/"], "who opens it sees the same")
    await_that(lambda: browser.run(FLEET)["rows"], "and the fleet again")
    now = click(browser, "#fleet li button")
    check(now["seen"] == ["fleet/"] and len(now["rows"]) == 3, "and a robot's page leads to its fleet")


def test_strange(browser):
    seen = browser.run(STRANGE)
    check(seen["rows"][0] == ["robot1/", "silent"] and seen["is_grey"] and "robot1/ not heard for ten seconds" in seen["why"]
          and seen["state"] == "2 OF 3 JOINED", f"a silent robot is grey: {seen}")
    check(seen["rows"][2][0].startswith("<img") and seen["pictures"] == 0, "and a name is text, whatever it is")


def test_fleet(axe_core):
    with tempfile.TemporaryDirectory(prefix="crsm_view_") as folder:
        out = pathlib.Path(folder)
        http = f"127.0.0.1:{free_port(socket.SOCK_STREAM)}"
        with open(out / "log", "w", encoding="utf-8") as log:
            stack = subprocess.Popen([BIN / "run_stack", "--robots", "3", *write_worlds(out), "--out", out / "fleet", "--rate", "4",
                                      "--view", "--http", http, "--lcm-url", f"udpm://239.255.76.67:{free_port(socket.SOCK_DGRAM)}?ttl=0"],
                                     stdout=log, stderr=log)
        browser = Browser("about:blank")
        try:
            await_that(lambda: socket.socket().connect_ex(("127.0.0.1", int(http.rsplit(":", 1)[1]))) == 0, "three robots and their fleet")
            browser.driver.get(f"http://{http}/")
            test_growth(browser)
            test_joined(browser, axe_core)
            test_links(browser)
            test_strange(browser)
            browser.driver.set_window_size(412, 915)
            click(browser, "#fit")
            check(browser.driver.execute_script("return document.documentElement.scrollWidth - innerWidth") <= 0, "it fits a phone")
            browser.picture("fleet_phone")
            check(browser.errors() == [], "the console has no errors")
        finally:
            browser.driver.quit()
            stack.send_signal(signal.SIGTERM)
            stack.wait(PATIENCE_S)
