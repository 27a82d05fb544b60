"""A browser driven over WebDriver (W3C), with nothing but the standard library: Debian's chromium and chromium-driver."""

import base64
import json
import os
import re
import shutil
import struct
import subprocess
import time
import urllib.error
import urllib.request
import zlib

ELEMENT = "element-6066-11e4-a52e-4f735466cecf"
PATIENCE = float(os.environ.get("TAUT_PATIENCE", "1")) # times as long as elsewhere for all that is waited for: sanitizers are slow
KEYS = {"left": "\ue012", "up": "\ue013", "right": "\ue014", "down": "\ue015", "shift": "\ue008", "ctrl": "\ue009", "alt": "\ue00a",
        "tab": "\ue004", "enter": "\ue007"}


def missing():
    """What is not installed of what a test needs; empty: nothing."""
    return [name for name in ("chromium", "chromedriver") if shutil.which(name) is None]


class Browser:
    def __init__(self, folder, width=1280, height=900):
        self.driver = subprocess.Popen(["chromedriver", "--port=0"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        port = None
        for line in self.driver.stdout:
            if match := re.search(r"started successfully on port (\d+)", line):
                port = match[1]
                break
        self.base = f"http://127.0.0.1:{port}"
        options = ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                   "--hide-scrollbars", f"--window-size={width},{height}", f"--user-data-dir={folder}/profile", "--no-first-run",
                   "--disable-background-networking", "--disable-extensions", "--lang=en"]
        asked = {"capabilities": {"alwaysMatch": {"goog:chromeOptions": {"binary": shutil.which("chromium"), "args": options},
                                                  "goog:loggingPrefs": {"browser": "ALL"}}}}
        self.session = self.ask("POST", "/session", asked)["sessionId"]

    def close(self):
        try:
            self.call("DELETE", "")
        finally:
            self.driver.terminate()
            self.driver.wait()

    def ask(self, method, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.base + path, data=data, method=method, headers={"Content-Type": "application/json"})
        try:
            with urllib.request.urlopen(request, timeout=180 * PATIENCE) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            raise AssertionError(f"{method} {path}: {error.read().decode()[:500]}") from None

    def call(self, method, path, body=None):
        return self.ask(method, f"/session/{self.session}{path}", body)

    def open(self, url):
        self.call("POST", "/url", {"url": url})

    def run(self, script, *arguments):
        """The value of a function body, which may be a promise."""
        return self.call("POST", "/execute/sync", {"script": script, "args": list(arguments)})

    def until(self, script, *arguments, seconds=90):
        """Waits until it is true, and returns it."""
        seconds *= PATIENCE
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if value := self.run(script, *arguments):
                return value
            time.sleep(0.1)
        raise AssertionError(f"not within {seconds} s: {script}")

    def find(self, css):
        return self.call("POST", "/element", {"using": "css selector", "value": css})[ELEMENT]

    def all(self, css):
        return [e[ELEMENT] for e in self.call("POST", "/elements", {"using": "css selector", "value": css})]

    def click(self, css):
        self.call("POST", f"/element/{self.find(css)}/click", {})

    def name_of(self, element):
        """As assistive technology hears it."""
        return self.call("GET", f"/element/{element}/computedlabel")

    def press(self, *keys, focus="#picture"):
        """Keys one after the other; "shift+left" together."""
        if focus:
            self.run("document.querySelector(arguments[0]).focus()", focus)
        actions = []
        for chord in keys:
            parts = [KEYS.get(part, part) for part in (chord.split("+") if len(chord) > 1 else [chord])]
            actions += [{"type": "keyDown", "value": part} for part in parts] + [{"type": "keyUp", "value": part} for part in reversed(parts)]
        self.call("POST", "/actions", {"actions": [{"type": "key", "id": "keys", "actions": actions}]})

    def drag(self, *fingers, kind="mouse", css="#picture", steps=4):
        """Each finger from (x0, y0) to (x1, y1), shares of an element's size."""
        box = self.run("const b = document.querySelector(arguments[0]).getBoundingClientRect(); return [b.left, b.top, b.width, b.height]", css)
        at = lambda x, y: {"x": round(box[0] + x * box[2]), "y": round(box[1] + y * box[3])}
        sequences = []
        for i, (x0, y0, x1, y1) in enumerate(fingers):
            moves = [{"type": "pointerMove", "duration": 0, **at(x0, y0)}, {"type": "pointerDown", "button": 0}]
            for k in range(1, steps + 1):
                moves.append({"type": "pointerMove", "duration": 50, **at(x0 + (x1 - x0) * k / steps, y0 + (y1 - y0) * k / steps)})
            moves.append({"type": "pointerUp", "button": 0})
            sequences.append({"type": "pointer", "id": f"finger{i}", "parameters": {"pointerType": kind}, "actions": moves})
        self.call("POST", "/actions", {"actions": sequences})
        self.call("DELETE", "/actions")

    def devtools(self, command, **parameters):
        return self.call("POST", "/goog/cdp/execute", {"cmd": command, "params": parameters})

    def screenshot(self, path):
        with open(path, "wb") as file:
            file.write(base64.b64decode(self.call("GET", "/screenshot")))

    def complaints(self):
        """Errors that the page left on the console since the last call."""
        return [e["message"] for e in self.call("POST", "/se/log", {"type": "browser"}) if e["level"] == "SEVERE"]


def read_png(path):
    """Width, height and RGB bytes of an 8-bit PNG without interlacing."""
    with open(path, "rb") as file:
        data = file.read()
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", body[:10])
        if kind == b"IDAT":
            packed += body
        at += size + 12
    assert depth == 8 and colour in (2, 6), (depth, colour)
    step = 3 if colour == 2 else 4
    raw, out, above = zlib.decompress(packed), bytearray(), bytearray(width * step)
    for y in range(height):
        start = y * (width * step + 1)
        how, row = raw[start], bytearray(raw[start + 1:start + 1 + width * step])
        for i in range(len(row)):
            a = row[i - step] if i >= step else 0
            b, c = above[i], above[i - step] if i >= step else 0
            p = a + b - c
            paeth = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            row[i] = (row[i] + (0, a, b, (a + b) // 2, paeth)[how]) & 255
        above = row
        out += bytes(row[i] for i in range(len(row)) if i % step < 3)
    return width, height, bytes(out)
