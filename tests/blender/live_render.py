"""Render with Taut against Cycles: one light, world, camera and material at a time; then what has no counterpart or is not there.

    blender -b -noaudio --factory-startup --python-exit-code 1 --python live_render.py -- ADDON_FOLDER PACKAGE_FOLDER SCRATCH
"""

import importlib.util
import math
import os
import sys

import bpy
import numpy as np

addon, package, scratch = sys.argv[sys.argv.index("--") + 1 :]
sys.path[:0] = [addon, package]
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


def alike(name, most):
    theirs, ours = pictures()
    error = cycles.relative_error(cycles.box(ours), cycles.box(theirs))
    print(f"{name}: mean {ours.mean():.4f} against {theirs.mean():.4f}, relMSE after a box filter {error:.2g}")
    assert theirs.mean() > 0.005, name
    assert abs(ours.mean() / theirs.mean() - 1) < 0.02, name
    assert error < most, name


# A narrow spot: Cycles 3.4 lets spots fall by the cosine to their axis, which is near 1 there.
LIGHTS = {
    "sun": lambda: light("SUN", energy=2.0, angle=0.0, rotation_euler=(0.4, 0.2, 0)),
    "rectangle": lambda: light(
        "AREA", energy=100, shape="RECTANGLE", size=1.0, size_y=0.5, rotation_euler=(0.2, 0.3, 0.4), color=(1, 0.5, 0.25)
    ),
    "square": lambda: light("AREA", energy=80, shape="SQUARE", size=0.7),
    "sphere": lambda: light("POINT", energy=120, shadow_soft_size=0.2),
    "point": lambda: light("POINT", energy=120, shadow_soft_size=0.0),
    "spot": lambda: light("SPOT", energy=300, shadow_soft_size=0.0, spot_size=math.radians(24), spot_blend=0.0, location=(0, 0, 4)),
}
for name, make in LIGHTS.items():
    fresh()
    ground(Color=(0.7, 0.6, 0.5, 1))
    make()
    alike(name, 0.002)

scene = fresh()
ground(Color=(0.7, 0.6, 0.5, 1))
scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.4, 0.5, 1)
scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 1.5
alike("world", 0.002)

for name, change in {
    "upright sensor": lambda s: (setattr(s.render, "resolution_x", 48), setattr(s.render, "resolution_y", 64)),
    "vertical fit": lambda s: setattr(s.camera.data, "sensor_fit", "VERTICAL"),
    "orthographic": lambda s: (setattr(s.camera.data, "type", "ORTHO"), setattr(s.camera.data, "ortho_scale", 5)),
    "half size": lambda s: setattr(s.render, "resolution_percentage", 50),
}.items():
    scene = fresh()
    ground(Color=(0.7, 0.6, 0.5, 1))
    LIGHTS["sphere"]()
    change(scene)
    alike(name, 0.01)

for name, (kind, inputs) in {
    "anisotropic": ("ShaderNodeBsdfAnisotropic", dict(Color=(0.9, 0.8, 0.7, 1), Roughness=0.5, Anisotropy=0.5, Rotation=0.1)),
    "anisotropic along": ("ShaderNodeBsdfAnisotropic", dict(Color=(0.9, 0.8, 0.7, 1), Roughness=0.5, Anisotropy=-0.4)),
}.items():
    fresh()
    ground(kind, **inputs).data.materials[0].node_tree.nodes
    for node in bpy.data.materials["ground"].node_tree.nodes:
        if node.type == "BSDF_ANISOTROPIC":
            node.distribution = "GGX"
    LIGHTS["rectangle"]()
    alike(name, 0.004)

# --- several materials, an instance, text, what is hidden, and what has no counterpart ---
scene = fresh()
item = ground(Color=(0.7, 0.6, 0.5, 1))
emitting = bpy.data.materials.new("lamp")
emitting.use_nodes = True
emitting.node_tree.nodes.clear()
tree = emitting.node_tree
tree.links.new(tree.nodes.new("ShaderNodeEmission").outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
item.data.materials.append(emitting)
item.data.polygons[5].material_index = 1
add("words", bpy.data.curves.new("words", "FONT")).data.body = "taut"
add("hidden", item.data).hide_render = True
add("nothing", bpy.data.meshes.new("nothing"))
light("AREA", shape="DISK", energy=10)
scene.camera.data.shift_x = 0.1
described = taut_render.Description(bpy.context, 4)
assert sorted(entry["name"] for entry in described.tree["mesh"]) == ["ground", "words"], described.tree["mesh"]
for part in (
    "disk is taken as the rectangle",
    "Emission at its output is taken as grey paint",
    "its shift is left out",
    "'nothing': has no faces",
):
    assert any(part in warning for warning in described.warnings), (part, described.warnings)
assert bpy.ops.taut.render(samples=4) == {"FINISHED"}

scene.camera = None
try:
    bpy.ops.taut.render(samples=4)
    raise AssertionError("rendered without a camera")
except RuntimeError as error:
    assert "The scene has no camera" in str(error)
print("ALL RIGHT")
