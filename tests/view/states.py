"""What the badge says, by what came last: of processes that are stopped, and of every state in every size and theme."""

import math
import os
import pathlib
import signal
import socket
import subprocess
import tempfile

from harness import BIN, PATIENCE_S, Browser, Stack, await_that, check, free_port

SIZES = {"desktop": "1440,900", "phone": "412,915", "landscape": "915,512"}

# Shows a state in a theme. Callback: what the badge and the words beside it say, whether they fit, and, where axe-core is
# there, what it finds.
SHOW = """
const [theme, told, callback] = arguments;
import('/main.js').then(async ({robots}) => {
  const {model} = robots[0];
  document.documentElement.dataset.theme !== theme && document.getElementById('theme').click();
  document.activeElement.blur();
  Object.assign(model, {connected: true, refusal: ''});
  if (told.info) {
    model.samples = told.samples ?? [];
    model.robot = null;
    model.was_found = told.was_found ?? true;
    if (told.robot) model.take({kind: 'robot', utime: 0n, trajectory: 0, floating: false, x_m: 1, y_m: 1, yaw_rad: 0,
        fitness: 0.5, covariance: {xx: 1e-3, xy: 0, yy: 1e-3, yaw: 1e-4}, axis: {x: 1, y: 1}, rays: [], critical: [],
        ...told.robot});
    model.take({kind: 'info', robots: [''], robot: 'robot1/', loops: [], live: true, scans: 1294, ...told.info});
  }
  if (told.connected !== undefined) {
    model.setConnected(told.connected, told.refusal);
    model.connection_at_ms = performance.now() - 7000;
  }
  Object.assign(model, {num_loaded: 1, num_left: told.left ?? 0});
  if (told.left) model.cursor = {epoch: 0n, version: 0n};
  await drawn();
  const box = (id) => document.getElementById(id).getBoundingClientRect();
  const [badge, head] = [box('state'), box('head')];
  const covers = ['tools', 'panel', 'player', 'foot'].filter((id) => {
    const other = box(id);
    return other.width > 0 && other.left < head.right && other.right > head.left && other.top < head.bottom &&
           other.bottom > head.top;
  });
  const known = document.getElementById('last_known');
  const seen = {state: document.getElementById('state').textContent, why: document.getElementById('why').textContent,
            tone: document.getElementById('state').dataset.tone, spoken: document.getElementById('spoken').textContent,
            tiles: Object.fromEntries([...document.querySelectorAll('.tiles div:not([hidden]) output')].map(
                ({id, textContent}) => [id, textContent])),
            title: document.title, is_old: known.checkVisibility(), grey: model.is_old,
            label: document.querySelector('.map canvas').getAttribute('aria-label'),
            fits: badge.left >= 0 && badge.right <= head.right && head.right <= innerWidth && box('counts').right <= head.right, covers};
  const axe = window.axe ? await window.axe.run(document, {resultTypes: ['violations']}) : {violations: []};  // takes a while
  callback({...seen, violations: axe.violations.map(({id, nodes}) => `${id}: ${nodes.map(({html}) => html).join(' ')}`)});
});
"""

SERVICES = [{"name": name, "state": "at work", "silent_s": 0.5, "counters": {}, "max_ms": 1, "p50_ms": 1, "p99_ms": 1,
             "resident_mb": 1, "pid": 1, "version": ""}
            for name in ("ray_selector", "rrhc_matcher", "map_updater", "laser_publisher")]


ENDED = [*SERVICES[:3], {**SERVICES[3], "state": "finished", "silent_s": 60}]


def silent(name, seconds):
    return [{**service, "silent_s": seconds} if service["name"] == name else service for service in SERVICES]


def well(**others):
    return {"services": SERVICES, "scan_age_s": 0.1, "match_age_s": 0.1, **others}


def is_in(state):
    return {"state": state}


