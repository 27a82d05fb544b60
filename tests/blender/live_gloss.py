"""The add-on's live gloss in Blender: an armature with shape keys, a cloth and a lattice, frame by frame against taut.gloss of the same
positions; then everything that may go wrong, which must leave a message.

    blender -b -noaudio --factory-startup --python-exit-code 1 --python live_gloss.py -- ADDON_FOLDER PACKAGE_FOLDER SCRATCH
"""

import math
import os
import sys

import bpy
import numpy as np

addon, package, scratch = sys.argv[sys.argv.index("--") + 1 :]
sys.path[:0] = [addon, package]
import taut  # noqa: E402: found in PACKAGE_FOLDER
import taut_gloss  # noqa: E402: found in ADDON_FOLDER
from taut_gloss import attributes, live, material  # noqa: E402

FRAMES = range(1, 25)


def fresh():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = FRAMES[0], FRAMES[-1]
    return scene


def add(item):
    bpy.context.scene.collection.objects.link(item)
    return item


def mesh_of(name, points, faces, uv=None, smooth=True):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], faces.tolist())
    mesh.polygons.foreach_set("use_smooth", np.full(len(faces), smooth))
    if uv is not None:
        mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", uv[faces.ravel()].ravel())
    mesh.update()
    return mesh


def sheet(size, scale=1.0):
    x, y = np.meshgrid(np.linspace(0, 1, size, dtype="f4"), np.linspace(0, 1, size, dtype="f4"))
    first = np.arange(size * (size - 1)).reshape(size - 1, size)[:, :-1].ravel()
    faces = np.stack([first, first + 1, first + size + 1, first + size], -1)
    return np.stack([scale * (x - 0.5), scale * (y - 0.5), 0 * x], -1).reshape(-1, 3), faces, np.stack([x, y], -1).reshape(-1, 2)


def tube(around=24, along=16):
    angle, height = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.linspace(0, 2, along + 1))
    points = np.stack([0.3 * np.cos(angle), 0.3 * np.sin(angle), height], -1).reshape(-1, 3).astype("f4")
    i, j = np.meshgrid(np.arange(around), np.arange(along))
    n = (i + 1) % around
    return points, np.stack([j * around + i, j * around + n, (j + 1) * around + n, (j + 1) * around + i], -1).reshape(-1, 4)


def enable(item, **settings):
    for name, value in settings.items():
        setattr(item.taut, name, value)
    item.taut.enabled = True
    return item


def shown(item):
    """Attributes as a renderer sees them, of the evaluated mesh, and its points."""
    mesh = item.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    return attributes.vectors_of(mesh, live.M), attributes.vectors_of(mesh, live.TANGENT), attributes.points_of(mesh)


def follow(name, item, rest, least_change):
    """All frames against Taut's own evaluation."""
    settings, mesh = item.taut, item.data
    faces, uv = attributes.faces_of(mesh), attributes.uv_of(mesh)
    worst, moved, seen = 0.0, 0.0, []
    for frame in FRAMES:
        bpy.context.scene.frame_set(frame)
        assert settings.message == "", settings.message
        m, tangent, points = shown(item)
        per = "point" if len(m) == len(points) else "corner"
        expected = taut.gloss(rest, points, faces, uv, per=per, **{**settings.material(), "alpha": live.alphas_of(item)})
        worst = max(worst, float((np.abs(m - expected.M[:, :3]) / np.maximum(1, np.abs(expected.M[:, :3]))).max()))
        worst = max(worst, float(np.abs(tangent - expected.tangent).max()))
        moved = max(moved, float(np.abs(expected.stretch - 1).max()))
        seen.append(m.copy())
    assert worst <= 1e-6, (name, worst)
    assert moved > least_change, (name, moved)
    assert np.abs(seen[0] - seen[-1]).max() > 1e-3
    print(f"{name}: {len(mesh.vertices)} points, {len(FRAMES)} frames, attributes differ by {worst:.1e}, stretch to {1 + moved:.2f}")
    return seen


