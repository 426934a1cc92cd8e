"""A copy of a finished map that is cropped, erased and turned on the page: by mouse, by touch and by keys."""

import hashlib
import io
import json
import math
import re
import signal
import socket
import subprocess
import tarfile
import urllib.parse
import urllib.request

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.actions import interaction
from selenium.webdriver.common.actions.action_builder import ActionBuilder
from selenium.webdriver.common.actions.pointer_input import PointerInput
from selenium.webdriver.common.keys import Keys

from harness import BIN, PATIENCE_S, Browser, await_that, check, free_port
from pieces import Viewer

PX = 24  # of a metre, in all that follows

# Looks at the origin of the map. Callback: where it is in the window.
LOOK = """
const [px, callback] = arguments;
import('/main.js').then(({robots}) => {
  const {view} = robots[0];
  view.setFollows(false);
  view.fits = false;
  Object.assign(view.camera, {x_m: 3, y_m: 3, px});
  view.stale = true;
  const box = view.canvas.getBoundingClientRect();
  const way = view.turn(-3, -3);
  callback([box.left + box.width / 2 + way.right_m * px, box.top + box.height / 2 - way.up_m * px]);
});
"""

# Callback: what the page shows of the edits, and what the viewer says of them.
EDITS = """
const callback = arguments[0];
import('/main.js').then(({robots}) => {
  const {view, model} = robots[0];
  const byId = (id) => document.getElementById(id);
  callback({open: !byId('edit_form').hidden, text: byId('edit_state').textContent, told: model.info.edits ?? null,
            looks: model.info.looks, offered: byId('edit').checkVisibility(), turn_rad: view.camera.turn_rad,
            undo: !byId('edit_undo').disabled, redo: !byId('edit_redo').disabled, draft: view.draft.length,
            link: byId('edit_download').hidden ? '' : byId('edit_download').href, aim: view.aim(),
            files: [...document.querySelectorAll('#files a')].map((link) => link.children[0].textContent)});
});
"""

# How many pixels of the map change when the edits are drawn.
DRAWN_EDITS = """
const callback = arguments[0];
import('/main.js').then(({robots}) => {
  const {view} = robots[0];
  const {edits} = view;
  const [on, off] = [edits, null].map((shown) => {
    view.edits = shown;
    view.stale = true;
    view.draw(performance.now());
    return view.canvas.getContext('2d').getImageData(0, 0, view.canvas.width, view.canvas.height).data;
  });
  view.edits = edits;
  view.stale = true;
  let num = 0;
  for (let i = 0; i < on.length; i += 4) num += on[i] !== off[i] || on[i + 1] !== off[i + 1] || on[i + 2] !== off[i + 2];
  callback(num);
});
"""


class Hand:
    """Points at places of the map [m], as long as the view does not move."""

    def __init__(self, page):
        self.page = page
        self.origin = page.run(LOOK, PX)

    def at(self, place):
        return {"x": round(self.origin[0] + PX * place[0]), "y": round(self.origin[1] - PX * place[1])}

    def act(self, kind, moves):
        """moves: of the pointer, each a place and what is done there."""
        pointer = PointerInput(kind, f"a {kind}")
        actions = ActionBuilder(self.page.driver, mouse=pointer)
        for place, deed in moves:
            pointer.create_pointer_move(duration=50, **self.at(place))
            if deed == "press":
                pointer.create_pointer_down(button=0)
            elif deed == "release":
                pointer.create_pointer_up(button=0)
        actions.perform()

    def drag(self, kind, start, end):
        between = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
        self.act(kind, [(start, "press"), (between, ""), (end, ""), (end, "release")])

    def tap(self, kind, places):
        for place in places:
            self.act(kind, [(place, "press"), (place, "release")])


def choose(page, tool):
    page.driver.execute_script("""
        const tool = document.getElementById('edit_tool');
        tool.value = arguments[0];
        tool.dispatchEvent(new Event('change'));""", tool)


def press(page, *keys):
    for key in keys:
        ActionChains(page.driver).send_keys(key).perform()


def press_with_control(page, key):
    ActionChains(page.driver).key_down(Keys.CONTROL).send_keys(key).key_up(Keys.CONTROL).perform()


