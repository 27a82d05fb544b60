"""Renders files of `taut export` with Cycles under the camera and lights of a Taut scene, as Taut would: for comparison.

    blender -b -noaudio --factory-startup --python-exit-code 1 --python render_export.py -- SCENE.toml FRAME SPP OUT.exr FILE...

FILE: .npz of that frame, one an object. Every object is a metal of reflectance 1 without multiple scattering. Of the scene
file it reads what a comparison needs: [render] width height max_events, [camera] position look_at up fov_deg (constant),
[environment] radiance, [[light]] of type quad and sphere. Everything in Cycles that trades truth for speed is off.
"""

import os
import sys
import tomllib

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import taut_gloss  # noqa: E402: found beside this file
from cycles_settings import add_camera, add_light, set_cycles, triple  # noqa: E402


def set_world(scene, environment):
    if environment and "radiance" not in environment:
        raise ValueError("found an [environment] without radiance, expected a constant one")
    world = bpy.data.worlds.new("world")
    scene.world = world
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*triple(environment.get("radiance", 0)), 1)
    background.inputs["Strength"].default_value = 1.0


def build(description, frame, spp, files):
    """An empty scene with the files at a frame, and the scene file's camera and lights."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    for file in files:
        taut_gloss.import_gloss(file, frame)
    add_camera(scene, description["camera"])
    for light in description.get("light", []):
        add_light(scene, light)
    set_world(scene, description.get("environment", {}))
    set_cycles(scene, description.get("render", {}), spp)
    scene.frame_set(frame)
    return scene


def main():
    words = sys.argv[sys.argv.index("--") + 1 :]
    with open(words[0], "rb") as stream:
        description = tomllib.load(stream)
    scene = build(description, int(words[1]), int(words[2]), words[4:])
    scene.render.filepath = os.path.abspath(words[3])
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    main()