def armature():
    fresh()
    points, faces = tube()
    item = add(bpy.data.objects.new("limb", mesh_of("limb", points, faces)))
    item.shape_key_add(name="Basis")
    bulge = item.shape_key_add(name="Bulge")
    grown = points.copy()
    grown[:, :2] *= (1 + 0.6 * np.exp(-8 * (points[:, 2:] - 1) ** 2)).astype("f4")
    bulge.data.foreach_set("co", grown.ravel())
    for frame, value in ((1, 0.0), (24, 1.0)):
        bulge.value = value
        bulge.keyframe_insert("value", frame=frame)
    bones = add(bpy.data.objects.new("bones", bpy.data.armatures.new("bones")))
    bpy.context.view_layer.objects.active = bones
    bpy.ops.object.mode_set(mode="EDIT")
    lower, upper = (bones.data.edit_bones.new(name) for name in ("lower", "upper"))
    lower.head, lower.tail, upper.head, upper.tail = (0, 0, 0), (0, 0, 1), (0, 0, 1), (0, 0, 2)
    upper.parent = lower
    bpy.ops.object.mode_set(mode="OBJECT")
    share = np.clip(points[:, 2] - 0.5, 0, 1)
    for name, weights in (("lower", 1 - share), ("upper", share)):
        group = item.vertex_groups.new(name=name)
        for i, weight in enumerate(weights):
            group.add([i], float(weight), "REPLACE")
    item.modifiers.new("Armature", "ARMATURE").object = bones
    pose = bones.pose.bones["upper"]
    pose.rotation_mode = "XYZ"
    for frame, angle in ((1, 0), (24, 70)):
        pose.rotation_euler = (math.radians(angle), 0, math.radians(angle / 2))
        pose.keyframe_insert("rotation_euler", frame=frame)
    return enable(item, alpha=(0.08, 0.3), poisson=0.5), points


def cloth():
    fresh()
    points, faces, uv = sheet(21)
    item = add(bpy.data.objects.new("cloth", mesh_of("cloth", points, faces, uv)))
    pinned = item.vertex_groups.new(name="pinned")
    pinned.add([int(i) for i in np.flatnonzero((points[:, 1] > 0.49) & (np.abs(points[:, 0]) > 0.4))], 1.0, "REPLACE")
    modifier = item.modifiers.new("Cloth", "CLOTH")
    modifier.settings.vertex_group_mass = "pinned"
    modifier.settings.tension_stiffness = modifier.settings.compression_stiffness = 1.0
    modifier.settings.shear_stiffness = 0.5
    modifier.point_cache.frame_start, modifier.point_cache.frame_end = FRAMES[0], FRAMES[-1]
    return enable(item, alpha=(0.1, 0.3), rotation=0.4), points


def lattice():
    fresh()
    points, faces, uv = sheet(25, 2.0)
    item = add(bpy.data.objects.new("sheet", mesh_of("sheet", points, faces, uv, smooth=False)))
    cage = add(bpy.data.objects.new("cage", bpy.data.lattices.new("cage")))
    cage.scale = (2.2, 2.2, 2.2)
    cage.data.points_u = cage.data.points_v = cage.data.points_w = 3
    cage.shape_key_add(name="Basis")
    bent = cage.shape_key_add(name="Bent")
    for i, point in enumerate(bent.data):
        point.co.x += 0.4 * point.co.y + 0.15 * (i % 2)
        point.co.z += 0.3 * point.co.x
    for frame, value in ((1, 0.0), (24, 1.0)):
        bent.value = value
        bent.keyframe_insert("value", frame=frame)
    item.modifiers.new("Lattice", "LATTICE").object = cage
    return enable(item, alpha=(0.2, 0.2), roughening=0.4, yield_strain=0.01), points


taut_gloss.register()
for name, make, least in (("armature with shape keys", armature, 0.3), ("cloth", cloth, 0.02), ("lattice", lattice, 0.2)):
    item, rest = make()
    seen = follow(name, item, rest, least)
    if name != "cloth":  # a simulation goes forward
        bpy.context.scene.frame_set(12)
        assert np.abs(shown(item)[0] - seen[11]).max() == 0

# --- a change of a pose or a shape key without a change of the frame ---
item, rest = armature()
scene = bpy.context.scene
scene.frame_set(1)
before = shown(item)[0].copy()
item.data.shape_keys.animation_data_clear()
item.data.shape_keys.key_blocks["Bulge"].value = 0.7
bpy.context.view_layer.update()
bpy.context.view_layer.update()
assert np.abs(shown(item)[0] - before).max() > 0.1

