"""What the add-on's live gloss adds to a frame: 100k points twisted by a modifier, frames set with it and without, in turns.

    blender -b -noaudio --factory-startup --python apps/blender/live_speed.py -- PACKAGE_FOLDER
"""

import math
import os
import statistics
import sys
import time

import bpy
import numpy as np

sys.path[:0] = [os.path.dirname(os.path.abspath(__file__)), *sys.argv[sys.argv.index("--") + 1 :]]
import taut_gloss  # noqa: E402
from taut_gloss import live  # noqa: E402

SIDE, ROUNDS = 317, 12
bpy.ops.wm.read_factory_settings(use_empty=True)
taut_gloss.register()
scene = bpy.context.scene
x, y = np.meshgrid(np.linspace(-1, 1, SIDE), np.linspace(-1, 1, SIDE))
first = np.arange(SIDE * (SIDE - 1)).reshape(SIDE - 1, SIDE)[:, :-1].ravel()
mesh = bpy.data.meshes.new("sheet")
mesh.from_pydata(
    np.stack([x, y, 0 * x], -1).reshape(-1, 3).tolist(), [], np.stack([first, first + 1, first + SIDE + 1, first + SIDE], -1).tolist()
)
mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), bool))
mesh.uv_layers.new(name="UVMap").data.foreach_set(
    "uv", np.stack([x, y], -1).reshape(-1, 2)[[v for p in mesh.polygons for v in p.vertices]].ravel()
)
item = bpy.data.objects.new("sheet", mesh)
scene.collection.objects.link(item)
twist = item.modifiers.new("Twist", "SIMPLE_DEFORM")
twist.deform_method, twist.deform_axis = "TWIST", "X"
for frame, angle in ((1, 0.0), (24, math.pi)):
    twist.angle = angle
    twist.keyframe_insert("angle", frame=frame)


def frames():
    """Milliseconds of each of the frames."""
    for frame in range(1, 25):
        start = time.perf_counter()
        scene.frame_set(frame)
        yield 1e3 * (time.perf_counter() - start)


rows = {False: [], True: []}
for _ in range(ROUNDS):
    for follows in rows:
        item.taut.enabled = follows
        assert item.taut.message == ""
        rows[follows].append(statistics.median(frames()))
without, with_gloss = (min(rows[follows]) for follows in (False, True))
print(f"{len(mesh.vertices)} points: a frame {without:.1f} ms, with live gloss {with_gloss:.1f} ms, {with_gloss - without:.1f} ms more")
depsgraph = bpy.context.evaluated_depsgraph_get()
for name, call in (
    ("reading the points", lambda: live.evaluated_points(item, depsgraph)),
    ("taut.Gloss.at", lambda p=live.evaluated_points(item, depsgraph): live._kept[item.name_full].gloss.at(p)),
):
    seconds = []
    for _ in range(20):
        start = time.perf_counter()
        call()
        seconds.append(time.perf_counter() - start)
    print(f"of that {name}: {1e3 * min(seconds):.1f} ms")
