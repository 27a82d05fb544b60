"""Textures and emission in Render with Taut against Cycles: images in files, packed and made here, what shines, the world's panorama.

    blender -b -noaudio --factory-startup --python-exit-code 1 --python live_textures.py -- ADDON_FOLDER PACKAGE_FOLDER SCRATCH
"""

import math
import os
import sys

import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(__file__))
from beside_cycles import add, alike, fresh, ground, light, pictures, scratch, taut_render  # noqa: E402
from taut_gloss import versions  # noqa: E402

SIDE = 64


def waves(low, high, channels=3):
    """Texels in rows from the bottom that no turn or mirror leaves alone, smooth where they repeat."""
    u, v = np.meshgrid((np.arange(SIDE) + 0.5) / SIDE * 2 * np.pi, (np.arange(SIDE) + 0.5) / SIDE * 2 * np.pi)
    parts = [0.5 + 0.25 * np.sin(u + i) + 0.25 * np.sin((1 + i % 2) * v + 0.7 * i) * np.cos(u) for i in range(channels)]
    return (low + (high - low) * np.stack(parts, -1)).astype(np.float32)


def set_space(image, space):
    if space == "Linear":
        versions.set_linear(image.colorspace_settings)
    else:
        image.colorspace_settings.name = space


def image_of(name, texels, space="sRGB", floats=False, saved=True):
    """An image of texels as they are stored; in a file of the scratch folder, or only here."""
    height, width, channels = texels.shape
    image = bpy.data.images.new(name, width, height, float_buffer=floats, alpha=channels == 4)
    set_space(image, space)
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :channels] = texels
    image.pixels.foreach_set(rgba.ravel())
    if not saved:
        return image
    path = os.path.join(scratch, name + (".exr" if floats else ".png"))
    image.filepath_raw, image.file_format = path, "OPEN_EXR" if floats else "PNG"
    image.save()
    bpy.data.images.remove(image)
    image = bpy.data.images.load(path)
    set_space(image, space)
    return image


def shader():
    tree = bpy.data.materials["ground"].node_tree
    return tree, next(node for node in tree.nodes if node.type not in ("OUTPUT_MATERIAL", "TANGENT"))


def linked(image, socket, output="Color", **settings):
    tree, _ = shader()
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    for name, value in settings.items():
        setattr(node, name, value)
    tree.links.new(node.outputs[output], shader()[1].inputs[socket] if isinstance(socket, str) else socket)
    return node


def lamp(**settings):
    light("AREA", **{"energy": 100, "shape": "RECTANGLE", "size": 1.0, "size_y": 0.5, "rotation_euler": (0.2, 0.3, 0.4), **settings})


def described():
    return taut_render.Description(bpy.context, 4)


def without_warnings(name, most, samples=64):
    found = described()
    assert not found.warnings, (name, found.warnings)
    alike(name, most, samples)


# --- base colour: an image in a file, repeated, mapped, held at its edge; packed and made here are the same picture ---
def coloured(**settings):
    fresh()
    ground(Color=(0.7, 0.6, 0.5, 1))
    lamp()
    return linked(image_of("colour", waves(0.1, 0.9)), "Color", **settings)


coloured()
without_warnings("a colour by an image", 0.001)
of_file = pictures(4)[1]
node = coloured()
node.image.pack()
os.remove(os.path.join(scratch, "colour.png"))
assert np.array_equal(pictures(4)[1], of_file), "packed"
node = coloured()
node.image = image_of("made here", waves(0.1, 0.9), saved=False)
np.testing.assert_allclose(pictures(4)[1], of_file, rtol=1e-5, err_msg="made here")
assert described().tree["material"]["ground"]["color"]["file"].startswith(bpy.app.tempdir)

