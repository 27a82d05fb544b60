"""The Blender add-on in a Blender without a window; skipped where there is none."""

import os
import pathlib
import shutil
import subprocess

import pytest
import taut

from conftest import ROOT

BLENDER = shutil.which("blender")
pytestmark = pytest.mark.skipif(BLENDER is None, reason="there is no Blender on this machine")


def run(script, *words):
    package = pathlib.Path(taut.__file__).parent.parent
    command = [
        BLENDER,
        "-b",
        "-noaudio",
        "--factory-startup",
        "--python-exit-code",
        "1",
        "--python",
        ROOT / "tests" / "blender" / script,
        "--",
    ]
    done = subprocess.run([*command, ROOT / "apps" / "blender", package, *words], capture_output=True, text=True, timeout=500)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    return done.stdout


def test_live_gloss_is_tauts_own_and_what_goes_wrong_leaves_a_message(tmp_path):
    said = run("live_gloss.py", tmp_path)
    assert "ALL RIGHT" in said
    for name in ("armature with shape keys", "cloth", "lattice"):
        assert f"{name}: " in said
    print(said[said.index("armature") : said.index("lattice") + 100])


def test_render_with_taut_takes_the_scene_as_it_is(tmp_path):
    said = run("live_render.py", tmp_path)
    assert "ALL RIGHT" in said
    print("\n".join(line for line in said.splitlines() if " against " in line))


def test_render_with_taut_takes_images_and_what_shines(tmp_path):
    said = run("live_textures.py", tmp_path)
    assert "ALL RIGHT" in said
    print("\n".join(line for line in said.splitlines() if " against " in line))


def test_cycles_with_the_add_on_shows_what_taut_renders(tmp_path):
    if "TAUT_COMMAND" not in os.environ:
        pytest.skip("TAUT_COMMAND is not set")
    said = run("live_cycles.py", tmp_path, os.environ["TAUT_COMMAND"], "64")
    rows = [line.split() for line in said.splitlines() if line.startswith("relMSE")]
    error = {name: float(filtered) for _, name, _, _, filtered in rows}
    print(error)
    noise = 0.5 * (error["taut_other_seed"] + error["cycles_two_seeds"])  # two pictures differ by the noise of each
    for name in ("cycles_follow", "cycles_in_an_animation", "cycles_roughened"):
        assert error[name] < 1.5 * noise, name
    for name in ("render_with_taut", "render_with_taut_roughened"):
        assert error[name] < 1.5 * error["taut_other_seed"], name
    for name in ("cycles_fixed", "geometry_alone_roughened"):
        assert error[name] > 5 * noise, name
