"""A map in pieces: what floats is not lost, and each piece can be looked at."""

import json
import pathlib
import signal
import socket
import subprocess
import tempfile

from harness import BIN, PATIENCE_S, Browser, Stack, await_that, check, free_port

# Goes to a scan, and shows what is known of it before the viewer tells more. Callback: what is told of it then, and once
# all of it has come: the badge, the words beside it, and the degenerate direction.
BADGES = """
const [number, callback] = arguments;
import('/main.js').then(async ({robots, player}) => {
  const {model} = robots[0];
  const text = (id) => document.getElementById(id).textContent;
  model.scan = null;
  const {take_robot} = model;
  model.take_robot = () => {};
  player.goTo(number);
  await drawn();
  const before = {state: text('state'), why: text('why'), axis: model.robot.axis};
  model.take_robot = take_robot;
  player.goTo(number);
  const soon = async (tries) => {
    if (!(model.scan && model.timeline.isAt(model.scan)) && tries > 0) return setTimeout(() => soon(tries - 1), 20);
    await drawn();
    callback({before, then: {state: text('state'), why: text('why'), axis: model.robot.axis}});
  };
  soon(100);
});
"""

# Callback: how many scans there are, how many of the time line are in each state, what the tiles and the pieces say, and
# what there is to download.
COUNTS = """
const callback = arguments[0];
Promise.all([import('/main.js'), import('/wire.js')]).then(async ([{robots}, {STATES}]) => {
  await drawn();
  const {timeline} = robots[0].model;
  const states = {};
  timeline.state.forEach((state) => { states[STATES[state]] = (states[STATES[state]] ?? 0) + 1; });
  const tiles = {};
  for (const output of document.querySelectorAll('.tiles output')) {
    tiles[output.id] = Number(output.textContent.replaceAll(',', ''));
  }
  callback({num: timeline.num, states, tiles,
            degenerate: [...timeline.state.keys()].filter((scan) => timeline.stateOf(scan) === 'DEGENERATE'),
            pieces: [...document.querySelectorAll('#pieces li')].map((row) => row.textContent), hash: location.hash,
            files: Object.fromEntries([...document.querySelectorAll('#files a')].map((link) => [
                link.children[0].textContent, link.children[1].textContent]))});
});
"""


KNOWS_THEN = "import('/main.js').then(({robots}) => arguments[0](robots[0].model.info.knows_then));"

# Goes to a scan, and shows what was known then. Callback: how the page says that it was.
THEN = """
const [number, callback] = arguments;
import('/main.js').then(async ({robots, player}) => {
  const {model} = robots[0];
  if (!model.wants_then) document.getElementById('then').click();
  await drawn();
  player.goTo(number);
  await new Promise((told) => model.addEventListener('then', told, {once: true}));
  await drawn();
  callback({state: document.getElementById('state').textContent, area: model.map.area_m2(), way_m: model.factsThen().way_m,
            verdict: document.getElementById('verdict').textContent,
            tiles: Object.fromEntries([...document.querySelectorAll('.tiles output')].map(
                ({id, textContent}) => [id, Number(textContent.replaceAll(',', ''))]))});
});
"""


class Viewer:
    """Of a folder of results, with a page."""

    def __init__(self, results):
        http = f"127.0.0.1:{free_port(socket.SOCK_STREAM)}"
        self.process = subprocess.Popen([BIN / "map_viewer", results, "--http", http], stderr=subprocess.DEVNULL)
        self.page = Browser("about:blank")
        await_that(lambda: socket.socket().connect_ex(("127.0.0.1", int(http.rsplit(":", 1)[1]))) == 0,
                   f"{results.name} is shown")
        self.page.driver.get(f"http://{http}/#map=last")
        await_that(lambda: self.page.state()["version"] > 0, "and its map is there")

    def __enter__(self):
        return self.page

    def __exit__(self, *_):
        self.page.driver.quit()
        self.process.send_signal(signal.SIGINT)
        self.process.wait(PATIENCE_S)


