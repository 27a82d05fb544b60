"""`taut view` as a child process."""

import json
import signal
import struct
import subprocess
import urllib.request

from webdriver import PATIENCE


class Server:
    def __init__(self, taut, scene, *arguments):
        self.process = subprocess.Popen([taut, "view", scene, "--no-open", *arguments], stdout=subprocess.PIPE, text=True)
        self.url = self.process.stdout.readline().strip()

    def get(self, path):
        with urllib.request.urlopen(self.url + path, timeout=60 * PATIENCE) as answer:
            return json.load(answer)

    def end(self):
        self.process.send_signal(signal.SIGINT)
        assert self.process.wait(timeout=60 * PATIENCE) == 0

    def picture(self):
        """The newest picture as it travels: rows of pixels, each its channels, linear."""
        with urllib.request.urlopen(self.url + "picture?follows=1&after=0", timeout=60 * PATIENCE) as answer:
            data = answer.read()
        words = struct.unpack("<16I", data[:64])
        columns, rows, channels = words[5], words[6], words[12]
        flat = struct.unpack(f"<{columns * rows * channels}e", data[64:])
        pixels = [flat[i:i + channels] for i in range(0, len(flat), channels)]
        return [pixels[y * columns:(y + 1) * columns] for y in range(rows)]
