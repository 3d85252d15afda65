"""Runs `camring design` as a person does, and looks at its page in the browser that is installed."""

import json
import os
import re
import subprocess
import sys
import urllib.parse
from contextlib import contextmanager

from playwright.sync_api import sync_playwright
from websockets.sync.client import connect

from tests.support.browser import FLAGS, PATIENCE, browser_path

# Of any two cameras [mm].
SEPARATION = 6.0
# Without it every frame of the page waits for a drawing of the surface by the processor.
SOFTWARE = [*FLAGS, "--disable-gpu-compositing"]


class Served:
    """A running server: its address, and the folder in which it keeps sessions."""

    def __init__(self, folder, arguments):
        environment = os.environ | {"XDG_STATE_HOME": str(folder), "XDG_CACHE_HOME": str(folder / "cache")}
        command = [sys.executable, "-m", "camring", "design", *map(str, arguments), "--no-browser"]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        self.process = subprocess.Popen(command, env=environment, **pipes)
        said = "".join(self.process.stdout.readline() for _ in range(3 if "--json" in arguments else 1))
        assert said, self.process.stderr.read()
        self.address = json.loads(said)["address"] if "--json" in arguments else said.strip()
        self.parts = urllib.parse.urlsplit(self.address)
        self.folder = folder

    @property
    def origin(self):
        return f"http://{self.parts.netloc}"

    def kept(self):
        """The session as it is kept, and when it was written."""
        (path,) = self.folder.glob("camring/designs/*/session.json")
        return json.loads(path.read_text(encoding="utf-8")), path.stat().st_mtime_ns

    @contextmanager
    def socket(self, **more):
        address = f"ws://{self.parts.netloc}{self.parts.path}live"
        with connect(address, origin=self.origin, max_size=None, open_timeout=60, **more) as socket:
            yield socket

    def end(self):
        """Ask it to end; its exit status and what it said."""
        self.process.terminate()  # an interrupt is ignored by what a shell has started in the background
        _, said = self.process.communicate(timeout=60)
        return self.process.returncode, said


@contextmanager
def served(folder, *arguments):
    server = Served(folder, arguments)
    try:
        yield server
    finally:
        if server.process.poll() is None:
            server.process.kill()
        server.process.communicate()


def heard(socket, kind, fits=lambda message: True, seconds=60):
    """The next message of a kind that fits."""
    while True:
        message = socket.recv(timeout=seconds)
        message = {"kind": "surface", "content": message} if isinstance(message, bytes) else json.loads(message)
        if message["kind"] == kind and fits(message):
            return message


def is_known(state):
    return state["exact"]["is_whole"] and state["equidistant"] is not None


class Looked:
    """A window on the page; `faults` are what its console complains of, `requests` what it asks for."""

    def __init__(self, browser, address, width=1280, height=900, **more):
        self.page = browser.new_page(viewport={"width": width, "height": height}, **more)
        self.faults, self.requests = [], []
        self.page.on("console", self._noted)
        self.page.on("pageerror", lambda error: self.faults.append(str(error)))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.on("websocket", lambda socket: self.requests.append(socket.url))
        self.page.goto(address)
        self.known()
        self.page.wait_for_selector("#surface[data-triangles]", timeout=PATIENCE)

    def _noted(self, message):
        # Chromium warns of the processor that stands in for a graphics card.
        if message.type == "error" or (message.type == "warning" and "GPU stall" not in message.text):
            self.faults.append(message.text)

    def known(self):
        """Wait until all numbers of what is looked at are known."""
        self.page.wait_for_timeout(100)
        self.page.wait_for_selector("html[data-numbers=known]", timeout=PATIENCE)

    def number(self, name):
        return self.page.inner_text(f"#{name}")

    def angles(self):
        fields = self.page.locator("#cameras input[type=number]")
        return [float(fields.nth(i).input_value()) for i in range(fields.count())]

    def centre(self, selector, nth=0):
        box = self.page.locator(selector).nth(nth).bounding_box()
        return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def said(self):
        self.page.wait_for_selector("#said:not([hidden])", timeout=PATIENCE)
        return self.page.inner_text("#said")


@contextmanager
def browsing():
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=browser_path(), args=SOFTWARE)
        yield browser
        browser.close()


def evaluated(camring, mesh, *arguments):
    """What `camring evaluate` prints: the reconstructable area and the RMS error, as they stand there."""
    status, printed, said = camring("evaluate", mesh, *arguments)
    assert status == 0, said
    return (
        re.search(r"reconstructable area: (\S+) mm²", printed)[1],
        re.search(r"RMS (\S+) mm", printed)[1],
    )  # fmt: skip
