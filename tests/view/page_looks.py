"""How the page shows what it is sent: views, the denoised picture, layers, what a scene says of them. Parts of page_test.py's Test."""

import math
import os

from view_process import Server


class Looks:
    def shown(self, transform):
        """What the picture's pixels are on a screen, by a function from a linear pixel to display values from 0 to 1."""
        byte = lambda v: round(255 * min(max(v, 0), 1))
        return [bytes(byte(v) for pixel in row for v in transform(pixel)) for row in self.server.picture()]

    def looks(self):
        """View transforms against their formulas: IEC 61966-2-1, Narkowicz 2015, and stops about middle grey."""
        encoded = lambda c: 12.92 * c if c <= 0.0031308 else 1.055 * c ** (1 / 2.4) - 0.055
        filmic = lambda c: min(1, c * (2.51 * c + 0.03) / (c * (2.43 * c + 0.59) + 0.14))
        low, middle, high = (0.0, 0.135, 0.304), (0.486, 0.482, 0.471), (0.996, 0.91, 0.217)

        def stops(pixel):
            stop = math.log2(max(sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), pixel)), 1e-6) / 0.18)
            u = min(max((stop + 6) / 12, 0), 1)
            mix = lambda a, b, t: [x + (y - x) * t for x, y in zip(a, b)]
            return mix(low, middle, 2 * u) if u < 0.5 else mix(middle, high, 2 * u - 1)

        self.check_same(self.pixels()[2], self.shown(lambda pixel: [encoded(c) for c in pixel[:3]]))
        self.browser.press("down", focus="#transform")
        self.check_same(self.pixels()[2], self.shown(lambda pixel: [encoded(filmic(c)) for c in pixel[:3]]))
        self.browser.press("down", focus="#transform")
        self.check_same(self.pixels()[2], self.shown(stops))
        self.browser.press("up", "up", focus="#transform")

    def denoises(self):
        """The whole picture, and the noisy one again; the key and the button are one."""
        self.browser.press("n")
        self.settled()
        clean = self.rendered(self.scene, "--denoise")
        assert clean != self.rendered(self.scene) and self.server.get("state")["denoise"]
        self.check_same(self.pixels()[2], clean)
        self.browser.click("#denoising")
        self.settled()
        self.check_same(self.pixels()[2], self.rendered(self.scene))

    def layers(self):
        """Objects in colours of their own, whatever the exposure; light of the environment alone."""
        encoded = lambda c: 12.92 * c if c <= 0.0031308 else 1.055 * c ** (1 / 2.4) - 0.055
        self.browser.press(*["down"] * 5, focus="#channel")
        self.settled()
        self.browser.press("]")
        self.check_same(self.pixels()[2], self.shown(lambda pixel: [encoded(c) for c in pixel[4:7]]))
        self.browser.press("[")
        lights = self.server.get("state")["lights"]
        self.browser.press(*["down"] * (3 + lights.index("environment")), focus="#channel")
        self.settled()
        first = 4 + 3 * lights.index("environment")
        assert max(max(pixel[first:first + 3]) for row in self.server.picture() for pixel in row) > 0.01
        self.check_same(self.pixels()[2], self.shown(lambda pixel: [encoded(c) for c in pixel[first:first + 3]]))
        self.browser.press(*["up"] * (8 + lights.index("environment")), focus="#channel")
        self.settled()

    def looks_as_the_scene_says(self):
        """A bare file on its ground, through a view that the page has no formula for, a stop up."""
        first = self.server
        options = ("--exposure", "1", "--view", "aces", "-D", "render.width=160", "-D", "render.height=90", "-D", "render.spp=4")
        body = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "meshes", "body.obj"))
        other = self.server = Server(self.taut, body, *options)
        try:
            self.browser.open(self.server.url)
            self.browser.until("return Number(document.getElementById('picture').dataset.samples) > 0")
            self.settled()
            assert self.browser.run("return document.getElementById('transform').value") == "3"
            self.check_same(self.pixels()[2], self.rendered(body, *options), levels=2)
            self.browser.screenshot(f"{self.folder}/ground.png")
        finally:
            self.server = first
            self.browser.open(self.server.url) # before the other is gone, which the page would miss
            other.end()
        self.browser.until("return Number(document.getElementById('picture').dataset.samples) > 0")
        self.settled()
