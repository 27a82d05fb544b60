"""What the scripts that set Render with Taut beside Cycles share: a ground, lamps, and the two pictures.

Words after --: ADDON_FOLDER PACKAGE_FOLDER SCRATCH.
"""

import importlib.util
import math
import os
import sys

import bpy
import numpy as np

addon, package, scratch = sys.argv[sys.argv.index("--") + 1 :]
sys.path[:0] = [addon, package]
import taut  # noqa: E402: found in PACKAGE_FOLDER
import taut_gloss  # noqa: E402: found in ADDON_FOLDER
from taut_gloss import render as taut_render  # noqa: E402

specification = importlib.util.spec_from_file_location("taut_cycles", os.path.join(addon, "cycles.py"))
cycles = importlib.util.module_from_spec(specification)
specification.loader.exec_module(cycles)
taut_gloss.register()


def fresh():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    cycles.set_cycles(scene, {"width": 96, "height": 64, "max_events": 1}, 64)
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.rotation_euler = (0, -4, 3), (math.radians(53), 0, 0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    return scene


def add(name, data, **settings):
    item = bpy.data.objects.new(name, data)
    for key, value in settings.items():
        setattr(item, key, value)
    bpy.context.scene.collection.objects.link(item)
    return item


def ground(kind="ShaderNodeBsdfDiffuse", **inputs):
    mesh = bpy.data.meshes.new("ground")
    x, y = np.meshgrid(np.linspace(-3, 3, 9), np.linspace(-3, 3, 9))
    first = np.arange(72).reshape(8, 9)[:, :-1].ravel()
    mesh.from_pydata(
        np.stack([x, y, 0.05 * x * x], -1).reshape(-1, 3).tolist(), [], np.stack([first, first + 1, first + 10, first + 9], -1).tolist()
    )
    mesh.polygons.foreach_set("use_smooth", np.ones(64, bool))
    mesh.uv_layers.new(name="UVMap").data.foreach_set(
        "uv", np.stack([x, y], -1).reshape(-1, 2)[[v for p in mesh.polygons for v in p.vertices]].ravel()
    )
    made = bpy.data.materials.new("ground")
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    node, output = tree.nodes.new(kind), tree.nodes.new("ShaderNodeOutputMaterial")
    for name, value in inputs.items():
        node.inputs[name.replace("_", " ")].default_value = value
    if "Tangent" in node.inputs:
        tangent = tree.nodes.new("ShaderNodeTangent")
        tangent.direction_type, tangent.uv_map = "UV_MAP", "UVMap"
        tree.links.new(tangent.outputs[0], node.inputs["Tangent"])
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    mesh.materials.append(made)
    return add("ground", mesh)


def light(kind, **settings):
    data = bpy.data.lights.new(kind, kind)
    placed = {key: settings.pop(key) for key in ("location", "rotation_euler") if key in settings}
    for key, value in settings.items():
        setattr(data, key, value)
    return add(kind, data, **{"location": (0.5, 0.3, 2), **placed})


def pictures(samples=64):
    scene = bpy.context.scene
    scene.cycles.samples = samples
    scene.render.filepath = os.path.join(scratch, "cycles.exr")
    bpy.ops.render.render(write_still=True)
    theirs = cycles.load(scene.render.filepath)
    assert bpy.ops.taut.render(samples=samples) == {"FINISHED"}
    image = bpy.data.images[taut_render.IMAGE]
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    return theirs, pixels.reshape(image.size[1], image.size[0], 4)[..., :3].astype(float)


def alike(name, most, samples=64):
    theirs, ours = pictures(samples)
    error = taut.relative_error(ours, theirs, box=4)
    print(f"{name}: mean {ours.mean():.4f} against {theirs.mean():.4f}, relMSE after a box filter {error:.2g}")
    assert theirs.mean() > 0.005, name
    assert abs(ours.mean() / theirs.mean() - 1) < 0.02, name
    assert error < most, name