def test_pieces(out, compare_with_picture):
    """Two buildings: the second one is larger, and shown; the first one floats."""
    results = out / "in_pieces"
    subprocess.run([BIN / "slam_offline", "sim:demo", "sim:block", "--out", results], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    summary = json.loads((results / "summary.json").read_text())
    shown, floats = (piece["scans"] for piece in summary["pieces"]["largest_first"])
    with Viewer(results) as page:
        counts = page.run(COUNTS)
        check(counts["states"]["FLOATING"] == floats and "LOST" not in counts["states"],
              f"{floats} scans float, and none of them is lost: {counts['states']}")
        named = {name: summary[name] for name in ("scans", "lost", "floating", "without_rays", "left_out")}
        check({name: counts["tiles"][name] for name in named} == named, f"the tiles have summary.json's numbers: {named}")
        check(counts["pieces"] == [f"piece 1, shown{shown:,} scans · {summary['pieces']['largest_first'][0]['way_m']:.0f} m{results}",
                                   f"piece 2{floats:,} scans · {summary['pieces']['largest_first'][1]['way_m']:.0f} m{results}/pieces/2"],
              f"the pieces are named, and where they lie: {counts['pieces']}")
        seen = page.run(BADGES, 1000)
        for when in ("before", "then"):
            check(seen[when]["state"] == "FLOATING" and "on another piece" in seen[when]["why"],
                  f"a scan of the other piece floats: {seen[when]['why']}")
        page.picture("floating")
        await_that(lambda: page.run(KNOWS_THEN), "what was known then is read")
        then = page.run(THEN, floats - 1)
        check(then["state"] == "OK" and then["tiles"]["floating"] == 0 and then["tiles"]["scans"] == floats and then["verdict"] == "",
              f"what floats at the end was the map then, and there was no verdict: {then}")
        alone = results.parent / "alone"
        subprocess.run([BIN / "slam_offline", "sim:demo", "--out", alone], check=True, capture_output=True)
        facts = json.loads((alone / "summary.json").read_text())
        for name, wanted, off in (("area", facts["explored_area_m2"], 0.01), ("way_m", facts["path_length_m"], 0.05)):  # the path jitters
            check(abs(then[name] - wanted) < off * wanted, f"it is that of a run that ended there: {name} {then[name]:.1f}, {wanted:.1f}")
        check(then["tiles"]["loops"] == facts["loops"]["closed"], f"with its loops: {facts['loops']}")
        page.picture("then")
        early = page.run(THEN, floats // 4)
        check(early["area"] < 0.9 * then["area"] and early["way_m"] < 0.5 * then["way_m"], f"and before it was smaller: {early}")
        page.driver.find_element("id", "then").click()
        compare_with_picture(page, results / "map.png")
        counts = page.run(COUNTS)
        check({name: counts["tiles"][name] for name in named} == named, "one click away is the last map, with its numbers")
        check(len(counts["degenerate"]) > 10, "some scans are degenerate")
        for scan in counts["degenerate"][::15]:
            seen = page.run(BADGES, scan)
            before, then = seen["before"], seen["then"]
            check(before["state"] == then["state"] != "DEGENERATE" and abs(
                before["axis"]["x"] * then["axis"]["y"] - before["axis"]["y"] * then["axis"]["x"]) < 1e-3,
                  f"their direction is known while the run is played: {before['state']}")
        check(counts["files"]["map.pgm"] == "map, for tools that read no PNG" and "map.png" in counts["files"]["map.yaml"],
              "what map_server reads is called so")
        for piece, folder, num in ((2, results / "pieces/2", floats), (1, results, shown + floats)):
            page.driver.find_element("css selector", "#pieces button").click()
            await_that(lambda: f"piece {piece}, shown" in " ".join(page.run(COUNTS)["pieces"]), f"a click shows piece {piece}")
            compare_with_picture(page, folder / "map.png")
            counts = page.run(COUNTS)
            check(counts["num"] == num and f"piece={piece}" in counts["hash"] and ("summary.json" in counts["files"]) == (piece == 1),
                  f"with its {num} scans, a link, and its own files: {counts['hash']}")
        link = page.driver.current_url.split("#")[0]
        for piece, state in ((9, "no such piece"), (2, "FINISHED")):
            page.driver.get("about:blank")
            page.driver.get(f"{link}#piece={piece}")
            await_that(lambda: page.state()["state"] == state, f"a link to piece {piece}: {state}")
        check("piece 2, shown" in " ".join(page.run(COUNTS)["pieces"]), "shows it")
        check([error for error in page.errors() if "404" not in error] == [], "the console has no errors")
    with Viewer(results / "pieces/2") as page:
        compare_with_picture(page, results / "pieces/2/map.png")
        counts = page.run(COUNTS)
        check(counts["num"] == counts["tiles"]["scans"] == floats and "FLOATING" not in counts["states"],
              f"a piece is shown with its {floats} scans")
        check("piece 2, shown" in counts["pieces"][1], f"and is named: {counts['pieces']}")
        check(sorted(counts["files"]) == ["map.pgm", "map.png", "map.yaml", "trajectory.tum"], "and hands out its files")
        check("no verdict: this is piece 2" in page.state()["why"], "and says that the verdict is of another one")
        page.picture("piece")
        check(page.errors() == [], "the console has no errors")


def test_another_piece():
    """Live: the robot is carried into another building, whose map becomes the larger one."""
    with tempfile.TemporaryDirectory(prefix="crsm_view_") as folder:
        stack = Stack(pathlib.Path(folder))
        browser = None
        try:
            stack.start_updater()
            for name in ("ray_selector", "rrhc_matcher"):
                stack.start(name)
            stack.start_viewer()
            browser = Browser(f"http://{stack.http}/")
            stack.start("laser_publisher", "sim:demo", "--rate", "8")
            await_that(lambda: browser.state()["path"] > 100, "a building is mapped")
            stack.kill("laser_publisher")
            stack.start("laser_publisher", "sim:block", "--rate", "8")
            await_that(lambda: browser.state()["state"] == "FLOATING", "another one floats at first")
            await_that(lambda: "another piece is the larger one now and is shown" in browser.state()["toast"],
                       "and is shown when it is the larger one, which is said")
            await_that(lambda: browser.state()["state"] == "ANOTHER PIECE", "and is not called OK")
            browser.picture("another_piece")
            check(browser.errors() == [], "the console has no errors")
        finally:
            if browser:
                browser.driver.quit()
            stack.end()