coloured(extension="EXTEND")
without_warnings("an image held at its edge", 0.001)
node = coloured()
tree = shader()[0]
mapping = tree.nodes.new("ShaderNodeMapping")
mapping.inputs["Scale"].default_value = (0.5, 1.5, 1)
tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["UV"], mapping.inputs["Vector"])
tree.links.new(mapping.outputs[0], node.inputs["Vector"])
without_warnings("an image mapped by a scale", 0.001)
node = coloured()
node.image = image_of("linear", waves(0.1, 0.9), "Non-Color", floats=True)
without_warnings("an image of floats", 0.001)

# --- Principled: base colour, roughness and metallic ---
fresh()
ground("ShaderNodeBsdfPrincipled", Metallic=1.0)
lamp(size=3, size_y=2)
shader()[1].distribution = "GGX"
tree = shader()[0]
linked(image_of("colour", waves(0.3, 0.9)), "Base Color")
split = tree.nodes.new("ShaderNodeSeparateColor")
linked(image_of("rough", waves(0.3, 0.9), "Non-Color"), split.inputs[0])
tree.links.new(split.outputs["Green"], shader()[1].inputs["Roughness"])
without_warnings("a Principled metal by images", 0.001)
rough = described().tree["material"]["ground"]
assert rough["roughness"]["channel"] == "g" and rough["roughness"]["color_space"] == "linear" and "alpha" not in rough
tree.links.new(split.outputs["Blue"], shader()[1].inputs["Metallic"])
assert described().tree["material"]["ground"]["metallic"]["channel"] == "b"
grey = linked(image_of("grey", np.repeat(waves(0.3, 0.9, 1), 3, 2), "Non-Color"), "Metallic")
assert described().tree["material"]["ground"]["metallic"]["channel"] == "r" and not described().warnings
grey.image = image_of("coloured", waves(0.1, 0.9), "Non-Color")
assert any("its green stands for its luminance" in warning for warning in described().warnings)

# --- a normal map ---
fresh()
ground(Color=(0.7, 0.6, 0.5, 1))
lamp()
tree = shader()[0]
u, v = np.meshgrid((np.arange(SIDE) + 0.5) / SIDE * 2 * np.pi, (np.arange(SIDE) + 0.5) / SIDE * 2 * np.pi)
normals = np.stack([0.3 * np.sin(u), 0.2 * np.cos(v), 1 + 0 * u], -1)
normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
bumps = tree.nodes.new("ShaderNodeNormalMap")
linked(image_of("normals", (0.5 + 0.5 * normals).astype("f4"), "Non-Color", floats=True), bumps.inputs["Color"])
tree.links.new(bumps.outputs[0], shader()[1].inputs["Normal"])
without_warnings("a normal map", 0.002)


# --- a surface that is partly there ---
scene = fresh()
ground("ShaderNodeBsdfPrincipled", Metallic=1.0, Roughness=0.5)
scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.2, 0.3, 0.4, 1)
lamp(size=3, size_y=2)
shader()[1].distribution = "GGX"
linked(image_of("holes", np.round(waves(0, 1, 4)), "sRGB"), "Alpha", "Alpha")
without_warnings("a surface with holes", 0.003)


