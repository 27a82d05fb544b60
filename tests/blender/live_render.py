"""Render with Taut against Cycles: one light, world, camera and material at a time; then what has no counterpart or is not there.

    blender -b -noaudio --factory-startup --python-exit-code 1 --python live_render.py -- ADDON_FOLDER PACKAGE_FOLDER SCRATCH
"""

import math
import os
import sys

import bpy

sys.path.insert(0, os.path.dirname(__file__))
from beside_cycles import add, alike, fresh, ground, light, taut_render  # noqa: E402

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
        if hasattr(node, "distribution"):
            node.distribution = "GGX"
    LIGHTS["rectangle"]()
    alike(name, 0.004)

# --- several materials, an instance, text, what is hidden, and what has no counterpart ---
scene = fresh()
item = ground(Color=(0.7, 0.6, 0.5, 1))
waxy = bpy.data.materials.new("wax")
waxy.use_nodes = True
waxy.node_tree.nodes.clear()
tree = waxy.node_tree
tree.links.new(tree.nodes.new("ShaderNodeSubsurfaceScattering").outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
item.data.materials.append(waxy)
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
    "Subsurface Scattering at its output is taken as grey paint",
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
