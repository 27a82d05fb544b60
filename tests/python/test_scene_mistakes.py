"""What taut.Scene says of bad input: one line, the command's."""

import numpy as np
import pytest
import taut

from test_scene import FACES, FILE, POINTS, file  # noqa: F401: a fixture


def broken(**keys):
    return {"mesh": [{"positions": POINTS, "faces": FACES, **keys}]}


def endless():
    tree = {}
    tree["render"] = tree
    return tree


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda: taut.Scene("nofile.toml"), "nofile.toml: found no such file, expected a readable file"),
        (lambda: taut.Scene({"rendr": {}}), "rendr: found 'rendr', expected one of render, image, camera,"),
        (lambda: taut.Scene({"render": {"width": -3}}), "render.width: found -3, expected an integer in [1, 32768]"),
        (lambda: taut.Scene({"render": {"width": None}}), "render.width: found NoneType 'None', expected a number, a string"),
        (lambda: taut.Scene({"render": {1: 2}}), "render: found 1 for a key, expected a string"),
        (lambda: taut.Scene({"mesh": {}}), "mesh: found dict, expected a list of meshes"),
        (lambda: taut.Scene({"mesh": [{}]}), "mesh[0]: found no key 'file', expected file = \"mesh.obj\""),
        (lambda: taut.Scene(broken(file="a.obj")), "mesh[0]: found 'positions' and 'file', expected one of the two"),
        (lambda: taut.Scene({"mesh": [{"positions": POINTS}]}), "mesh[0]: found 'positions' without 'faces', expected both"),
        (lambda: taut.Scene(broken(follo=True)), "mesh[0].follo: found 'follo', expected one of file, name,"),
        (lambda: taut.Scene(broken(cache="a.mdd")), "mesh[0].cache: found"),
        (lambda: taut.Scene(broken(material="c")), "mesh[0].material: found 'c', expected the name of a material"),
        (lambda: taut.Scene(broken(points=POINTS[:3])), "mesh[0].points[0]: found an array of shape (3, 3), expected (625, 3)"),
        (
            lambda: taut.Scene(broken(points=lambda f: POINTS[:3])).render(),
            "mesh[0].points(1): found an array of shape (3, 3), expected (625, 3)",
        ),
        (
            lambda: taut.Scene(broken(points=lambda f: POINTS * np.nan)).render(),
            "object 'mesh': found a point that is not finite at frame 1",
        ),
        (lambda: taut.Scene(broken(points=[])), "mesh[0].points: found no frame, expected at least one array"),
        (lambda: taut.Scene(broken(), model="fast"), "model: found 'fast', expected one of auto, full"),
        (lambda: taut.Scene(broken(), tolerance=7), "tolerance: found 7, expected a number in [1e-6, 1]"),
        (lambda: taut.Scene(broken()).render(spp=0), "spp: found 0, expected a whole number in [1, 16777216]"),
        (lambda: taut.Scene(broken()).render(spp=1.5), "spp: found 1.5, expected a whole number"),
        (lambda: taut.Scene(broken()).render(seed=-1), "seed: found -1, expected a whole number in [0, 4294967295]"),
        (lambda: taut.Scene(broken()).render(noise=2), "noise: found 2, expected a relative noise level above 0 and below 1"),
        (lambda: taut.Scene(broken()).render(seconds=float("nan")), "seconds: found nan, expected a time above 0"),
        (lambda: taut.Scene(broken()).render(frame=float("inf")), "frame: found inf, expected a frame in [-1e9, 1e9]"),
        (lambda: taut.Scene(broken()).render(progress=3), "progress: found 3, expected a function of the share done"),
        (lambda: taut.Scene(broken()).render(aovs=[1]), "aovs[0]: found 1, expected a string"),
        (lambda: taut.Scene(broken()).render(crop=(1, 2, 3)), "crop: found (1, 2, 3), expected (x0, y0, x1, y1)"),
        (lambda: taut.Scene(endless()), "render.render.render."),
        (
            lambda: taut.Scene({"render": {"width": 10**30}}),
            "render.width: found 1000000000000000000000000000000, expected a number of 64 bits",
        ),
        (lambda: taut.Scene(broken(), overrides=[1]), "overrides[0]: found 1, expected a string"),
        (lambda: taut.Scene(broken(points=lambda f: None)).render(), "mesh[0].points(1): found None, expected an array of numbers"),
        (lambda: taut.Scene(broken(points="abc")), "mesh[0].points: found 'abc', expected arrays of positions or a function"),
        (lambda: taut.Scene(broken(points=[POINTS])).set_points("mesh", POINTS[:3]), "scene: objects[0] 'mesh'.points: found 3 points"),
        (lambda: taut.Scene(broken()).export(3), "path: found 3, expected a string or a sequence of strings"),
        (lambda: taut.limit_threads(-1), "threads: found -1, expected a whole number in [0, 1024]"),
        (lambda: taut.read_image("no.png"), "no.png: found no such file"),
        (lambda: taut.Scene(broken()).render(aovs="dept"), "aovs: found 'dept', expected one of depth,"),
        (lambda: taut.Scene(broken()).render(crop=(0, 0, 9999, 2)), "crop: found another part of the picture, expected (x0, y0, x1, y1)"),
        (lambda: taut.Scene(broken()).export("a.foo"), "-o 'a.foo': found 'foo', expected one of ply,"),
        (lambda: taut.Scene(broken()).export("a.npz", frames="1-"), "frames"),
        (lambda: taut.Scene(broken()).gloss(1, "mash"), "object: found 'mash', expected mesh; did you mean 'mesh'?"),
        (lambda: taut.write_image("a.jpg", np.zeros((2, 2, 3))), "path: found 'a.jpg', expected a file name that ends in .exr or .png"),
        (lambda: taut.write_image("a.png", np.zeros(3)), "picture: found an array of shape (3,), expected (height, width)"),
    ],
)
def test_mistakes(make, message):
    with pytest.raises(taut.InputError) as error:
        make()
    assert str(error.value).startswith(message) and "\n" not in str(error.value)


def test_the_messages_are_the_commands(file, command):
    file.write_text(FILE.replace("brushed]", "brushed]\nalfa = 3"))
    said = command("render", file, "--check")
    with pytest.raises(taut.InputError) as error:
        taut.Scene(file)
    assert said.returncode == 2 and said.stderr.strip() == f"taut: error: {error.value}"
