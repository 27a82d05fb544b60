"""The page of `taut view` in a headless browser: what a hand does on it, and that its pixels are those of `taut render`.

    page_test.py TAUT FOLDER      leaves screenshots in FOLDER; exit code 77 where there is no browser
"""

import base64
import json
import math
import os
import shutil
import subprocess
import sys
import time

import webdriver
from page_looks import Looks
from view_process import Server

SCENE = """[render]
width = 240
height = 160
spp = 4
max_events = 2
frames = "1-3"
[camera]
position = [0.1, -1.6, 1.8]
look_at = [0, 0, 0]
fov_deg = 45
[environment]
radiance = [0.15, 0.18, 0.2]
camera_visible = false
[[light]]
type = "quad"
corner = [-0.5, 0.8, 1]
u = [1, 0, 0]
v = [0, 0, 1]
radiance = [1, 1, 1]
two_sided = true
[material.brushed]
type = "conductor"
metal = "Al"
alpha = [0.1, 0.4]
[[mesh]]
file = "{meshes}/plate.obj"
material = "brushed"
[[mesh.deform]]
type = "shear"
plane = "xy"
amount = [[1, 0.0], [3, 1.2]]
"""
PIXELS = """const canvas = document.getElementById('picture');
const gl = canvas.getContext('webgl2');
const bytes = new Uint8Array(4 * canvas.width * canvas.height);
gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
let text = '';
for (const b of bytes) text += String.fromCharCode(b);
return [canvas.width, canvas.height, btoa(text)];"""
SHEAR = "plate, shear, keyed"