# --- rest: a frame, an object ---
item, rest = lattice()
scene = bpy.context.scene
item.taut.rest = "FRAME"
assert "Take Rest" in item.taut.message
item.taut.rest_frame = 24
bpy.context.view_layer.objects.active = item
assert bpy.ops.taut.take_rest() == {"FINISHED"}
scene.frame_set(24)
assert item.taut.message == ""
m, _, points = shown(item)
np.testing.assert_allclose(np.abs(m), np.tile([5, 0, 5], (len(m), 1)), atol=2e-3)
scene.frame_set(1)
assert np.abs(shown(item)[0] - [5, 0, 5]).max() > 0.5
item.taut.rest = "OBJECT"
assert "Choose" in item.taut.message
item.taut.rest_object = add(bpy.data.objects.new("rest", bpy.data.meshes.new_from_object(item)))
assert item.taut.message == ""
np.testing.assert_allclose(shown(item)[0], np.tile([5, 0, 5], (len(m), 1)), atol=2e-3)
other = add(bpy.data.objects.new("other", mesh_of("other", *sheet(3)[:2])))
item.taut.rest_object = other
assert "has 9 points, expected 625" in item.taut.message

# --- presets, and alpha of an attribute ---
bpy.context.view_layer.objects.active = item
item.taut.rest = "BIND"
for name, preset in taut.presets.items():
    assert bpy.ops.taut.take_preset(preset=name) == {"FINISHED"}
    for key, value in preset.items():
        np.testing.assert_allclose(getattr(item.taut, key), value, rtol=1e-6)
scene.frame_set(24)
roughened = shown(item)[0].copy()
item.taut.roughening = 0
assert np.abs(shown(item)[0] - roughened).max() > 0.5
item.taut.alpha_attribute = "fine"
assert "has no attribute 'fine' of numbers at its points" in item.taut.message, item.taut.message
mesh = item.data
for kind, key, columns in (("FLOAT", "value", 1), ("FLOAT2", "vector", 2), ("FLOAT_VECTOR", "vector", 3), ("FLOAT_COLOR", "color", 4)):
    values = np.random.default_rng(columns).uniform(0.05, 0.5, (len(mesh.vertices), columns)).astype("f4")
    attributes.remove(mesh, "fine")
    mesh.attributes.new("fine", kind, "POINT").data.foreach_set(key, values.ravel())
    mesh.update()
    bpy.context.view_layer.update()
    scene.frame_set(24)
    assert item.taut.message == "", item.taut.message
    m, tangent, points = shown(item)
    options = {**item.taut.material(), "alpha": values[:, [0, min(columns, 2) - 1]]}
    per = "point" if len(m) == len(points) else "corner"
    expected = taut.gloss(rest, points, attributes.faces_of(mesh), attributes.uv_of(mesh), per=per, **options)
    assert np.abs(m - expected.M[:, :3]).max() <= 1e-5, kind
item.taut.alpha_attribute = ""

# --- topology, emptiness, users, edit mode, bad settings ---
item, rest = lattice()
scene = bpy.context.scene
scene.frame_set(5)
subdivision = item.modifiers.new("Subdivision", "SUBSURF")
scene.frame_set(6)
assert "change the topology (Lattice, Subdivision)" in item.taut.message, item.taut.message
item.modifiers.remove(subdivision)
scene.frame_set(7)
assert item.taut.message == ""

bpy.context.view_layer.objects.active = item
bpy.ops.object.mode_set(mode="EDIT")
scene.frame_set(8)
assert "edit mode" in item.taut.message
bpy.ops.mesh.select_all(action="SELECT")
bpy.ops.mesh.subdivide(number_cuts=1)
bpy.ops.object.mode_set(mode="OBJECT")
scene.frame_set(9)
assert item.taut.message == "" and len(item.data.vertices) == 49 * 49
m, _, points = shown(item)
assert len(m) in (len(points), len(item.data.loops))

twin = add(bpy.data.objects.new("twin", item.data))
scene.frame_set(10)
assert "has 2 users" in item.taut.message
bpy.context.view_layer.objects.active = item
assert bpy.ops.taut.single_user() == {"FINISHED"}
scene.frame_set(11)
assert item.taut.message == "" and item.data != twin.data