# --- what shines ---
def emitter(kind, colour, strength):
    made = bpy.data.materials.new("shining")
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    node = tree.nodes.new(kind)
    for name, value in (("Color", colour), ("Emission", colour), ("Emission Color", colour)):
        if name in node.inputs and (kind == "ShaderNodeEmission") == (name == "Color"):
            node.inputs[name].default_value = (*colour, 1)
    node.inputs["Strength" if kind == "ShaderNodeEmission" else "Emission Strength"].default_value = strength
    if kind != "ShaderNodeEmission":
        node.inputs["Base Color"].default_value = (0, 0, 0, 1)
        node.inputs["Specular" if "Specular" in node.inputs else "Specular IOR Level"].default_value = 0.5
    tree.links.new(node.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return made


def panel(made, location=(0.4, 0.8, 0.9)):
    mesh = bpy.data.meshes.new("panel")
    # Flat, so that it is the same whatever its diagonal.
    mesh.from_pydata([(-1, -0.3, -0.2), (1, -0.3, 0.2), (1, 0.3, 0.8), (-1, 0.3, 0.4)], [], [(0, 1, 2, 3)])
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", np.array([0, 0, 1, 0, 1, 1, 0, 1], "f4"))
    mesh.materials.append(made)
    return add("panel", mesh, location=location)


for kind in ("ShaderNodeEmission", "ShaderNodeBsdfPrincipled"):
    fresh()
    ground(Color=(0.7, 0.6, 0.5, 1))
    panel(emitter(kind, (1, 0.5, 0.2), 3))
    without_warnings("light of " + kind, 0.002)
fresh()
ground(Color=(0.7, 0.6, 0.5, 1))
twins = panel(emitter("ShaderNodeEmission", (1, 0.5, 0.2), 3), (-1, 0.8, 0.9)), panel(bpy.data.materials["shining"], (1.5, 0, 0.5))
twins[1].data = twins[0].data
shining = described().tree
assert [entry["mesh"] for entry in shining["light"]] == ["panel", "panel.001"]
alike("two users of a mesh that shines", 0.002)

fresh()
item = ground(Color=(0.7, 0.6, 0.5, 1))
item.data.materials.append(emitter("ShaderNodeEmission", (0.2, 0.5, 1), 2))
for face in (20, 27, 28):
    item.data.polygons[face].material_index = 1
panel(bpy.data.materials["ground"], (0, 0.6, 1))
without_warnings("some faces shine", 0.002)

fresh()
ground(Color=(0.7, 0.6, 0.5, 1))
made = emitter("ShaderNodeEmission", (1, 1, 1), 4)
node = made.node_tree.nodes.new("ShaderNodeTexImage")
node.image = image_of("glow", waves(0, 1))
made.node_tree.links.new(node.outputs["Color"], next(n for n in made.node_tree.nodes if n.type == "EMISSION").inputs["Color"])
panel(made)
without_warnings("an image that shines", 0.01, 1024)  # noisier: its texels are met by chance

# --- the world ---
for turn in (0.0, 0.8):
    scene = fresh()
    ground(Color=(0.7, 0.6, 0.5, 1))
    tree = scene.world.node_tree
    background = tree.nodes["Background"]
    background.inputs["Strength"].default_value = 1.5
    node, mapping = tree.nodes.new("ShaderNodeTexEnvironment"), tree.nodes.new("ShaderNodeMapping")
    node.image = image_of("sky", np.repeat(waves(0.0, 2.0), 2, 1) ** 2, "Linear", floats=True)
    mapping.inputs["Rotation"].default_value = (0, 0, turn)
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs[0], node.inputs["Vector"])
    tree.links.new(node.outputs["Color"], background.inputs["Color"])
    scene.camera.rotation_euler[0] = math.radians(75)
    without_warnings(f"a world by an image, turned by {turn}", 0.005)

# --- what cannot be said ---
node = coloured()
tree = shader()[0]
for make, said in (
    (lambda: tree.nodes.new("ShaderNodeTexNoise").outputs["Color"], "what is linked to Color (Noise Texture) is left out"),
    (lambda: linked(None, "Color").outputs["Color"], "(an Image Texture without an image)"),
):
    tree.links.new(make(), shader()[1].inputs["Color"])
    assert any(said in warning for warning in described().warnings), described().warnings
tree.links.new(node.outputs["Color"], shader()[1].inputs["Color"])
uv = tree.nodes.new("ShaderNodeUVMap")
uv.uv_map = "other"
tree.links.new(uv.outputs[0], node.inputs["Vector"])
assert any("the UV map 'other', which is not the active one" in warning for warning in described().warnings), described().warnings
tree.links.remove(node.inputs["Vector"].links[0])
node.extension = "CLIP"
assert any("repeats, instead of clip" in warning for warning in described().warnings)
os.remove(os.path.join(scratch, "colour.png"))
assert any("which is missing" in warning for warning in described().warnings), described().warnings
assert bpy.ops.taut.render(samples=4) == {"FINISHED"}
print("ALL RIGHT")