def click(page, what):
    page.driver.execute_script("document.getElementById(arguments[0]).click()", what)


def await_text(page, words, what):
    await_that(lambda: re.search(words, page.run(EDITS)["text"]), what)


def is_near(points, expected, tolerance_m=0.1):  # a pixel is 4 cm, and the window has whole ones
    return len(points) == len(expected) and all(
        any(math.dist(point, other) < tolerance_m for other in expected) for point in points)


def check_download(link, results, read_png):
    """The pair, as map_server would read it, against the map itself: walls are where they were."""
    with urllib.request.urlopen(link) as answer:
        tar = tarfile.open(fileobj=io.BytesIO(answer.read()))
    names = tar.getnames()
    check(names == ["map_edited.png", "map_edited.yaml", "edits.json"], f"the download has the pair and the edits: {names}")
    for name in names:
        check(tar.extractfile(name).read() == (results / name).read_bytes(), f"{name} is that beside the map")
    place = lambda name: [float(number) for number in re.search(r"^origin: \[(.*), (.*), 0.0\]", (results / name).read_text(),
                                                                re.MULTILINE).groups()]
    yaw_rad = json.loads((results / "edits.json").read_text())["T_edited_map"]["yaw_rad"]
    pictures = {}
    for name in ("map", "map_edited"):
        width, height, grey = read_png(results / f"{name}.png")
        pictures[name] = (width, height, grey, place(f"{name}.yaml"))

    def look(name, x_m, y_m):
        width, height, grey, (left_m, bottom_m) = pictures[name]
        column, row = math.floor((x_m - left_m) / 0.05), height - 1 - math.floor((y_m - bottom_m) / 0.05)
        return grey[row * width + column] if 0 <= column < width and 0 <= row < height else 127

    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    walls = kept = 0
    for i in range(80):
        for j in range(80):  # cells of 4 m x 4 m that are cropped, and not erased
            x_m, y_m = 0.525 + 0.05 * i, -1.975 + 0.05 * j
            if look("map", x_m, y_m) < 127:
                walls += 1
                kept += look("map_edited", cos * x_m - sin * y_m, sin * x_m + cos * y_m) < 127
    check(walls > 50 and kept > 0.95 * walls, f"of {walls} cells of walls, {kept} are walls at their place of the edited map")