empty = add(bpy.data.objects.new("empty", bpy.data.meshes.new("empty")))
enable(empty)
assert empty.taut.message == "The mesh has no faces"
loose = add(bpy.data.objects.new("loose", bpy.data.meshes.new("loose")))
loose.data.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0), (5, 5, 5)], [], [(0, 1, 2)])
enable(loose)
assert loose.taut.message == "" and np.isfinite(shown(loose)[0]).all()
wild = add(bpy.data.objects.new("wild", mesh_of("wild", np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))))
enable(wild)
wild.data.vertices[0].co.x = float("nan")
wild.data.update()
scene.frame_set(12)
assert "not finite" in wild.taut.message, wild.taut.message
scene.frame_set(13)
bpy.data.objects.remove(wild)
scene.frame_set(14)

# --- undo, save and reopen ---
item, rest = lattice()
scene = bpy.context.scene
bpy.ops.ed.undo_push(message="before")
scene.frame_set(24)
expected = shown(item)[0].copy()
item.taut.alpha = (0.5, 0.5)
bpy.ops.ed.undo_push(message="after")
scene.frame_set(23)
assert np.abs(shown(item)[0] - expected).max() > 0.5
bpy.ops.ed.undo()
item = bpy.data.objects["sheet"]
bpy.context.scene.frame_set(24)
assert item.taut.message == "" and np.abs(shown(item)[0] - expected).max() < 1e-5, "undo"
path = os.path.join(scratch, "saved.blend")
item.taut.rest_frame = 3
bpy.ops.wm.save_as_mainfile(filepath=path)
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.open_mainfile(filepath=path)
item = bpy.data.objects["sheet"]
assert item.taut.enabled and item.taut.rest_frame == 3
assert np.abs(shown(item)[0] - expected).max() < 1e-5, "reopened"
bpy.context.scene.frame_set(12)
bpy.context.scene.frame_set(24)
assert item.taut.message == "" and np.abs(shown(item)[0] - expected).max() < 1e-5, "reopened and played"

# --- bake ---
scene = bpy.context.scene
bpy.context.view_layer.objects.active = item
item.taut.cache = "//baked/"
scene.frame_end = 6
assert bpy.ops.taut.bake() == {"FINISHED"} and item.taut.use_cache
assert sorted(os.listdir(os.path.join(scratch, "baked"))) == [f"sheet.{f:04}.npz" for f in range(1, 7)]
baked = {}
for frame in (2, 6):
    scene.frame_set(frame)
    assert item.taut.message == ""
    baked[frame] = shown(item)[0].copy()
scene.frame_set(9)
assert "No baked gloss for frame 9" in item.taut.message
item.taut.use_cache = False
for frame in (2, 6):
    scene.frame_set(frame)
    assert np.abs(shown(item)[0] - baked[frame]).max() == 0

# --- the material button ---
for kind, names in (
    ("ShaderNodeBsdfPrincipled", ("Roughness", "Anisotropic", "Anisotropic Rotation", "Tangent")),
    ("ShaderNodeBsdfAnisotropic", ("Roughness", "Anisotropy", "Rotation", "Tangent")),
    ("ShaderNodeBsdfGlossy", None),
):
    if not hasattr(bpy.types, kind):
        continue
    made = bpy.data.materials.new(kind)
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    node, output = tree.nodes.new(kind), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    item.data.materials.clear()
    item.data.materials.append(made)
    assert bpy.ops.taut.set_material() == {"FINISHED"}
    node = output.inputs["Surface"].links[0].from_node
    for name in names or ("Roughness", "Anisotropy", "Rotation", "Tangent"):
        assert node.inputs[name].is_linked, (kind, name)
    count = len(tree.nodes)
    assert bpy.ops.taut.set_material() == {"FINISHED"} and len(tree.nodes) == count  # twice is once
item.data.materials.clear()
assert bpy.ops.taut.set_material() == {"FINISHED"} and len(item.data.materials) == 1
item.taut.enabled = False
assert item.data.attributes.get(live.M) is None
assert material.gloss_group().users > 0
taut_gloss.unregister()
taut_gloss.register()
taut_gloss.unregister()
print("ALL RIGHT")
