#!/usr/bin/env python3
"""Films the page of map_viewer while a stack maps a log: an animated WebP.

usage: tests/view/film.py BIN_DIR LOG|sim:NAME FILM.webp [--rate N] [--frames N] [FLAGS...]
  --rate N     how much faster than the log, 20 by default
  --frames N   pictures at most, 80 by default, spread over the run
  FLAGS        of run_stack, as --preset sick
"""

import argparse
import io
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time

try:
    from browser import open_chromium
    from PIL import Image
except ImportError:
    sys.exit("film: needs python3-selenium and python3-pil, see scripts/setup --view")

WINDOW = "1280,860"  # of which the page has a little less
WIDTH = 960  # of the film
FRAME_MS = 125
LAST_MS = 3000  # the finished map stays
EVERY_S = 0.25
# The whole map is in view; says whether the viewer is still there.
FIT = """
const callback = arguments[0];
import('/main.js').then(({robots}) => {
  robots[0].view.fit();
  callback(robots[0].model.connected);
});
"""


def open_browser():
    browser = open_chromium(WINDOW)
    dark = {"name": "prefers-color-scheme", "value": "dark"}
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [dark]})
    return browser


def take_picture(browser):
    picture = Image.open(io.BytesIO(browser.get_screenshot_as_png())).convert("RGB")
    return picture.resize((WIDTH, WIDTH * picture.height // picture.width), Image.LANCZOS)


def await_address(log, patience_s=30):
    """The address that run_stack says."""
    give_up = time.monotonic() + patience_s
    while time.monotonic() < give_up:
        found = re.search(r"the map is at (\S+)", log.read_text(errors="replace"))
        if found:
            return found[1]
        time.sleep(0.1)
    sys.exit(f"film: run_stack said no address within {patience_s} s:\n{log.read_text(errors='replace')}")


def film(browser, stack, log):
    """Pictures of the page until the stack has mapped everything, and only shows the finished map."""
    pictures = []
    while stack.poll() is None and "the map stays at" not in log.read_text(errors="replace"):
        began = time.monotonic()
        if browser.execute_async_script(FIT):
            pictures.append(take_picture(browser))
        time.sleep(max(0.0, EVERY_S - (time.monotonic() - began)))
    return pictures


def main():
    parser = argparse.ArgumentParser(prog="film", allow_abbrev=False)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("log")
    parser.add_argument("film", type=pathlib.Path)
    parser.add_argument("--rate", default="20")
    parser.add_argument("--frames", type=int, default=80)
    arguments, flags = parser.parse_known_args()
    with tempfile.TemporaryDirectory() as folder:
        said = pathlib.Path(folder) / "run_stack.log"
        with open(said, "w", encoding="utf-8") as log:
            stack = subprocess.Popen([arguments.bin / "run_stack", arguments.log, "--out", f"{folder}/out", "--rate",
                                      arguments.rate, "--view", "--http", "127.0.0.1:0", *flags],
                                     stdout=log, stderr=log)
        try:
            browser = open_browser()
            browser.get(await_address(said))
            pictures = film(browser, stack, said)
            browser.quit()
        finally:
            stack.send_signal(signal.SIGTERM)  # which ends it also while it shows the finished map
            stack.wait()
    if not pictures:
        sys.exit("film: the run ended before there was a picture; a smaller --rate helps")
    step = max(1.0, len(pictures) / arguments.frames)
    chosen = [pictures[int(i * step)] for i in range(int(len(pictures) / step))] + [pictures[-1]]
    durations = [FRAME_MS] * (len(chosen) - 1) + [LAST_MS]
    chosen[0].save(arguments.film, save_all=True, append_images=chosen[1:], duration=durations, loop=0, quality=70,
                   method=4)
    print(f"{arguments.film}: {len(chosen)} pictures, {arguments.film.stat().st_size / 1e6:.1f} MB")


main()
