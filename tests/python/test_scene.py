"""taut.Scene against the command, and what it does with functions, exceptions, signals and threads."""

import os
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest
import taut

from conftest import ROOT, grid

POINTS, FACES, UV = grid(24, 24, 2, 2)
POINTS[:, :2] -= 1


def sheared(frame):
    points = POINTS.copy()
    points[:, 0] += np.float32(0.25 * (frame - 1)) * POINTS[:, 1]
    return points


def sheet(points=None, **keys):
    return {
        "render": {"width": 96, "height": 54, "spp": 4, "frames": "1-4"},
        "camera": {"position": [0, -3, 2]},
        "environment": {"preset": "studio"},
        "material": {"brushed": {"type": "conductor", "alpha": [0.08, 0.4]}},
        "mesh": [{"positions": POINTS, "faces": FACES, "uv": UV, "points": points, "material": "brushed", **keys}],
    }


FILE = f"""
[render]
width = 96
height = 54
spp = 4
frames = "1-4"
[camera]
position = [0, -3, 2]
[environment]
preset = "studio"
[material.brushed]
type = "conductor"
alpha = [0.08, 0.4]
[[mesh]]
file = "{ROOT}/meshes/panel.obj"
material = "brushed"
[[mesh.deform]]
type = "shear"
plane = "xy"
amount = [[1, 0.0], [4, 0.75]]
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(FILE)
    return path


# --- the command ------------------------------------------------------------------------------------------------------


def test_renders_the_bits_of_the_command(file, command, tmp_path):
    made = command("render", file, "--frames", "3", "--aov", "all", "-q", "-o", tmp_path / "command.exr")
    assert made.returncode == 0, made.stderr
    picture = taut.Scene(file).render(3, aovs="all")
    pixels, channels = taut.read_image(tmp_path / "command.exr")
    taut.write_image(tmp_path / "package.exr", picture)
    mine, names = taut.read_image(tmp_path / "package.exr")
    assert sorted(names) == sorted(channels) and len(names) > 20
    for name in names:
        np.testing.assert_array_equal(mine[..., names.index(name)], pixels[..., channels.index(name)], err_msg=name)
    assert picture["rgb"].shape == (54, 96, 3) and picture["m"].shape == (54, 96, 3) and picture["depth"].shape == (54, 96)
    assert (picture["samples"] == 4).all()
    assert 0.05 < picture["rgb"].mean() < 1 and picture["rgb"].std() > 0.02


def test_a_dict_is_the_file(file):
    tree = {
        "render": {"width": np.int64(96), "height": 54, "spp": 4, "frames": "1-4"},
        "camera": {"position": np.array([0, -3, 2])},
        "environment": {"preset": "studio"},
        "material": {"brushed": {"type": "conductor", "alpha": (0.08, 0.4)}},
        "mesh": [{"file": ROOT / "meshes" / "panel.obj", "material": "brushed",
                  "deform": [{"type": "shear", "plane": "xy", "amount": [[1, 0.0], [4, 0.75]]}]}],
    }  # fmt: skip
    np.testing.assert_array_equal(taut.Scene(tree).render(2)["rgb"], taut.Scene(file).render(2)["rgb"])
    tree["mesh"][0]["file"] = "panel.obj"
    assert taut.Scene(tree, folder=ROOT / "meshes").objects == ["panel"]
    assert taut.Scene(file, ["render.width=20"]).size == (20, 54)


def test_plan_and_export_are_the_commands(file, command, tmp_path):
    import json

    scene = taut.Scene(file)
    scene.render(1, spp=1)
    assert scene.plan() == json.loads(command("info", file, "--json").stdout)
    made = command("export", file, "--frames", "2-3", "-q", "-o", tmp_path / "command.####.npz")
    assert made.returncode == 0, made.stderr
    report = scene.export(tmp_path / "package.####.npz", "2-3")
    assert report["files"] == [str(tmp_path / f"package.000{f}.npz") for f in (2, 3)]
    for frame in (2, 3):
        assert (tmp_path / f"command.000{frame}.npz").read_bytes() == (tmp_path / f"package.000{frame}.npz").read_bytes()
    stored, arrays = np.load(tmp_path / "package.0003.npz"), scene.gloss(3)
    for name, values in arrays.items():
        np.testing.assert_array_equal(stored[name], values, err_msg=name)
    assert len(scene.export([tmp_path / "a.ply", tmp_path / "b.mdd"], frames=2)["files"]) == 2


# --- points -----------------------------------------------------------------------------------------------------------


def test_a_function_and_arrays_are_one_motion():
    function = taut.Scene(sheet(sheared))
    arrays = taut.Scene(sheet(np.stack([sheared(f) for f in range(1, 5)])))
    listed = taut.Scene(sheet([sheared(3), sheared(4)]))
    late = taut.Scene({**sheet(), "mesh": [{**sheet([sheared(3), sheared(4)])["mesh"][0], "first_frame": 3}]})
    for frame in (3, 3.5, 4):
        picture = function.render(frame)
        np.testing.assert_array_equal(late.render(frame)["rgb"], arrays.render(frame)["rgb"])
        assert np.abs(arrays.render(frame)["rgb"] - picture["rgb"]).max() < 2e-3  # linear between frames: rounding
    np.testing.assert_array_equal(listed.gloss(2)["P"], arrays.gloss(4)["P"])
    assert np.abs(function.render(4)["rgb"] - function.render(1)["rgb"]).mean() > 0.01


def test_gloss_of_a_scene_is_that_of_the_arrays():
    scene = taut.Scene(sheet(sheared))
    found = scene.gloss(3)
    expected = taut.gloss(POINTS, sheared(3), FACES, UV, alpha=(0.08, 0.4))
    order = [int(np.flatnonzero((found["Pref"] == p).all(1))[0]) for p in POINTS]
    np.testing.assert_array_equal(found["M"][order], expected.M)
    np.testing.assert_array_equal(found["phi"][order], expected.phi)


def test_arrays_are_read_where_they_are():
    frames = np.stack([sheared(1), sheared(2)])
    before = taut.copies()
    scene = taut.Scene(sheet(frames))
    first = scene.render(2)["rgb"]
    assert taut.copies() == before
    frames[1] = sheared(4)  # rewritten between two renders
    changed = scene.render(2)["rgb"]
    np.testing.assert_array_equal(changed, taut.Scene(sheet(frames.copy())).render(2)["rgb"])
    assert np.abs(changed - first).mean() > 0.005
    scene.set_points("mesh", [sheared(1), sheared(2)])
    np.testing.assert_array_equal(scene.render(2)["rgb"], first)


def test_gloss_follows_at_frames_that_no_plan_has_seen(file):
    # A plan for frames at rest would keep the rest material.
    late = sheet(sheared)
    late["render"]["frames"] = "1"
    expected = taut.Scene(sheet(sheared), model="full").render(4, spp=64, aovs="alpha")["alpha"]
    for scene in (taut.Scene(late), taut.Scene(file, ["render.frames=1"])):
        scene.render(1)
        found = scene.render(4, spp=64, aovs="alpha")["alpha"]
        inside = (found[..., 0] > 0) & (expected[..., 0] > 0)
        assert np.abs(found - expected)[inside].mean() < 2e-3 and np.ptp(expected[inside][:, 0]) < 0.01
    held = np.empty((1, *POINTS.shape), "f4")
    held[0] = sheared(1)
    scene = taut.Scene(sheet(held))
    scene.render(1)
    held[0] = sheared(4)
    found = scene.render(1, spp=64, aovs="alpha")["alpha"]
    inside = (found[..., 0] > 0) & (expected[..., 0] > 0)
    np.testing.assert_allclose(found[inside], expected[inside], atol=2e-3)


def test_motion_blur_asks_between_frames():
    asked = []

    def move(frame):
        asked.append(frame)
        return sheared(frame)

    tree = sheet(move)
    tree["render"].update(shutter=0.5, motion_steps=3)
    taut.Scene(tree).render(2, spp=1)
    assert {1.75, 2.0, 2.25} <= set(asked)


def test_faces_may_have_materials_of_their_own():
    slots = (np.arange(len(FACES)) % 24 >= 12).astype("i4")
    tree = sheet(face_materials=slots, material_names=["left", "right"])
    tree["material"]["white"] = {"type": "diffuse", "color": 0.8}
    tree["mesh"][0]["material"] = {"left": "brushed", "right": "white"}
    albedo = taut.Scene(tree).render(1, spp=16, aovs="albedo")["albedo"]
    assert albedo[30, 60, 0] == pytest.approx(0.8, abs=1e-3) and albedo[30, 36, 0] != pytest.approx(0.8, abs=0.05)
    slots[3] = 2
    with pytest.raises(taut.InputError, match=r"face_materials\[3\]: found 2, expected an index of one of 2 material_names"):
        taut.Scene(tree)


# --- refining ---------------------------------------------------------------------------------------------------------


def test_refining_ends_with_the_bits_of_a_render():
    scene = taut.Scene(sheet(sheared))
    whole = scene.render(2, spp=32, aovs=["alpha", "depth"])
    assert list(whole) == ["rgb", "coverage", "samples", "alpha", "depth"] and whole["alpha"].shape == (54, 96, 3)
    pictures = list(scene.refine(2, spp=32, aovs=["alpha", "depth"], every=1e-3))
    assert len(pictures) > 1
    for name in whole:
        np.testing.assert_array_equal(pictures[-1][name], whole[name])
    assert (pictures[0]["samples"] < 32).any()
    crop = scene.render(2, spp=32, crop=(10, 5, 40, 25))
    np.testing.assert_array_equal(crop["rgb"], whole["rgb"][5:25, 10:40])
    noisy = scene.render(2, spp=64, noise=0.2)
    assert noisy["samples"].min() < noisy["samples"].max()
    assert np.abs(scene.render(2, spp=32, seed=5)["rgb"] - whole["rgb"]).max() > 0


def test_a_checkpoint_goes_on_in_another_process(tmp_path):
    scene = taut.Scene(sheet(np.stack([sheared(1), sheared(2)])))
    refinement = scene.refine(2, spp=16)
    assert refinement.advance(samples=5) == "going" and 0 < refinement.share < 1
    refinement.save(tmp_path / "half")
    np.savez(tmp_path / "points.npz", POINTS=POINTS)
    program = f"""