# name: (what is told, how the badge begins, its tone, a part of the words beside it)
STATES = {
    "waiting": ({"info": {"services": SERVICES}}, "waiting for scans", "none", "no scan has come yet"),
    "waiting_for_services": ({"info": {"services": SERVICES[1:]}}, "waiting for scans", "none", "ray_selector not heard"),
    "ok": ({"info": well(), "robot": is_in("OK")}, "OK", "good", ""),
    "degenerate": ({"info": well(), "robot": is_in("DEGENERATE")}, "DEGENERATE along 45°", "warn", "direction"),
    "lost": ({"info": well(), "robot": is_in("LOST"), "samples": [
        {"time_s": 1, "fitness": 0.9, "state": "OK"}, {"time_s": 2, "fitness": 0, "state": "LOST"},
        {"time_s": 14, "fitness": 0, "state": "LOST"}]}, "LOST for 12 s", "bad", "fits nowhere"),
    "floating": ({"info": well(), "robot": {"state": "OK", "floating": True, "trajectory": 3}}, "FLOATING", "floating",
                 "trajectory 3"),
    "localised": ({"info": well(services=[{**service, "state": "localising on a finished map"} for service in SERVICES]),
                   "robot": is_in("OK")}, "LOCALISED", "good", ""),
    "never_localised": ({"info": well(services=[{**service, "state": "localising on a finished map"} for service in SERVICES]),
                         "robot": is_in("LOST"), "was_found": False}, "NOT LOCALISED", "bad", "the pin"),
    "matcher_stopped": ({"info": well(services=silent("rrhc_matcher", 6.2), scan_age_s=0.1, match_age_s=6),
                         "robot": is_in("OK")}, "rrhc_matcher silent for 6 s", "bad", "not mapped"),
    "exporter_stopped": ({"info": well(services=[*SERVICES, {**SERVICES[0], "name": "map_exporter", "silent_s": 9}]),
                          "robot": is_in("OK")}, "OK", "warn", "map_exporter silent for 9 s"),
    "unplugged": ({"info": well(scan_age_s=6.3, match_age_s=6.3), "robot": is_in("OK")}, "no scan for 6 s", "bad",
                  "laser unplugged"),
    "no_pose": ({"info": well(match_age_s=8), "robot": is_in("OK")}, "no pose for 8 s", "bad", "none is matched"),
    "another_piece": ({"info": well(another_piece=True), "robot": is_in("OK")}, "ANOTHER PIECE", "warn", "the larger one"),
    "without_rays": ({"info": well(floating=3, without_rays=12, left_out=1234), "robot": is_in("NO RAYS")}, "NO RAYS", "bad",
                     "measurement"),
    "log_ended": ({"info": well(scan_age_s=60, match_age_s=60, services=ENDED), "robot": is_in("OK")}, "LOG ENDED", "none",
                  "published"),
    "finished_good": ({"info": {"live": False, "verdict": {"trust": "good", "off_at_m": [1, 2], "lines": [
        "all", "the map is good", "parts of it may be off by up to 2 m, most likely past x 1 m, y 2 m"]}}}, "GOOD", "good",
                      "the map is good; parts of it may be off by up to 2 m"),
    "finished_doubtful": ({"info": {"live": False, "verdict": {"trust": "doubtful", "lines": [
        "all", "the map is doubtful: it may be"]}}}, "DOUBTFUL", "warn", "the map is doubtful"),
    "finished_bad": ({"info": {"live": False, "verdict": {"trust": "bad", "lines": ["the map is bad"]}}}, "BAD", "bad", ""),
    "finished_without": ({"info": {"live": False, "verdict": {"trust": "none", "lines": [
        "there is no verdict: the run has not ended"]}}}, "FINISHED", "none", "has not ended"),
    "no_connection": ({"info": well(), "connected": False}, "no connection for 7 s", "bad", "map_viewer"),
    "run_ended": ({"info": well(services=ENDED), "robot": is_in("OK"), "connected": False}, "LOG ENDED", "none",
                  "in a moment"),
    "loading": ({"info": {"live": False}, "left": 3}, "loading, 25 %", "none", ""),
    "token_missing": ({"info": {}, "connected": False, "refusal": "token missing"}, "token missing", "bad", "#token="),
}
WITHOUT_POSE = {"lost", "never_localised", "without_rays", "matcher_stopped", "unplugged", "no_pose"}  # where the numbers are not those of now


# How far the legend is scrolled when it opens, and of how many tools it tells.
LEGEND = """
const entries = [...document.querySelectorAll('#tool_list button')];
return {top: document.getElementById('key').scrollTop,
        tools: entries.filter((entry) => entry.querySelector('svg') && entry.textContent).length};
"""


