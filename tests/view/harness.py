"""What the tests of the page share: processes on a bus of their own, and a browser that looks at them."""

import contextlib
import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import time

from browser import open_chromium

PATIENCE_S = 90
BIN = pathlib.Path(sys.argv[1]).resolve()
PICTURES = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else None

# For every script: `await drawn()` comes back when all that was told before is drawn, and the badges are of it.
DRAWN = """
const drawn = () => new Promise((then) => setTimeout(() => requestAnimationFrame(() => requestAnimationFrame(then)), 300));
"""

# What the page knows of its first robot.
STATE = """
const callback = arguments[0];
import('/main.js').then(({robots}) => {
  const {model} = robots[0];
  callback({connected: model.connected, version: Number(model.cursor.version), epoch: String(model.cursor.epoch),
            x_m: model.robot && model.robot.x_m, y_m: model.robot && model.robot.y_m, tiles: model.map.tiles.size,
            loops: Number(document.getElementById('loops').textContent), path: model.path.length,
            services: model.info.services.length, state: document.getElementById('state').textContent,
            why: document.getElementById('why').textContent,
            toast: document.getElementById('toast').textContent});
});
"""


def check(holds, what):
    if not holds:
        raise AssertionError(what)
    print(f"  {what}", flush=True)


def await_that(condition, what):
    give_up = time.monotonic() + PATIENCE_S
    while not condition():
        if time.monotonic() > give_up:
            raise AssertionError(f"not in {PATIENCE_S} s: {what}")
        time.sleep(0.05)
    print(f"  {what}", flush=True)


def free_port(kind):
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Stack:
    """Processes on a bus of their own. Each can be killed and started again."""

    def __init__(self, out):
        self.out = out
        self.url = f"udpm://239.255.76.67:{free_port(socket.SOCK_DGRAM)}?ttl=0"
        self.http = f"127.0.0.1:{free_port(socket.SOCK_STREAM)}"
        self.processes = {}

    def start(self, name, *flags):
        log = open(self.out / f"{name}.log", "a+", encoding="utf-8")
        began = log.seek(0, os.SEEK_END)
        process = subprocess.Popen([BIN / name, *flags, "--lcm-url", self.url], stdin=subprocess.DEVNULL, stdout=log,
                                   stderr=log)
        self.processes[name] = process

        def is_ready():
            log.seek(began)
            return f"{name}: ready" in log.read()
        await_that(is_ready, f"{name} is ready")

    def start_all(self):
        self.start_updater()
        for name in ("loop_closer", "ray_selector", "rrhc_matcher"):
            self.start(name)
        self.start("map_exporter", "--out", self.out, "--export-period-s", "0.5")
        self.start_viewer()

    def start_updater(self, *flags):
        self.start("map_updater", "--journal", self.out / "journal", *flags)

    def start_viewer(self):
        self.start("map_viewer", "--http", self.http)

    def kill(self, name):
        self.processes[name].kill()
        self.processes[name].wait()

    def end(self):
        for process in self.processes.values():
            with contextlib.suppress(ProcessLookupError):
                process.send_signal(signal.SIGINT)
        for process in self.processes.values():
            process.wait(PATIENCE_S)


class Browser:
    def __init__(self, url, size="1440,960"):
        self.driver = open_chromium(size, "--disable-gpu", logs={"browser": "ALL", "performance": "ALL"})
        self.driver.set_script_timeout(30)
        self.driver.get(url)

    def run(self, script, *arguments):
        return self.driver.execute_async_script(DRAWN + script, *arguments)

    def state(self):
        return self.run(STATE)

    def errors(self):
        """What the console has of errors, once the page is drawn, but for connections to a viewer that was killed."""
        self.run("drawn().then(arguments[0]);")
        return [entry["message"] for entry in self.driver.get_log("browser")
                if entry["level"] == "SEVERE" and "WebSocket connection to" not in entry["message"]
                and "ERR_CONNECTION_REFUSED" not in entry["message"]]

    def asked_for(self):
        """All addresses that the page has asked for something."""
        addresses = set()
        for entry in self.driver.get_log("performance"):
            message = json.loads(entry["message"])["message"]
            if message["method"] == "Network.requestWillBeSent":
                addresses.add(message["params"]["request"]["url"])
            elif message["method"] == "Network.webSocketCreated":
                addresses.add(message["params"]["url"])
        return addresses

    def picture(self, name):
        if PICTURES:
            PICTURES.mkdir(parents=True, exist_ok=True)
            self.driver.save_screenshot(str(PICTURES / f"{name}.png"))