import sys
sys.path.insert(0, {str(ROOT / 'tests' / 'python')!r})
import numpy as np, taut, test_scene as t
r = taut.Scene(t.sheet(np.stack([t.sheared(1), t.sheared(2)]))).refine(2, spp=16).restore({str(tmp_path / 'half')!r})
assert 0 < r.share < 1
assert r.advance() == "done"
np.save({str(tmp_path / 'rest.npy')!r}, r.picture()["rgb"])
"""
    subprocess.run([sys.executable, "-c", program], check=True)
    np.testing.assert_array_equal(np.load(tmp_path / "rest.npy"), scene.render(2, spp=16)["rgb"])
    with pytest.raises(taut.InputError):
        scene.refine(1, spp=16, seed=3).restore(tmp_path / "half")
    (tmp_path / "bad").write_bytes((tmp_path / "half").read_bytes()[:100])
    with pytest.raises(taut.InputError):
        scene.refine(2, spp=16).restore(tmp_path / "bad")


def test_only_the_latest_refinement_goes_on():
    scene = taut.Scene(sheet(sheared))
    old = scene.refine(1, spp=8)
    old.advance(samples=1)
    new = scene.refine(2, spp=8)
    with pytest.raises(taut.RunError, match="gone on to another frame"):
        old.advance()
    assert old.picture()["rgb"].shape == (54, 96, 3)  # what it has stays
    assert new.advance() == "done"


# --- stop, progress, signals, exceptions ------------------------------------------------------------------------------


def test_stop_from_another_thread():
    scene = taut.Scene(sheet(sheared))
    refinement = scene.refine(1, spp=1 << 20)
    threading.Timer(0.3, refinement.stop).start()
    assert refinement.advance() == "stopped" and not refinement.done
    threading.Timer(0.3, scene.stop).start()
    picture = scene.render(1, spp=1 << 20)
    assert picture["samples"].max() < 1 << 20 and np.isfinite(picture["rgb"]).all()
    assert len(list(zip(range(3), scene.refine(1, spp=1 << 20, every=0.02)))) == 3


def test_progress_is_told_and_may_stop():
    scene = taut.Scene(sheet(sheared))
    shares = []
    scene.render(1, spp=600, progress=lambda share: shares.append((share, threading.get_ident())))
    assert [s for s, _ in shares] == sorted(s for s, _ in shares) and shares[-1][0] == 1
    assert {t for _, t in shares} == {threading.get_ident()}
    assert scene.render(1, spp=1 << 20, progress=lambda share: share < 1e-4)["samples"].max() < 1 << 20


def test_a_callback_cannot_use_its_scene():
    scene = taut.Scene(sheet(sheared))
    with pytest.raises(taut.RunError, match="used by a function that it has called"):
        scene.render(1, spp=1 << 20, progress=lambda share: scene.render(2))
    assert scene.render(2, spp=1)["samples"].max() == 1


class Mine(Exception):
    pass


def test_exceptions_of_callbacks_come_out_as_themselves():
    def fail(_):
        raise Mine("of the caller")

    with pytest.raises(Mine, match="of the caller"):
        taut.Scene(sheet(fail)).render(1)
    scene = taut.Scene(sheet(sheared))
    with pytest.raises(Mine):
        scene.render(1, spp=1 << 20, progress=fail)
    calls = []

    def sometimes(frame):
        calls.append(frame)
        if frame == 3:
            raise Mine
        return sheared(frame)

    tree = sheet(sometimes)
    tree["render"]["frames"] = "1-2"
    scene = taut.Scene(tree)
    with pytest.raises(Mine):
        scene.render(3)
    np.testing.assert_array_equal(scene.render(2)["rgb"], taut.Scene({**sheet(sheared), "render": tree["render"]}).render(2)["rgb"])


def test_ctrl_c_stops_and_leaves_a_whole_picture():
    scene = taut.Scene(sheet(sheared))
    refinement = scene.refine(1, spp=1 << 20)
    threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        refinement.advance()
    assert 0 < refinement.share < 1 and np.isfinite(refinement.picture()["rgb"]).all()
    assert refinement.advance(samples=1) == "going"


def test_threads_of_python_run_while_a_frame_is_rendered():
    scene = taut.Scene(sheet(sheared))
    counted, over = [0], threading.Event()

    def count():
        while not over.is_set():
            counted[0] += 1

    thread = threading.Thread(target=count)
    thread.start()
    before = counted[0]
    scene.refine(1, spp=500).advance()
    over.set()
    thread.join()
    assert counted[0] - before > 1000


def test_many_threads_share_a_scene():
    scene = taut.Scene(sheet(sheared))
    alone = [scene.render(f)["rgb"] for f in (1, 2, 3)]
    together = {}

    def work(frame):
        together[frame] = scene.render(frame)["rgb"]

    threads = [threading.Thread(target=work, args=(f,)) for f in (1, 2, 3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for frame in (1, 2, 3):
        np.testing.assert_array_equal(together[frame], alone[frame - 1])