def cut_off(browser):
    """From its viewer, so that only the test tells the page something."""
    browser.run("""
        const callback = arguments[0];
        import('/main.js').then(({robots}) => {
          const {connection} = robots[0];
          connection.socket.onclose = connection.socket.onmessage = null;
          connection.socket.close();
          callback();
        });""")


def test_every_state(url, axe_core):
    """Each state, told to a page that hears no viewer."""
    for size, pixels in SIZES.items():
        browser = Browser(url, pixels)
        try:
            await_that(lambda: browser.state()["connected"], f"{size}: the page is there")
            cut_off(browser)
            if axe_core:
                browser.driver.execute_script(axe_core)
            for name, (told, state, tone, why) in STATES.items():
                for theme in ("dark", "light"):
                    seen = browser.run(SHOW, theme, told)
                    browser.picture(f"state_{name}_{size}_{theme}")
                    wanted = seen["state"].startswith(state) and seen["tone"] == tone and why in seen["why"]
                    wanted &= seen["title"].startswith(seen["state"]) and seen["grey"] == (name in WITHOUT_POSE)
                    if size != "landscape":  # where the panel is folded
                        wanted &= seen["is_old"] == (seen["grey"] and name != "never_localised")
                    wanted &= seen["label"].startswith("Map of ") and ("robot is at" in seen["label"]) == (
                        "robot" in STATES[name][0] and name != "never_localised")
                    if not (wanted and seen["fits"] and not seen["covers"] and not seen["violations"]):
                        raise AssertionError(f"{size}, {theme}, {name}: {seen}")
            tiles = {name: browser.run(SHOW, "dark", STATES[name][0])["tiles"] for name in ("ok", "without_rays")}
            check(set(tiles["ok"]) == {"scans", "lost", "loops", "area"}, f"{size}: a number that is 0 has no tile, but for these")
            check({**tiles["without_rays"], "floating": "3", "without_rays": "12", "left_out": "1,234"} == tiles["without_rays"],
                  f"{size}: what floats, what had no rays and what was left out are counted: {tiles['without_rays']}")
            browser.driver.find_element("tag name", "body").send_keys("?")
            legend = browser.driver.execute_script(LEGEND)
            check(legend["top"] == 0 and legend["tools"] >= 10, f"{size}: the legend opens at its begin: {legend}")
            if axe_core:
                found = browser.driver.execute_async_script("""
                    const callback = arguments[0];
                    axe.run(document, {resultTypes: ['violations']}).then(({violations}) => callback(
                        violations.map(({id, nodes}) => `${id}: ${nodes.map(({html}) => html).join(' ')}`)));""")
                check(found == [], f"{size}: axe-core finds nothing in {len(STATES)} states and the key: {found}")
            errors = browser.errors()
            check(errors == [], f"{size}: every state is said, fits, and nothing covers it: {errors}")
        finally:
            browser.driver.quit()


def test_token(results):
    """A viewer for other hosts, opened without its token, with another one, and by a link that is pasted."""
    port = free_port(socket.SOCK_STREAM)
    token = "0123456789abcdef" * 2
    viewer = subprocess.Popen([BIN / "map_viewer", results, "--http", f"0.0.0.0:{port}"], stderr=subprocess.DEVNULL,
                              env={**os.environ, "CRSM_VIEWER_TOKEN": token})
    browser = Browser("about:blank")
    try:
        await_that(lambda: socket.socket().connect_ex(("127.0.0.1", port)) == 0, "a viewer for other hosts")
        browser.driver.get(f"http://127.0.0.1:{port}/")
        await_that(lambda: browser.state()["state"] == "token missing" and "#token=" in browser.state()["why"],
                   "says that its token is missing, and where it is")
        browser.picture("token")
        for pasted, state in (("1" * 32, "token wrong"), (token, "GOOD")):
            browser.driver.execute_script(f"location.hash = 'token={pasted}';")
            await_that(lambda: browser.state()["state"] == state, f"a link is pasted: {state}")
    finally:
        browser.driver.quit()
        viewer.send_signal(signal.SIGINT)
        viewer.wait(PATIENCE_S)


