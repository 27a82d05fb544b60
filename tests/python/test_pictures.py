"""What pictures offer beside colour: the ground of a bare file, layers, the denoiser, views; all as the command's."""

import json

import numpy as np
import pytest
import taut

from conftest import ROOT, grid

POINTS, FACES, UV = grid(24, 24, 2, 2)
BARE = f"{ROOT}/meshes/body.obj"
SMALL = ("render.width=64", "render.height=36", "render.spp=8")
FILE = f"""
[render]
width = 64
height = 36
spp = 8
frames = "1-3"
[image]
exposure = 1
view = "filmic"
[camera]
position = [0, -3, 2]
[environment]
radiance = 0.2
camera_visible = false
[[light]]
type = "point"
position = [1, -1, 2]
intensity = 20
group = "key"
[material.brushed]
type = "conductor"
alpha = [0.2, 0.4]
[material.paint]
type = "diffuse"
[[mesh]]
file = "{ROOT}/meshes/panel.obj"
material = "brushed"
[[mesh]]
file = "{ROOT}/meshes/panel.obj"
name = "floor"
material = "paint"
translate = [0, 0, -0.5]
scale = 3
[[mesh.deform]]
type = "shear"
plane = "xy"
amount = [[1, 0.0], [3, 0.5]]
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(FILE)
    return path


def same_file(picture, path, folder, expected):
    """The package's file of a picture holds what the command's does, channel for channel."""
    taut.write_image(folder / "package.exr", picture)
    mine, names = taut.read_image(folder / "package.exr")
    theirs, channels = taut.read_image(path)
    assert sorted(names) == sorted(channels) and set(expected) <= set(names)
    for name in names:
        np.testing.assert_array_equal(mine[..., names.index(name)].view("u4"), theirs[..., channels.index(name)].view("u4"), err_msg=name)


def test_a_bare_file_stands_on_the_ground_of_the_command(command, tmp_path):
    sizes = [word for size in SMALL for word in ("-D", size)]
    for name, more, scene in (
        ("ground", [], taut.Scene(BARE, SMALL)),
        ("none", ["--no-ground"], taut.Scene(BARE, SMALL, ground=False)),
    ):
        made = command("render", BARE, *sizes, *more, "-q", "-o", tmp_path / f"{name}.exr")
        assert made.returncode == 0, made.stderr
        same_file(scene.render(), tmp_path / f"{name}.exr", tmp_path, ["R", "A"])
    standing, alone = (taut.Scene(BARE, SMALL, ground=ground) for ground in (None, False))
    assert standing.render(aovs="crypto_object").matte("ground").mean() > 0.2
    metadata = alone.render(aovs="crypto_object").metadata
    names = [list(json.loads(text)) for key, text in metadata.items() if key.endswith("/manifest")]
    assert names == [["body"]]
    # What is exported has no ground.
    assert standing.objects == alone.objects == ["body"]
    np.testing.assert_array_equal(standing.gloss()["P"], alone.gloss()["P"])


def test_a_dict_may_ask_for_a_ground():
    keys = {"render": {"width": 64, "height": 36, "spp": 4, "ground": True}, "mesh": [{"positions": POINTS, "faces": FACES, "points": POINTS}]}
    scene = taut.Scene(keys)
    picture = scene.render(aovs="crypto_object")
    assert picture.matte("ground").mean() > 0.2
    assert np.abs(taut.Scene(keys, ground=False).render()["rgb"] - picture["rgb"]).mean() > 0.05
    scene.set_points(scene.objects[0], POINTS + np.float32([0, 0, 0.3]))
    assert scene.render(aovs="crypto_object").matte("ground").mean() > 0.2


def test_layers_are_those_of_the_command(file, command, tmp_path):
    asked = ["depth", "crypto_object", "crypto_material", "lights", "samples", "variance"]
    made = command("render", file, "--only", "2", "--frames", "1-3", "--aov", ",".join(asked), "-q", "-o", tmp_path / "####.exr")
    assert made.returncode == 0, made.stderr
    scene = taut.Scene(file)
    picture = scene.render(2, aovs=asked)
    same_file(picture, tmp_path / "0002.exr", tmp_path, ["Z", "CryptoObject00.R", "Samples.X", "Variance.R", "Light_key.R"])
    assert picture["crypto_object"].shape == (36, 64, 6, 2) and picture["variance"].shape == (36, 64, 3)
    lights = [picture[key] for key in picture if key.startswith("light_")]
    assert len(lights) == 3 and all(light.shape == (36, 64, 3) for light in lights)
    np.testing.assert_allclose(sum(light.astype("f8") for light in lights), picture["rgb"], rtol=1e-5, atol=1e-6)
    # Mattes by name: they are disjoint, and together all that is seen.
    both = picture.matte("panel") + picture.matte("floor")
    np.testing.assert_allclose(both, picture["coverage"], atol=1e-6)
    np.testing.assert_array_equal(picture.matte("floor"), picture.matte("paint", "material"))
    assert 0.01 < picture.matte("panel").mean() < 0.9
    with pytest.raises(taut.InputError, match="matte: found 'wall', expected one of floor, panel"):
        picture.matte("wall")
    with pytest.raises(taut.InputError, match="a picture without 'crypto_object'"):
        scene.render(2).matte("panel")
    with pytest.raises(taut.InputError, match="expected 'variance'|nearest.*variance|'variance'"):
        scene.render(2, aovs="varience")


def test_denoised_as_by_the_command(file, command, tmp_path):
    made = command("render", file, "--only", "2", "--denoise", "-q", "-o", tmp_path / "####.exr")
    assert made.returncode == 0, made.stderr
    scene = taut.Scene(file)
    picture = scene.render(2, denoise=True)
    same_file(picture, tmp_path / "0002.exr", tmp_path, ["Noisy.R", "DenoiseError"])
    np.testing.assert_array_equal(picture["noisy"], scene.render(2)["rgb"])
    assert (picture["denoise_error"] >= 0).all() and picture["denoise_error"].shape == (36, 64)
    # It is nearer to the truth.
    truth = scene.render(2, spp=2048)["rgb"]
    error = lambda key: ((picture[key] - truth) ** 2).sum()
    assert error("rgb") < 0.6 * error("noisy")
    assert "noisy" not in scene.render(2, spp=1 << 20, denoise=True, progress=lambda share: False)
    timed = scene.render(2, spp=64, seconds=1e-3, denoise=True)
    assert np.isfinite(timed["rgb"]).all() and "denoise_error" in timed


def test_denoised_over_frames_as_by_the_command(file, command, tmp_path):
    made = command("render", file, "--denoise-frames", "-q", "-o", tmp_path / "####.exr")
    assert made.returncode == 0, made.stderr
    scene = taut.Scene(file)
    pictures = []
    for frame, picture in enumerate(scene.render_frames(denoise="frames"), 1):
        same_file(picture, tmp_path / f"{frame:04}.exr", tmp_path, ["Noisy.R"])
        scene.render(1)  # what else is rendered changes nothing
        pictures.append(picture)
    assert len(pictures) == 3
    assert np.abs(pictures[2]["rgb"] - scene.render(3, denoise=True)["rgb"]).max() > 0
    plain = list(scene.render_frames([2, 3], denoise=True))
    np.testing.assert_array_equal(plain[1]["rgb"], scene.render(3, denoise=True)["rgb"])
    with pytest.raises(taut.InputError, match="denoise: found 'often'"):
        list(scene.render_frames(denoise="often"))
    with pytest.raises(taut.InputError, match="denoise: found 'frames' with a fixed seed"):
        list(taut.Scene(file, ["render.fixed_seed=true"]).render_frames(denoise="frames"))


def test_files_are_seen_as_the_scene_says(file, command, tmp_path):
    """[image]: exposure and view of a .png are the scene's, or those that are given."""
    picture = taut.Scene(file).render(2)
    for given, words in (({}, []), ({"exposure": -1, "view": "standard"}, ["--exposure", "-1", "--view", "standard"])):
        made = command("render", file, "--only", "2", *words, "-q", "-o", tmp_path / "####.png")
        assert made.returncode == 0, made.stderr
        taut.write_image(tmp_path / "mine.png", picture, **given)
        np.testing.assert_array_equal(taut.read_image(tmp_path / "mine.png")[0][..., :3], taut.read_image(tmp_path / "0002.png")[0][..., :3])
    taut.write_image(tmp_path / "array.png", picture["rgb"], exposure=1, view="filmic")
    taut.write_image(tmp_path / "mine.png", picture)
    np.testing.assert_array_equal(taut.read_image(tmp_path / "array.png")[0], taut.read_image(tmp_path / "mine.png")[0][..., :3])
    with pytest.raises(taut.InputError, match="exposures"):
        taut.write_image(tmp_path / "mine.png", picture, exposures=1)
    with pytest.raises(taut.InputError, match="filmik"):
        taut.write_image(tmp_path / "mine.png", picture, view="filmik")
    with pytest.raises(taut.InputError):
        taut.write_image(tmp_path / "mine.exr", taut.Scene(file).render(2, 1, aovs="crypto_object"), compression="dwaa")


def test_relative_error_is_that_of_taut_compare(file, command, tmp_path):
    scene = taut.Scene(file)
    pictures = [scene.render(2, seed=seed) for seed in (1, 2)]
    for name, picture in zip("ab", pictures):
        taut.write_image(tmp_path / f"{name}.exr", picture)
    said = json.loads(command("compare", tmp_path / "a.exr", tmp_path / "b.exr", "--box", "4", "--json").stdout)
    a, b = (picture["rgb"] for picture in pictures)
    assert taut.relative_error(a, b) == pytest.approx(said["relmse"], rel=1e-5) and said["relmse"] > 0
    assert taut.relative_error(a, b, box=4) == pytest.approx(said["boxed_relmse"], rel=1e-5)
    with pytest.raises(taut.InputError, match="reference: found an array of shape"):
        taut.relative_error(a, b[:5])
