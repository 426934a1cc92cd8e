"""What has moved since a map was made: the list of it, and the way to each thing."""

import json
import subprocess

from harness import BIN, check
from pieces import Viewer

# Callback: the rows of the list; where the middle of the map that is seen lies before and after a click on the first one;
# and whether the robot is still followed.
LIST = """
const callback = arguments[0];
import('/main.js').then(async ({robots}) => {
  await drawn();
  const {view} = robots[0];
  const middle = () => [view.camera.x_m, view.camera.y_m];
  const rows = [...document.querySelectorAll('#changes button')];
  const before = middle();
  rows[0]?.click();
  await drawn();
  callback({rows: rows.map((row) => row.textContent), shown: !document.getElementById('changes').parentElement.hidden,
            before, after: middle(), follows: view.follows});
});
"""


def test_changes(out):
    """out / finished: a run of sim:demo."""
    text = subprocess.run([BIN / "slam_eval", "world", "demo"], check=True, capture_output=True, text=True).stdout
    world, results = out / "moved.world", out / "moved"
    world.write_text(text.replace("box 11 2 0.5 0.5", "box 12.4 2.9 0.4 0.4"))  # a table, into a corner
    check(world.read_text() != text, "a table of sim:demo is moved")
    subprocess.run([BIN / "slam_offline", f"sim:{world}", "--seed", "5", "--localize", out / "finished", "--out", results],
                   check=True, capture_output=True)
    changes = json.loads((results / "summary.json").read_text())["changes"]
    check({change["kind"] for change in changes} == {"new", "gone"}, f"it has gone, and it is new: {changes}")
    with Viewer(results) as page:
        seen = page.run(LIST)
        check(seen["shown"] and len(seen["rows"]) == len(changes), f"the page lists both: {seen}")
        check(all(row.startswith(change["kind"]) for row, change in zip(seen["rows"], changes)), "the largest first")
        there = [changes[0]["x_m"], changes[0]["y_m"]]
        off = max(abs(a - b) for a, b in zip(seen["after"], there))
        check(off < 5 and seen["after"] != seen["before"] and not seen["follows"], f"a click goes there: {seen}, {there}")
        page.picture("changes")
    with Viewer(out / "finished") as page:
        check(not page.run(LIST)["shown"], "a run that made its map has no such list")
