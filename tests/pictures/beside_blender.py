#!/usr/bin/env python3
"""Animated glTF files beside Blender: the same camera, light and time, as `taut render` and as Cycles shows the imported file.

    python3 tests/pictures/beside_blender.py build/release/taut FOLDER [--formula] [--spp N] [NAME...]

For each file: relative mean squared error after a box of 4 x 4 pixels and the mean colour of each material (of its pixels, alike in both
pictures) as ratios Taut / Blender, R G B; FOLDER/NAME.png shows both and their difference (apps/blender/cycles.py compare). --formula:
glTF's formula in Blender in place of its Principled BSDF (tests/blender/gltf_picture.py). Files come from the folder TAUT_ASSETS, else
../shared/assets, and are left out, visibly, where they are missing.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
ASSETS = pathlib.Path(os.environ.get("TAUT_ASSETS", ROOT.parent / "shared" / "assets"))
FILES = {  # file, seconds, clip
    "Fox": ("anim/khronos/Fox.glb", 0.5, "Survey"),
    "CesiumMan": ("anim/khronos/CesiumMan.glb", 0.75, None),
    "RiggedFigure": ("anim/khronos/RiggedFigure.glb", 0.75, None),
    "RiggedSimple": ("anim/khronos/RiggedSimple.glb", 1.0, None),
    "AnimatedMorphCube": ("anim/khronos/AnimatedMorphCube.glb", 1.0, None),
    "AnimatedMorphSphere": ("anim/khronos/AnimatedMorphSphere.glb", 1.0, None),
    "MorphPrimitives": ("anim/khronos/MorphPrimitivesTest.glb", 0.0, None),
    "InterpolationTest": ("anim/khronos/InterpolationTest.glb", 0.0, None),
    "SkinnedCylinder": ("anim/blender_io/03_skinned_cylinder/03_skinned_cylinder.gltf", 0.5, None),
    "Knight": ("anim/kaykit/Knight.glb", 0.5, "Walking_A"),
}
FPS = 24


def blender(log, script, *words):
    command = ["blender", "-b", "-noaudio", "--factory-startup", "--python-exit-code", "1", "--python", str(ROOT / script), "--", *words]
    done = subprocess.run(command, capture_output=True, text=True)
    log.write_text(done.stdout + done.stderr)
    if done.returncode != 0:
        sys.exit(f"{script}: failed; see {log}")
    return done.stdout


def scene_of(view, path, clip):
    camera, light = view["camera"], view["light"]
    lines = [
        "[render]", f"width = {view['width']}", f"height = {view['height']}", f"max_events = {view['events']}", 'filter = "box"',
        f"fps = {FPS}", "[camera]", *(f"{key} = {camera[key]}" for key in ("position", "look_at", "fov_deg")),
        "[environment]", f"radiance = {view['environment']}",
        "[[light]]", 'type = "quad"', *(f"{key} = {light[key]}" for key in ("corner", "u", "v", "radiance")), "camera_visible = false",
        "[[mesh]]", f'file = "{path}"', "lights = false",
    ]
    return "\n".join([*lines, f'clip = "{clip}"'] if clip else lines) + "\n"


def picture(name, taut, folder, arguments):
    file, seconds, clip = FILES[name]
    path, out = ASSETS / file, folder / name
    if not path.exists():
        print(f"{name}: SKIPPED, {file} is not on this machine")
        return
    words = [str(path), str(seconds), str(arguments.spp), f"{out}.blender"]
    words += ["--clip", clip] if clip else []
    words += ["--formula"] if arguments.formula else []
    blender(folder / f"{name}.blender.log", "tests/blender/gltf_picture.py", *words)
    view = json.loads(pathlib.Path(f"{out}.blender.json").read_text())
    scene = pathlib.Path(f"{out}.toml")
    scene.write_text(scene_of(view, path, clip))
    frame = 1 + seconds * FPS
    subprocess.run([taut, "render", scene, "--frames", f"{frame:g}", "--spp", str(arguments.spp), "-q", "-o", f"{out}.taut.exr"], check=True)
    said = blender(folder / f"{name}.compare.log", "apps/blender/cycles.py", "compare", f"{out}.blender.exr", f"{out}.png",
                   f"taut={out}.taut.exr", f"materials={out}.blender.materials.exr:{','.join(view['materials'])}")
    compared = json.loads(subprocess.run([taut, "compare", f"{out}.taut.exr", f"{out}.blender.exr", "--box", "4", "--json"], check=True,
                                         capture_output=True, text=True).stdout)
    print(f"{name}:", f"relMSE {compared['relmse']:.6g} filtered {compared['boxed_relmse']:.6g}",
          *(line for line in said.splitlines() if line.startswith("material")), sep="\n  ")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("taut")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--formula", action="store_true")
    parser.add_argument("--spp", type=int, default=256)
    arguments = parser.parse_intermixed_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    for name in arguments.names or FILES:
        picture(name, os.path.abspath(arguments.taut), arguments.folder, arguments)


main()