def test_edits(out, read_png):
    """out / finished: a run of sim:demo. Another one, which begins aslant, is edited."""
    text = subprocess.run([BIN / "slam_eval", "world", "demo"], check=True, capture_output=True, text=True).stdout
    world, results = out / "aslant.world", out / "aslant"
    world.write_text(text.replace("waypoint 4.6 5\n", "waypoint 5 5\nwaypoint 4.6 3.9\n", 1))
    check(world.read_text() != text, "a robot begins aslant to the walls")  # atan2(0.4, 1.1) is 20 degrees
    subprocess.run([BIN / "slam_offline", f"sim:{world}", "--out", results], check=True, capture_output=True)
    before = hashlib.sha256((results / "map.png").read_bytes()).hexdigest()
    with Viewer(results) as page:
        press(page, "e")
        seen = page.run(EDITS)
        check(seen["open"] and seen["offered"] and "Nothing is changed" in seen["text"] and not seen["link"], "a key opens the tool")
        hand = Hand(page)
        hand.drag("mouse", (-2, -2), (8, 7))
        await_text(page, "^cropped; map_edited.png is beside the map", "a mouse drags a rectangle, and the edited map is there")
        told = json.loads((results / "edits.json").read_text())
        check(is_near(told["crop_m"], [(-2, -2), (8, -2), (8, 7), (-2, 7)]), f"the map is cropped to it: {told['crop_m']}")
        choose(page, "free")
        hand.tap("touch", [(0.5, 3), (1.5, 3), (1.5, 4), (0.5, 4), (0.5, 3)])
        await_text(page, "1 erased; map_edited", "touches make an outline; the last one is its first corner")
        told = json.loads((results / "edits.json").read_text())["erase"]
        check(told[0]["becomes"] == "free" and is_near(told[0]["outline_m"], [(0.5, 3), (1.5, 3), (1.5, 4), (0.5, 4)]),
              f"which is erased: {told}")
        hand.tap("touch", [(0, 0), (1, 0)])
        press_with_control(page, "z")
        check(page.run(EDITS)["draft"] == 1, "undo takes back a corner")
        press(page, Keys.ESCAPE)
        check(not page.run(EDITS)["open"], "Escape ends it")
        page.driver.execute_script("document.getElementById('edit').focus()")
        press(page, Keys.ENTER)
        choose(page, "unexplored")
        aims = [page.run(EDITS)["aim"]]
        press(page, Keys.ENTER)
        for arrow in (Keys.ARROW_RIGHT, Keys.ARROW_UP):
            press(page, arrow, Keys.ENTER)
            aims.append(page.run(EDITS)["aim"])
        page.picture("edits_keys")
        press(page, Keys.ENTER)
        await_text(page, "2 erased; map_edited", "keys make an outline: arrows, Enter, and Enter twice at its end")
        told = json.loads((results / "edits.json").read_text())["erase"][1]
        check(told["becomes"] == "unexplored" and is_near(told["outline_m"], [(at["x_m"], at["y_m"]) for at in aims], 0.01),
              f"at the middle of the view: {told}")
        press_with_control(page, "z")
        await_text(page, "1 erased; map_edited", "undo takes back what was erased")
        press_with_control(page, "y")
        await_text(page, "2 erased; map_edited", "redo brings it back")
        press_with_control(page, "z")
        await_text(page, "1 erased; map_edited", "and undo once more")
        click(page, "edit_turn")
        await_text(page, "turned by -?[0-9.]+°; map_edited", "a button turns it to the walls")
        seen = page.run(EDITS)
        turn_rad = math.radians(seen["told"]["edits"]["turn_deg"])
        check(abs(turn_rad + seen["turn_rad"]) < 1e-4 and abs(abs(turn_rad) - math.radians(20)) < math.radians(0.5),
              f"by what the robot began aslant, and the view turns along: {seen['told']['edits']['turn_deg']}")
        check(page.run(DRAWN_EDITS) > 5000, "what is edited is drawn")
        check("map_edited.tar" in seen["files"], "it is among the downloads")
        check_download(seen["link"], results, read_png)
        page.picture("edits_dark")
        click(page, "theme")
        page.run("drawn().then(arguments[0]);")
        page.picture("edits_light")
        check(page.errors() == [], "the console has no errors")
        page.driver.refresh()
        await_that(lambda: page.state()["version"] > 0, "the page is loaded again")
        press(page, "e")
        await_text(page, "^cropped, 1 erased, turned by .*map_edited", "and knows what is edited")
    test_who_may(results)
    test_phone(results)
    with Viewer(results) as page:
        press(page, "e")
        await_text(page, "^cropped", "another viewer knows it too")
        click(page, "edit_reset")
        await_text(page, "Nothing is changed", "reset leaves the map alone")
        await_that(lambda: not list(results.glob("*edit*")), "and removes what was made of it")
        click(page, "edit_undo")
        await_text(page, "^cropped, 1 erased, turned by .*map_edited", "which can be undone")
        (results / "map_edited.yaml").unlink()
        (results / "map_edited.png").unlink()
        results.chmod(0o555)
        try:
            click(page, "edit_turn")
            await_text(page, "cannot write|map_edited.png is beside", "where nothing can be written the page says so")  # root can
        finally:
            results.chmod(0o755)
    check(hashlib.sha256((results / "map.png").read_bytes()).hexdigest() == before, "the map itself is as it was")


