#!/usr/bin/env python3
"""How long `taut view` takes, as a page sees it: from a change to the arrival of the first picture of it, and samples a second once still.

    times.py TAUT SCENE [--width 960] [--height 540] [--spp 64] [--count 100] [--rounds 3] [--key mesh.0.deform.0.amount --from 0 --to 1] [-D ...]

Without --key the camera orbits. Medians; the share is that of `taut render`'s samples a second for the same scene, one after the other.
"""

import argparse
import http.client
import json
import math
import signal
import statistics
import struct
import subprocess
import tempfile
import time


class Server:
    def __init__(self, taut, scene, overrides):
        words = [taut, "view", scene, "--no-open"]
        for override in overrides:
            words += ["-D", override]
        self.process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
        url = self.process.stdout.readline().strip()
        self.host, self.token = url.split("/")[2:4]
        self.changes, self.pictures = http.client.HTTPConnection(self.host), http.client.HTTPConnection(self.host)

    def ask(self, connection, method, path, body=None):
        connection.request(method, f"/{self.token}/{path}", body=body, headers={"Content-Type": "application/json"} if body else {})
        answer = connection.getresponse()
        data = answer.read()
        assert answer.status in (200, 204), data
        return data

    def state(self):
        return json.loads(self.ask(self.changes, "GET", "state"))

    def change(self, changes):
        return json.loads(self.ask(self.changes, "POST", "change", json.dumps({"changes": changes})))["version"]

    def label(self, number):
        """Words of the next picture's header."""
        while not (data := self.ask(self.pictures, "GET", f"picture?follows=1&after={number}")):
            pass
        return struct.unpack("<16I", data[:64])

    def picture(self, version, whole=False, number=0):
        """The first picture of that version: its columns."""
        while True:
            words = self.label(number)
            number = words[1]
            if words[2] >= version and (not whole or words[11]):
                return words[5]

    def end(self):
        self.process.send_signal(signal.SIGINT)
        self.process.wait()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("taut")
    parser.add_argument("scene")
    for name, default in (("width", 960), ("height", 540), ("spp", 64), ("count", 100), ("rounds", 3)):
        parser.add_argument(f"--{name}", type=int, default=default)
    parser.add_argument("--key")
    parser.add_argument("--from", type=float, default=0, dest="first")
    parser.add_argument("--to", type=float, default=1)
    parser.add_argument("-D", action="append", default=[], dest="define")
    arguments = parser.parse_args()
    overrides = [f"render.width={arguments.width}", f"render.height={arguments.height}", f"render.spp={arguments.spp}", *arguments.define]
    server = Server(arguments.taut, arguments.scene, overrides)
    server.picture(1, whole=True)
    camera = server.state()["camera"]
    answered, arrived, columns = [], [], []
    for i in range(arguments.count):
        u = i / max(1, arguments.count - 1)
        if arguments.key:
            change = {"key": arguments.key, "value": arguments.first + u * (arguments.to - arguments.first), "atFrame": True}
        else:
            c, s = math.cos(0.3 * u), math.sin(0.3 * u)
            x, y, z = (a - b for a, b in zip(camera["position"], camera["look_at"]))
            turned = [c * x - s * y, s * x + c * y, z]
            change = {"key": "camera", "value": {**camera, "position": [a + b for a, b in zip(turned, camera["look_at"])]}}
        start = time.perf_counter()
        version = server.change([change])
        answered.append(1000 * (time.perf_counter() - start))
        columns.append(server.picture(version))
        arrived.append(1000 * (time.perf_counter() - start))
        time.sleep(0.05)
    print(f"{len(arrived)} changes of {arguments.key or 'the camera'}: first picture after {statistics.median(arrived):.0f} ms (median; "
          f"90 % within {sorted(arrived)[int(0.9 * len(arrived))]:.0f} ms), answered after {statistics.median(answered):.0f} ms, "
          f"{statistics.median(columns):.0f} columns")
    rates = [rates_of(arguments, server, overrides, camera, round_) for round_ in range(arguments.rounds)]
    server.end()
    viewed, rendered = (statistics.median(values) for values in zip(*rates))
    shares = sorted(v / r for v, r in rates)
    print(f"once still: {viewed:.2f} million samples a second, taut render {rendered:.2f}, share {statistics.median(shares):.2f} "
          f"({shares[0]:.2f} to {shares[-1]:.2f}) in {arguments.rounds} rounds")


def rates_of(arguments, server, overrides, camera, round_):
    """Million samples a second of the view, from its first picture of some samples to its last, and of `taut render`."""
    eye = {**camera, "position": [a + 1e-4 * (round_ + 1) for a in camera["position"]]}
    version = server.change([{"key": "camera", "value": eye}])
    first, number = None, 0
    while True:
        words = server.label(number)
        number, samples = words[1], words[9]
        if words[2] < version or words[5] < words[7]:
            continue
        if first is None and samples >= 4:
            first, start = samples, time.perf_counter()
        if words[11]:
            break
    pixels = arguments.width * arguments.height / 1e6
    viewed = pixels * (samples - first) / (time.perf_counter() - start)
    state = server.state()
    words = [word for c in state["changes"] for word in ("-D", f"{c['key']}={c['text']}")]
    for override in overrides:
        words += ["-D", override]
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([arguments.taut, "render", arguments.scene, *words, "--only", str(state["frame"]), "-q", "-o", f"{folder}/a.####.exr",
                        "--stats", f"{folder}/stats.json"], check=True)
        with open(f"{folder}/stats.json") as file:
            frame = json.load(file)["frames"][0]
    times = frame["times"]
    return viewed, pixels * arguments.spp / (frame["seconds"] - times["deformation_s"] - times["gradient_s"] - times["bvh_s"])


if __name__ == "__main__":
    main()
