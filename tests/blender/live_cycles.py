"""The add-on's live gloss in Cycles against `taut render`: the panel of apps/blender/panel.toml, sheared by a shape key.

    blender -b -noaudio --factory-startup --python-exit-code 1 --python live_cycles.py -- ADDON_FOLDER PACKAGE_FOLDER SCRATCH TAUT SPP

Prints "relMSE NAME VALUE filtered VALUE" against the picture of `taut render` (taut.relative_error): of Cycles with the gloss following, the same as a
frame of an animation, with roughness held fixed, of "Render with Taut", and of Taut's picture with another seed, the noise; then of a
metal that roughens by its strain, against its own picture.
"""

import importlib.util
import os
import subprocess
import sys
import tomllib

import bpy
import numpy as np

addon, package, scratch, command, spp = sys.argv[sys.argv.index("--") + 1 :]
sys.path[:0] = [addon, package]
import taut  # noqa: E402: found in PACKAGE_FOLDER
import taut_gloss  # noqa: E402
from taut_gloss import material  # noqa: E402

# By its path: Blender has a module of this name.
specification = importlib.util.spec_from_file_location("taut_cycles", os.path.join(addon, "cycles.py"))
cycles = importlib.util.module_from_spec(specification)
specification.loader.exec_module(cycles)

FRAME, ROUGHENING, YIELD = 24, 0.375, 0.0625
SCENE = os.path.join(addon, "panel.toml")
with open(SCENE, "rb") as stream:
    described = tomllib.load(stream)


def taut_render(name, *more):
    path = os.path.join(scratch, name)
    subprocess.run([command, "render", SCENE, "--frames", str(FRAME), "--spp", spp, "-q", "-o", path, *more], check=True)
    return cycles.load(path)


def panel():
    """The points, quads and uv of the scene's mesh."""
    points, uvs, faces, corner_uvs = [], [], [], []
    for line in open(os.path.join(addon, described["mesh"][0]["file"]), encoding="utf-8"):
        words = line.split()
        if words[:1] == ["v"]:
            points.append([float(x) for x in words[1:]])
        elif words[:1] == ["vt"]:
            uvs.append([float(x) for x in words[1:3]])
        elif words[:1] == ["f"]:
            faces.append([int(word.split("/")[0]) - 1 for word in words[1:]])
            corner_uvs += [int(word.split("/")[1]) - 1 for word in words[1:]]
    return np.array(points, "f4"), faces, np.array(uvs, "f4")[corner_uvs]


taut_gloss.register()
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
points, faces, uv = panel()
mesh = bpy.data.meshes.new("panel")
mesh.from_pydata(points.tolist(), [], faces)
mesh.polygons.foreach_set("use_smooth", np.ones(len(faces), bool))
mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", uv.ravel())
item = bpy.data.objects.new("panel", mesh)
scene.collection.objects.link(item)
item.shape_key_add(name="Basis")
key = item.shape_key_add(name="Sheared")
sheared = points.copy()
amount = described["mesh"][0]["deform"][0]["amount"][-1]
sheared[:, 0] += np.float32(amount[1]) * points[:, 1]
key.data.foreach_set("co", sheared.ravel())
for frame, value in ((1, 0.0), (FRAME, 1.0)):
    key.value = value
    key.keyframe_insert("value", frame=frame)
mesh.materials.append(bpy.data.materials.new("brushed"))
tree = mesh.materials[0]
tree.use_nodes = True
tree = tree.node_tree
tree.nodes.clear()
node, output = tree.nodes.new("ShaderNodeBsdfAnisotropic"), tree.nodes.new("ShaderNodeOutputMaterial")
node.inputs["Color"].default_value = (1, 1, 1, 1)
tree.links.new(node.outputs[0], output.inputs["Surface"])
item.taut.alpha = described["material"]["brushed"]["alpha"]
item.taut.enabled = True
material.set_up(item)
cycles.add_camera(scene, described["camera"])
for light in described["light"]:
    cycles.add_light(scene, light)
cycles.set_environment(scene, {}, sampled=True)
cycles.set_cycles(scene, described["render"], int(spp))


def render(name):
    scene.render.filepath = os.path.join(scratch, name)
    bpy.ops.render.render(write_still=True)
    return cycles.load(scene.render.filepath)


def render_with_taut():
    assert bpy.ops.taut.render(samples=int(spp)) == {"FINISHED"}
    shown = bpy.data.images["Taut"]
    pixels = np.empty(len(shown.pixels), np.float32)
    shown.pixels.foreach_get(pixels)
    width, height = shown.size
    return pixels.reshape(height, width, 4)[..., :3].astype(np.float64)


images = {}
# As a frame of an animation, from a scene that stands elsewhere: the handler runs inside of the render.
scene.frame_set(1)
scene.frame_start = scene.frame_end = FRAME
scene.render.filepath = os.path.join(scratch, "animation.####.exr")
bpy.ops.render.render(animation=True)
images["cycles_in_an_animation"] = cycles.load(os.path.join(scratch, f"animation.{FRAME:04}.exr"))
scene.frame_set(FRAME)
images["cycles_follow"] = render("follow.exr")
scene.cycles.seed = 7
images["cycles_two_seeds"] = render("seed.exr")
scene.cycles.seed = 0
images["render_with_taut"] = render_with_taut()
item.taut.roughening, item.taut.yield_strain = ROUGHENING, YIELD
images["cycles_roughened"] = render("roughened.exr")
images["render_with_taut_roughened"] = render_with_taut()
item.taut.roughening = 0
# Held fixed: the gloss of the rest shape on the deformed one.
item.taut.enabled = False
rest = taut.gloss(points, points, faces, uv, alpha=tuple(described["material"]["brushed"]["alpha"]), per="corner")
now = taut.gloss(points, sheared, faces, uv, per="corner")
taut_gloss.live.set_vectors(mesh, taut_gloss.live.M, rest.M[:, :3], "CORNER")
taut_gloss.live.set_vectors(mesh, taut_gloss.live.TANGENT, now.tangent, "CORNER")
mesh.update()
images["cycles_fixed"] = render("fixed.exr")
reference = taut_render("taut.exr")
images["taut_other_seed"] = taut_render("again.exr", "--seed", "7")
metal = [f"material.brushed.roughening={ROUGHENING}", f"material.brushed.yield={YIELD}"]
roughened = taut_render("metal.exr", *(word for words in metal for word in ("-D", words)))
images["geometry_alone_roughened"] = images["cycles_follow"]  # geometry alone, beside the metal
for name, image in images.items():
    against = roughened if name.endswith("roughened") else images["cycles_follow"] if name == "cycles_two_seeds" else reference
    raw, filtered = taut.relative_error(image, against), taut.relative_error(image, against, box=4)
    print(f"relMSE {name} {raw:.6g} filtered {filtered:.6g}")
scale = np.percentile(reference, 99)
columns = [np.concatenate([0.5 + 2 * (image - reference) / scale, image / scale], 0) for image in [reference, *images.values()]]
cycles.save(os.path.join(scratch, "live.png"), np.concatenate(columns, 1))
