"""Reads what `taut export` wrote with Blender's own importers and with the add-on, and compares with the .npz.

    blender -b -noaudio --factory-startup --python-exit-code 1 --python read_export.py -- FOLDER ADDON_FOLDER

FOLDER: m.0001.npz, m.0003.npz, m.####.ply, b.ply and t.ply (binary and text of frame 3), m.glb (frame 3), m.pc2 and m.mdd
(frames 1 to 3), grid.obj (the mesh's file), all of one object.
"""

import os
import sys

import bpy
import numpy

folder, addon = sys.argv[sys.argv.index("--") + 1 :]
sys.path.insert(0, addon)
import taut_gloss  # noqa: E402: found in ADDON_FOLDER
from taut_gloss import versions  # noqa: E402


def points(mesh):
    values = numpy.empty(3 * len(mesh.vertices), numpy.float32)
    mesh.vertices.foreach_get("co", values)
    return values.reshape(-1, 3)


def vectors(mesh, name):
    values = numpy.empty(3 * len(mesh.vertices), numpy.float32)
    mesh.attributes[name].data.foreach_get("vector", values)
    return values.reshape(-1, 3)


def distance(a, b):
    assert a.shape == b.shape, (a.shape, b.shape)
    return float(numpy.abs(a - b).max())


def imported(operator, **arguments):
    before = set(bpy.context.scene.objects)
    operator(**arguments)
    return [item for item in bpy.context.scene.objects if item not in before and item.type == "MESH"][0]


bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
frames = {f: dict(numpy.load(os.path.join(folder, f"m.{f:04}.npz"))) for f in (1, 3)}
assert distance(frames[1]["M"], frames[3]["M"]) > 0.1

# The add-on, over frames.
taut_gloss.register()
for pattern in ("m.####.npz", "m.####.ply"):
    item = taut_gloss.import_gloss(os.path.join(folder, pattern), 1)
    for frame in (3, 1, 3):
        scene.frame_set(frame)
        arrays = frames[frame]
        assert numpy.array_equal(points(item.data), arrays["P"]), pattern
        assert numpy.array_equal(vectors(item.data, "taut_m"), arrays["M"][:, :3])
        assert numpy.array_equal(vectors(item.data, "taut_tangent"), arrays["tangent"])
        versions.split_normals(item.data)
        normals = numpy.empty(3 * len(item.data.loops), numpy.float32)
        item.data.loops.foreach_get("normal", normals)
        assert distance(normals.reshape(-1, 3), arrays["N"][arrays["faces"].ravel()]) < 1e-3  # Blender keeps 16 bits
    assert len(item.data.materials) == int(arrays["face_material"].max()) + 1
    bpy.data.objects.remove(item)
print("add-on: npz and ply over frames")

# The conversion of the node group is that of the file's own columns (--convention blender_anisotropic).
m = frames[3]["M"].astype(float)
a, b, d = m[:, 0], m[:, 1], m[:, 2]
larger = numpy.hypot((a + d) / 2, b / 2) + numpy.hypot((a - d) / 2, b / 2)
assert distance((a * d) ** -0.25, frames[3]["blender_anisotropic_roughness"]) < 1e-5
assert distance(numpy.sqrt(a * d) / larger - 1, frames[3]["blender_anisotropic_anisotropy"]) < 1e-5
turn = numpy.arctan2(-2 * b * d, d * d - a * a - b * b) * 0.25 / numpy.pi - frames[3]["blender_anisotropic_rotation"]
assert numpy.abs(turn - numpy.round(2 * turn) / 2).max() < 1e-5
print("node group: as in the file")

# Blender's own importers.
for name in ("b.ply", "t.ply"):
    operator = bpy.ops.import_mesh.ply if bpy.app.version < (4, 0, 0) else bpy.ops.wm.ply_import
    item = imported(operator, filepath=os.path.join(folder, name))
    assert numpy.array_equal(points(item.data), frames[3]["P"]), name
    assert len(item.data.polygons) == len(frames[3]["faces"])
if not hasattr(numpy, "bool"):  # the glTF importer of 3.4 wants the old alias, numpy 1.24 has dropped it
    numpy.bool = bool
if bpy.app.version >= (4, 0, 0):  # the importer of 4.3 keeps attributes in the file's order and walks them in that of a set (its bug 2658)
    from io_scene_gltf2.blender.imp import mesh as gltf_meshes

    gltf_meshes.set = dict.fromkeys
item = imported(bpy.ops.import_scene.gltf, filepath=os.path.join(folder, "m.glb"), merge_vertices=False)
world = numpy.array(item.matrix_world)
placed = points(item.data) @ world[:3, :3].T + world[:3, 3]
wanted = frames[3]["P"]
used = [i for k in range(frames[3]["face_material"].max() + 1) for i in numpy.unique(frames[3]["faces"][frames[3]["face_material"] == k])]
assert distance(placed, wanted[used]) < 1e-5, distance(placed, wanted[used])
print("PLY and glTF importers: the same points")

# Point caches, through the Mesh Cache modifier on the mesh's own file.
if bpy.app.version < (4, 0, 0):
    item = imported(bpy.ops.import_scene.obj, filepath=os.path.join(folder, "grid.obj"), axis_forward="Y", axis_up="Z", split_mode="OFF")
else:
    item = imported(bpy.ops.wm.obj_import, filepath=os.path.join(folder, "grid.obj"), forward_axis="Y", up_axis="Z")
item.matrix_world.identity()
scene.render.fps, scene.render.fps_base = 24, 1.0
modifier = item.modifiers.new("cache", "MESH_CACHE")
positions = {}
for name, kind in (("m.pc2", "PC2"), ("m.mdd", "MDD")):
    modifier.cache_format, modifier.filepath = kind, os.path.join(folder, name)
    modifier.interpolation, modifier.time_mode, modifier.play_mode = "NONE", "FRAME", "CUSTOM"
    for frame in (1, 3):
        modifier.eval_frame = frame - 1  # counted from the cache's first sample
        evaluated = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
        positions[kind, frame] = points(evaluated.data).copy()
    # Every vertex of the export lies at a point of the cache.
    for frame in (1, 3):
        gaps = numpy.abs(frames[frame]["P"][:, None, :] - positions[kind, frame][None]).max(2).min(1)
        assert gaps.max() < 1e-5, (kind, frame, gaps.max())
assert distance(positions["PC2", 1], positions["PC2", 3]) > 0.1
print("Mesh Cache modifier: PC2 and MDD")
print("READ EVERYTHING")