def test_by_evidence():
    """Processes that are stopped, killed or not there yet."""
    with tempfile.TemporaryDirectory(prefix="crsm_view_") as folder:
        stack = Stack(pathlib.Path(folder))
        browser = None
        try:
            stack.start_viewer()
            browser = Browser(f"http://{stack.http}/")

            def says(begin, why, what):
                def is_said():
                    seen = browser.state()
                    return seen["state"].startswith(begin) and why in seen["why"]
                await_that(is_said, f"{what}: {begin}")
            says("waiting for scans", "ray_selector", "before the services are there")
            stack.start_updater()
            stack.start("ray_selector")
            stack.start("rrhc_matcher")
            says("waiting for scans", "no scan has come yet", "before the first scan")
            stack.start("laser_publisher", "sim:block", "--rate", "1")
            says("OK", "", "while scans come")
            stack.processes["rrhc_matcher"].send_signal(signal.SIGSTOP)
            says("rrhc_matcher silent for", "", "a matcher that hangs")
            stack.processes["rrhc_matcher"].send_signal(signal.SIGCONT)
            says("OK", "", "and one that goes on")
            stack.kill("laser_publisher")
            says("no scan for", "silent", "a laser that is unplugged")
            stack.start("laser_publisher", "sim:demo", "--rate", "max")
            check(stack.processes.pop("laser_publisher").wait(PATIENCE_S) == 0, "a log is mapped")
            says("LOG ENDED", "", "a log that has ended")
            stack.kill("map_viewer")
            says("no connection", "", "a viewer that was killed")
            check(browser.errors() == [], "the console has no errors")
        finally:
            if browser:
                browser.driver.quit()
            stack.end()


# Says with the tool of the page where the robot is: presses there, and drags to where it looks.
PLACE = """
const [x_m, y_m, yaw_rad, callback] = arguments;
import('/main.js').then(({robots}) => {
  const {view} = robots[0];
  view.canvas.setPointerCapture = () => {};
  view.setFollows(false);
  Object.assign(view.camera, {x_m, y_m, px: 40});
  document.getElementById('place').click();
  const box = view.canvas.getBoundingClientRect();
  const point = (type, right_px, up_px) => view.canvas.dispatchEvent(new PointerEvent(type, {
      clientX: box.left + box.width / 2 + right_px, clientY: box.top + box.height / 2 - up_px, pointerId: 3,
      pointerType: 'touch'}));
  point('pointerdown', 0, 0);
  point('pointermove', 80 * Math.cos(yaw_rad), 80 * Math.sin(yaw_rad));
  point('pointerup', 80 * Math.cos(yaw_rad), 80 * Math.sin(yaw_rad));
  callback(document.getElementById('toast').textContent);
});
"""