class Test(Looks):
    def __init__(self, taut, folder):
        self.taut, self.folder = taut, folder
        self.scene = f"{folder}/plate.toml"
        meshes = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "meshes")
        with open(self.scene, "w") as file:
            file.write(SCENE.replace("{meshes}", os.path.normpath(meshes)))
        self.browser = webdriver.Browser(folder)
        self.server = Server(taut, self.scene, "--token-file", f"{folder}/token")
        self.port = self.server.url.split("/")[2].split(":")[1]

    def settled(self, frame=1):
        """Waits until the picture is that of the newest change, whole, and nothing comes after it for a while."""
        end = time.monotonic() + 90 * webdriver.PATIENCE
        while time.monotonic() < end:
            before = self.server.get("state")["version"]
            time.sleep(0.6) # longer than the page waits for a hand to rest
            seen = self.browser.run("return {...document.getElementById('picture').dataset}")
            if seen["done"] == "true" and int(seen["version"]) == before == self.server.get("state")["version"]:
                assert int(seen["frame"]) == frame, seen
                return
        raise AssertionError(f"no whole picture: {seen}, version {before}")

    def pixels(self):
        """Of the canvas: width, height, rows of RGB from the top."""
        width, height, text = self.browser.run(PIXELS)
        data = base64.b64decode(text)
        rows = [data[4 * width * y:4 * width * (y + 1)] for y in reversed(range(height))]
        return width, height, [bytes(row[i] for i in range(len(row)) if i % 4 < 3) for row in rows]

    def rendered(self, *arguments, frame=1):
        output = f"{self.folder}/rendered.png"
        subprocess.run([self.taut, "render", *arguments, "-q", "--only", str(frame), "-o", f"{self.folder}/rendered.####.png"], check=True)
        os.replace(f"{self.folder}/rendered.{frame:04}.png", output)
        width, height, data = webdriver.read_png(output)
        return [data[3 * width * y:3 * width * (y + 1)] for y in range(height)]

    def check_same(self, seen, expected, left=0.0, right=1.0, levels=1):
        """Halves are rounded and so are 8 bits: one level apart at most."""
        width = len(expected[0]) // 3
        begin, end = 3 * round(left * width), 3 * round(right * width)
        worst = max(abs(a - b) for s, e in zip(seen, expected) for a, b in zip(s[begin:end], e[begin:end]))
        assert len(seen) == len(expected) and worst <= levels, f"pixels differ by {worst}"

    def opens(self):
        self.browser.open(self.server.url)
        self.browser.until("return Number(document.getElementById('picture').dataset.samples) > 0")
        self.settled()
        self.check_same(self.pixels()[2], self.rendered(self.scene))
        # Exposure is the page's own: a stop up, and the server hears nothing of it.
        before = self.server.get("state")["version"]
        self.browser.press("]", "]")
        brighter = self.pixels()[2]
        assert sum(map(sum, brighter)) > 1.05 * sum(map(sum, self.rendered(self.scene)))
        self.browser.press("[", "[")
        self.check_same(self.pixels()[2], self.rendered(self.scene))
        assert self.server.get("state")["version"] == before

    def frames(self):
        """Field of view and aperture by the keyboard."""
        self.browser.press(*["right"] * 5, focus="#fov")
        self.browser.press(*["right"] * 20, focus="#aperture")
        self.settled()
        camera = self.server.get("state")["camera"]
        assert abs(camera["fov_deg"] - 45.5) < 1e-6 and abs(camera["aperture_radius"] - 0.01) < 1e-9, camera
        change = self.server.get("state")["changes"][0]
        self.check_same(self.pixels()[2], self.rendered(self.scene, "-D", f"camera={change['text']}"))
        self.browser.click("#cameraBack")
        self.settled()

    def snapshots(self):
        """A on the left of the line, B on its right; what is rendered in between goes on beside them."""
        self.browser.press("a", ".")
        self.settled(2)
        self.browser.press("b", ".")
        self.settled(3)
        self.browser.press("c")
        seen = self.pixels()[2]
        self.check_same(seen, self.rendered(self.scene, frame=1), 0, 0.48)
        self.check_same(seen, self.rendered(self.scene, frame=2), 0.52, 1)
        self.browser.screenshot(f"{self.folder}/snapshots.png")
        self.browser.press("c", ",", ",")
        self.settled(1)

    def colours(self):
        """False colours at frame 3: the greatest and least stretch of a shear by k are (sqrt(k^2 + 4) +- k) / 2 everywhere."""
        for downs, stretch in ((1, (math.sqrt(1.44 + 4) + 1.2) / 2), (2, (math.sqrt(1.44 + 4) - 1.2) / 2)):
            self.browser.press(*["down"] * downs, focus="#channel")
            self.settled(3)
            text = self.browser.until("return document.getElementById('range').textContent")
            least, greatest = (float(part.split()[-1]) for part in text.split(","))
            assert abs(least - stretch) < 0.006 and abs(greatest - stretch) < 0.006, (text, stretch)
            self.browser.screenshot(f"{self.folder}/colours{downs}.png")
            self.browser.press(*["up"] * downs, focus="#channel")
            self.settled(3)
        self.check_same(self.pixels()[2], self.rendered(self.scene, frame=3))

    def orbits(self):
        before = self.server.get("state")["camera"]["position"]
        self.browser.press("left", "left", "up")
        self.settled()
        turned = self.server.get("state")["camera"]["position"]
        assert max(abs(a - b) for a, b in zip(before, turned)) > 0.05
        self.browser.drag((0.3, 0.5, 0.5, 0.6))
        self.settled()
        dragged = self.server.get("state")["camera"]["position"]
        assert max(abs(a - b) for a, b in zip(dragged, turned)) > 0.05
        radius = lambda p: sum(x * x for x in p) ** 0.5
        assert abs(radius(before) - radius(dragged)) < 1e-6, "an orbit keeps its distance"
        self.browser.press("shift+right", "+")
        self.settled()
        moved = self.server.get("state")["camera"]
        assert moved["look_at"] != [0, 0, 0] and radius([a - b for a, b in zip(moved["position"], moved["look_at"])]) < radius(before)
        changes = self.server.get("state")["changes"]
        self.check_same(self.pixels()[2], self.rendered(self.scene, "-D", f"camera={changes[0]['text']}"))
        self.browser.click("#cameraBack")
        self.settled()
        assert self.server.get("state")["changes"] == []

    def touches(self):
        before = self.server.get("state")["camera"]
        self.browser.drag((0.4, 0.5, 0.3, 0.5), (0.6, 0.5, 0.7, 0.5), kind="touch")
        self.settled()
        after = self.server.get("state")["camera"]
        distance = lambda c: sum((a - b) ** 2 for a, b in zip(c["position"], c["look_at"])) ** 0.5
        assert distance(after) < 0.8 * distance(before), "two fingers that part come nearer"
        self.browser.click("#cameraBack")
        self.settled()

    def scrubs(self):
        self.browser.press(".", ".")
        self.settled(3)
        self.check_same(self.pixels()[2], self.rendered(self.scene, frame=3))

    def deforms(self):
        before = self.pixels()[2]
        self.browser.press(*["shift+left"] * 6, focus=f"[aria-label='{SHEAR}']")
        self.settled(3)
        change = self.server.get("state")["changes"][0]
        assert change["key"] == "mesh.0.deform.0.amount" and "[3, 0.6" in change["text"], change
        after = self.pixels()[2]
        assert sum(abs(a - b) for s, e in zip(before, after) for a, b in zip(s, e)) > 10000, "the highlight turns"
        self.check_same(after, self.rendered(self.scene, "-D", f"{change['key']}={change['text']}", frame=3))

    def wipes(self):
        self.browser.press("w")
        self.browser.until("return !document.getElementById('wipe').hidden")
        self.settled(3)
        change = self.server.get("state")["changes"][0]
        override = f"{change['key']}={change['text']}"
        fixed = self.rendered(self.scene, "-D", override, "-D", "mesh.0.follow=false", frame=3)
        follows = self.rendered(self.scene, "-D", override, frame=3)
        self.browser.until("return true")
        for _ in range(50):
            seen = self.pixels()[2]
            try:
                self.check_same(seen, fixed, 0.52, 1)
                break
            except AssertionError:
                time.sleep(0.1)
        self.check_same(seen, fixed, 0.52, 1)
        self.check_same(seen, follows, 0, 0.48)
        self.browser.screenshot(f"{self.folder}/wipe.png")
        self.browser.press("w")
        self.browser.until("return document.getElementById('wipe').hidden && document.getElementById('wipeLine').hidden")
        self.settled(3)

    def inspects(self):
        self.browser.press("i")
        words = self.browser.until("return document.querySelector('#inspected dl') && document.getElementById('inspected').innerText")
        found = self.server.get("inspect?x=120&y=80")
        gloss = found["gloss"]
        probe = gloss["probe"].split()
        said = json.loads(subprocess.run([self.taut, *probe[1:]], check=True, capture_output=True, text=True).stdout)
        assert f"{said['alpha_max']:.5g}"[:5] in words and "brushed (conductor)" in words, words
        assert self.browser.run("return document.querySelectorAll('#overlay polygon').length") == 2
        assert not self.browser.run("return document.getElementById('lobe').hidden")
        self.browser.screenshot(f"{self.folder}/inspect.png")
        self.browser.press("f", "enter")
        self.settled(3)
        assert abs(self.server.get("state")["camera"]["focus_distance"] - found["depth"]) < 1e-4
        self.browser.press("f", "i")

    def saves(self):
        for name in ("turned.toml", "turned.png"):
            self.browser.run("document.getElementById('saving').open = true; document.getElementById('fileName').value = arguments[0]", name)
            self.browser.click("#save")
            self.browser.until("return document.getElementById('saved').textContent.includes(arguments[0])", name)
        self.check_same(self.pixels()[2], self.rendered(f"{self.folder}/turned.toml", frame=3))
        width, _, data = webdriver.read_png(f"{self.folder}/turned.png")
        self.check_same(self.pixels()[2], [data[i:i + 3 * width] for i in range(0, len(data), 3 * width)])
        again = Server(self.taut, f"{self.folder}/turned.toml")
        assert again.get("state")["changes"] == []
        again.end()

    def undoes(self):
        count = len(self.server.get("state")["changes"])
        assert count == 2
        self.browser.press("ctrl+z")
        self.browser.until("return !document.getElementById('redo').disabled")
        assert len(self.server.get("state")["changes"]) == 1
        for _ in range(50): # as many steps as there were pauses between keys
            if not self.server.get("state")["changes"]:
                break
            self.browser.run("document.getElementById('undo').click()")
            time.sleep(0.2)
        assert self.server.get("state")["changes"] == []
        self.settled(3)
        self.check_same(self.pixels()[2], self.rendered(self.scene, frame=3))
        self.browser.click("#redo")
        self.browser.until("return !document.getElementById('undo').disabled")

    def plays(self):
        self.browser.press("c", "a", "b", " ")
        for frame in ("1", "2", "3"):
            self.browser.until("return document.getElementById('picture').dataset.frame === arguments[0]", frame)
        self.browser.press(" ")
        self.settled(self.server.get("state")["frame"])

    def speaks(self):
        """All that can be reached has a name, and the keyboard reaches it."""
        self.browser.run("for (const d of document.querySelectorAll('details')) d.open = true")
        controls = self.browser.all("button, input, select, textarea, summary, canvas")
        assert len(controls) > 25
        for control in controls:
            assert self.browser.name_of(control) or self.browser.run("return arguments[0].hidden || arguments[0].tagName === 'SUMMARY'", {webdriver.ELEMENT: control}), control
        self.browser.run("document.activeElement.blur()")
        seen = set()
        for _ in range(90):
            self.browser.press("tab", focus=None)
            seen.add(self.browser.run("const a = document.activeElement; return a.id || a.getAttribute('aria-label') || a.tagName"))
        for reached in ("picture", "play", "time", "undo", "wiping", "exposure", "fov", SHEAR, "save", "quit"):
            if not self.browser.run("const e = document.getElementById(arguments[0]); return !!e && e.disabled", reached):
                assert reached in seen, f"{reached} is not reached by Tab"

    def fits(self):
        """Both widths, both schemes; nothing scrolls sideways."""
        for width in (1280, 400):
            for scheme in ("light", "dark"):
                self.browser.devtools("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=width < 500)
                self.browser.devtools("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
                assert self.browser.run("return document.scrollingElement.scrollWidth") <= width
                small = self.browser.run("return [...document.querySelectorAll('button')].filter((b) => b.offsetParent && b.getBoundingClientRect().height < 31).map((b) => b.id)")
                assert not small, small
                for place, top in (("top", 0), ("panel", 700)):
                    self.browser.run("document.scrollingElement.scrollTop = arguments[0]", top)
                    assert self.browser.run("return document.getElementById('picture').getBoundingClientRect().bottom") > 50, "in sight"
                    self.browser.screenshot(f"{self.folder}/{width}_{scheme}_{place}.png")
        self.browser.run("document.scrollingElement.scrollTop = 0")
        self.browser.devtools("Emulation.clearDeviceMetricsOverride")

    def survives(self):
        changes = self.server.get("state")["changes"]
        assert changes
        complaints = self.browser.complaints()
        assert not complaints, complaints
        self.server.end()
        self.browser.until("return document.getElementById('trouble').textContent.includes('The server is gone')")
        self.server = Server(self.taut, self.scene, "--token-file", f"{self.folder}/token", "--port", self.port)
        self.browser.until("return document.getElementById('trouble').hidden")
        for _ in range(int(100 * webdriver.PATIENCE)):
            if self.server.get("state")["changes"] == changes:
                break
            time.sleep(0.1)
        assert self.server.get("state")["changes"] == changes, "what was changed is there again"
        self.browser.run("document.getElementById('saving').open = true")
        self.browser.click("#quit")
        assert self.server.process.wait(timeout=60 * webdriver.PATIENCE) == 0

    def run(self):
        try:
            for part in (self.opens, self.looks, self.denoises, self.layers, self.looks_as_the_scene_says, self.orbits, self.touches, self.frames, self.snapshots, self.scrubs, self.colours, self.deforms, self.wipes, self.inspects, self.saves, self.undoes,
                         self.plays, self.speaks, self.fits, self.survives):
                print(part.__name__, flush=True)
                part()
        finally:
            self.browser.screenshot(f"{self.folder}/last.png")
            self.browser.close()
            if self.server.process.poll() is None:
                self.server.process.kill()


def main():
    taut, folder = sys.argv[1:]
    if lacking := webdriver.missing():
        print(f"skipped: no {' and no '.join(lacking)} (apt-get install chromium chromium-driver)")
        return 77
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    Test(taut, folder).run()
    return 0


if __name__ == "__main__":
    sys.exit(main())