def test_who_may(results):
    """Who has only the link for looking changes nothing."""
    port = free_port(socket.SOCK_STREAM)
    viewer = subprocess.Popen([BIN / "map_viewer", results, "--http", f"0.0.0.0:{port}"], stderr=subprocess.PIPE, text=True)
    page = None
    try:
        said = ""
        while "ready" not in said:
            said += viewer.stderr.readline()
        whole = re.search(r"map_viewer: http://\S*#token=([0-9a-f]{32})\s", said)[1]
        looks = re.search(r"map_viewer: to look, and change nothing: http://\S*#token=([0-9a-f]{16})\s", said)[1]
        written = (results / "edits.json").read_bytes()
        page = Browser(f"http://127.0.0.1:{port}/#token={looks}")
        await_that(lambda: page.state()["version"] > 0, "who may only look sees the map")
        press(page, "e")
        seen = page.run(EDITS)
        check(seen["looks"] and seen["open"] and "map_edited.tar" in seen["files"], "and what was made is there to take along")
        check(seen["text"].startswith("cropped, 1 erased, turned") and "this browser keeps it" in seen["text"],
              f"what this one edits only the browser keeps: {seen['text']}")
        click(page, "edit_turn")
        await_text(page, "^cropped, 1 erased; this browser", "another edit")
        link = page.run(EDITS)["link"]
        check(json.loads(urllib.parse.unquote(link.split(",", 1)[1]))["turn_deg"] == 0, "is a file for slam_eval export --edits")
        page.driver.refresh()
        await_that(lambda: page.state()["version"] > 0, "loaded again")
        press(page, "e")
        await_text(page, "^cropped, 1 erased; this browser", "it is there")
        page.driver.execute_script("""
            for (const key of Object.keys(localStorage).filter((key) => key.startsWith('edits'))) {
              localStorage.setItem(key, '{"erase": [{"outline_m": [[null, "<img>"]]}], "turn_deg": 0}');
            }""")
        click(page, "edit_done")
        page.driver.refresh()
        await_that(lambda: page.state()["version"] > 0, "loaded once more")
        press(page, "e")
        await_text(page, "^cropped, 1 erased, turned", "edits that somebody has spoilt are none")
        check((results / "edits.json").read_bytes() == written, "beside the map nothing has changed")
        page.run("""
            const callback = arguments[0];
            import('/main.js').then(({robots}) => {
              const {socket} = robots[0].connection;
              socket.addEventListener('close', () => callback());
              socket.send('edits {}');
            });""")
        check((results / "edits.json").read_bytes() == written, "one who tries it nevertheless is sent away")
        page.driver.get("about:blank")
        page.driver.get(f"http://127.0.0.1:{port}/#token={whole}")
        await_that(lambda: page.state()["version"] > 0, "who has the whole link")
        press(page, "e")
        await_text(page, "^cropped, 1 erased, turned by .*map_edited", "may edit it")
    finally:
        if page:
            page.driver.quit()
        viewer.send_signal(signal.SIGINT)
        viewer.wait(PATIENCE_S)


def test_phone(results):
    http = f"127.0.0.1:{free_port(socket.SOCK_STREAM)}"
    viewer = subprocess.Popen([BIN / "map_viewer", results, "--http", http], stderr=subprocess.DEVNULL)
    page = Browser("about:blank", "412,915")
    try:
        await_that(lambda: socket.socket().connect_ex(("127.0.0.1", int(http.rsplit(":", 1)[1]))) == 0, "on a phone")
        page.driver.get(f"http://{http}/")
        await_that(lambda: page.state()["version"] > 0, "the run is shown")
        for theme in ("dark", "light"):
            page.driver.execute_script("""
                document.documentElement.dataset.theme !== arguments[0] && document.getElementById('theme').click();
                document.getElementById('edit_form').hidden && document.getElementById('edit').click();
                document.getElementById('fit').click();""", theme)
            page.run("drawn().then(arguments[0]);")
            page.picture(f"edits_phone_{theme}")
        box = page.driver.execute_script("""
            const {left, right, top, bottom} = document.getElementById('edit_form').getBoundingClientRect();
            const player = document.getElementById('player').getBoundingClientRect();
            const low = [...document.querySelectorAll('#edit_form button, #edit_form a, #edit_form select')].filter(
                (element) => element.checkVisibility() && element.getBoundingClientRect().height < 44).map(({id}) => id);
            return {fits: left >= 0 && right <= innerWidth && top >= 0, above: bottom <= player.top && top > innerHeight / 2 - 60, low};""")
        check(box == {"fits": True, "above": True, "low": []}, f"the form leaves half of the screen to the map, and is large enough for a finger: {box}")
        check(page.errors() == [], "the console has no errors")
    finally:
        page.driver.quit()
        viewer.send_signal(signal.SIGINT)
        viewer.wait(PATIENCE_S)