def test_start_pose():
    """A robot that is localised in the wrong place is told by a click where it is."""
    with tempfile.TemporaryDirectory(prefix="crsm_view_") as folder:
        out = pathlib.Path(folder)
        subprocess.run([BIN / "slam_offline", "sim:demo", "--out", out / "map"], check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
        stack = Stack(out)
        browser = None
        try:
            stack.start("map_updater", "--localize", out / "map")
            for name in ("ray_selector", "rrhc_matcher"):
                stack.start(name)
            stack.start_viewer()
            browser = Browser(f"http://{stack.http}/")
            stack.start("laser_publisher", "sim:demo", "--rate", "2")
            await_that(lambda: browser.state()["state"] == "LOCALISED", "a robot is localised on a finished map")
            there = robot_of(browser)
            said = browser.driver.execute_async_script(PLACE, there["x_m"] + 3.0, there["y_m"] + 1.0, there["yaw_rad"] + 2.0)
            check(said == "the matcher was told where the robot is", "a click and a drag say where it is")
            await_that(lambda: distance(robot_of(browser), there) > 1.0, "it is searched there, though it is wrong")
            here = robot_of(browser)
            # The log goes on meanwhile: where the robot is by now, nobody knows but the simulator. It has hardly turned.
            browser.driver.execute_async_script(PLACE, there["x_m"], there["y_m"], there["yaw_rad"])
            await_that(lambda: browser.state()["state"] == "LOCALISED" and distance(robot_of(browser), there) < 2.0,
                       f"and told better it is right again: {here}")
            await_that(lambda: browser.state()["toast"].startswith("found at "), "which is said")
            check(browser.errors() == [], "the console has no errors")
        finally:
            if browser:
                browser.driver.quit()
            stack.end()


def robot_of(browser):
    return browser.run("""
        const callback = arguments[0];
        import('/main.js').then(({robots}) => {
          const {x_m, y_m, yaw_rad, state} = robots[0].model.robot;
          callback({x_m, y_m, yaw_rad, state});
        });""")


def distance(a, b):
    return math.hypot(a["x_m"] - b["x_m"], a["y_m"] - b["y_m"])


# Tells the page what no viewer should: numbers that are none, words for numbers, lists for words, very many names.
# Callback, after something well-formed: whether it still draws, and what the badge says.
FUZZ = """
const [seed, callback] = arguments;
import('/main.js').then(async ({robots}) => {
  const {model} = robots[0];
  let random = seed;
  const below = (number) => (random = (random * 1103515245 + 12345) % 2147483648) % number;
  const STRANGE = [NaN, Infinity, -Infinity, -1, 1e308, 0, null, undefined, true, '', 'x'.repeat(20000), '<img src=x>', [], {},
                   [[]], [null], {name: null}];
  const any = () => STRANGE[below(STRANGE.length)];
  const service = () => ({name: any(), state: any(), silent_s: any(), counters: any(), p50_ms: any(), p99_ms: any(),
                          max_ms: any(), resident_mb: any(), pid: any(), version: any()});
  const many = Array.from({length: 2000}, (_, i) => ({...service(), name: `name ${i}`, state: '', counters: {}}));
  const info = () => ({kind: 'info', robots: [''], robot: any(), loops: below(2) ? [[NaN, 1, Infinity, 2]] : any(),
                       services: below(3) ? Array.from({length: below(9)}, service) : any(), scans: any(), lost: any(),
                       live: below(2) ? true : any(), scan_age_s: any(), match_age_s: any(), scan_times_ms: any(),
                       news: any(), verdict: any(), breaks: any(), truth: any(), localised: any(), way_m: any(), edits: any(),
                       looks: below(2), fleet: below(4) ? undefined : any()});
  const robot = () => ({kind: 'robot', utime: 0n, state: any(), trajectory: any(), floating: any(), x_m: any(), y_m: any(),
                        yaw_rad: any(), fitness: any(), covariance: below(2) ? {xx: any(), xy: any(), yy: any(), yaw: any()} : {},
                        axis: {x: any(), y: any()}, rays: [{angle_rad: any(), range_m: any()}], critical: [0, 7]});
  const path = () => ({kind: 'path', generation: below(3), first: below(9), points: [{x_m: any(), y_m: any(), state: any(), trajectory: any()}]});
  const samples = () => ({kind: 'samples', samples: [{time_s: any(), fitness: any(), state: any()}]});
  const frames = (number) => new Promise((then) => {
    const count = () => (number-- > 0 ? requestAnimationFrame(count) : then());
    count();
  });
  const {error} = console;
  console.error = () => {};
  for (let i = 0; i < 300; ++i) {
    try {
      model.take([info, robot, path, samples][below(4)]());
    } catch {}
    if (i % 10 === 9) await frames(1);
  }
  model.take({...info(), services: many, live: true, loops: [], news: null, verdict: null, breaks: [], truth: []});
  await frames(2);
  model.samples = [];
  model.path = [];
  model.take({kind: 'robot', utime: 0n, state: 'OK', trajectory: 0, floating: false, x_m: 1, y_m: 1, yaw_rad: 0, fitness: 0.5,
              covariance: {xx: 1e-3, xy: 0, yy: 1e-3, yaw: 1e-4}, axis: {x: 1, y: 1}, rays: [], critical: []});
  model.take({kind: 'info', robots: [''], robot: '', loops: [], live: true, scans: 1, services: [], scan_age_s: 0, match_age_s: 0});
  await new Promise((then) => setTimeout(then, 2200));
  model.take({kind: 'info', robots: [''], robot: '', loops: [], live: true, scans: 1, services: [], scan_age_s: 0, match_age_s: 0});
  await frames(4);
  console.error = error;
  callback({state: document.getElementById('state').textContent, draws: !model.changed,
            pictures: document.querySelectorAll('img').length});
});
"""


def test_fuzz(url):
    browser = Browser(url)
    try:
        await_that(lambda: browser.state()["connected"], "a page is there")
        cut_off(browser)
        for seed in range(1, 6):
            seen = browser.run(FUZZ, seed)
            if seen != {"state": "OK", "draws": True, "pictures": 0}:
                raise AssertionError(f"strange messages, seed {seed}: {seen}")
        print("  the page survives 1,500 strange messages")
    finally:
        browser.driver.quit()
