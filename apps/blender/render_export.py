"""Renders files of `taut export` with Cycles under the camera and lights of a Taut scene, as Taut would: for comparison.

    blender -b -noaudio --factory-startup --python-exit-code 1 --python render_export.py -- SCENE.toml FRAME SPP OUT.exr FILE...

FILE: .npz of that frame, one an object. Every object is a metal of reflectance 1 without multiple scattering. Of the scene
file it reads what a comparison needs: [render] width height max_events, [camera] position look_at up fov_deg (constant),
[environment] radiance, [[light]] of type quad and sphere. Everything in Cycles that trades truth for speed is off.
"""

import math
import os
import sys
import tomllib

import bpy
from mathutils import Matrix, Vector

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import taut_gloss  # noqa: E402: found beside this file


def triple(value):
    return [float(value)] * 3 if isinstance(value, (int, float)) else [float(x) for x in value]


def matrix_from(x, y, z, origin):
    matrix = Matrix((x, y, z)).transposed().to_4x4()
    matrix.translation = origin
    return matrix


def add_camera(scene, camera):
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "VERTICAL"
    data.angle_y = math.radians(camera.get("fov_deg", 40))
    data.clip_start, data.clip_end = 1e-3, 1e5
    item = bpy.data.objects.new("camera", data)
    position = Vector(camera["position"])
    z = (position - Vector(camera.get("look_at", (0, 0, 0)))).normalized()
    x = Vector(camera.get("up", (0, 0, 1))).cross(z).normalized()
    item.matrix_world = matrix_from(x, z.cross(x), z, position)
    scene.collection.objects.link(item)
    scene.camera = item


def add_light(scene, light):
    radiance = triple(light.get("radiance", 1))
    strongest = max(radiance)
    kind = light.get("type", "quad")
    if kind == "quad":
        u, v = Vector(light["u"]), Vector(light["v"])
        data = bpy.data.lights.new("quad", "AREA")
        data.shape, data.size, data.size_y, data.spread = "RECTANGLE", u.length, v.length, math.pi
        data.energy = strongest * 4 * u.length * v.length  # Cycles: radiance = power / (4 area)
        z = -u.cross(v).normalized()  # shines along its -z
        x = u.normalized()
        matrix = matrix_from(x, z.cross(x), z, Vector(light["corner"]) + 0.5 * u + 0.5 * v)
    elif kind == "sphere":
        data = bpy.data.lights.new("sphere", "POINT")
        data.shadow_soft_size = light["radius"]
        data.energy = strongest * 4 * math.pi**2 * light["radius"] ** 2  # radiance = power / (pi * 4 pi r^2)
        matrix = Matrix.Translation(Vector(light["centre"]))
    else:
        raise ValueError(f"found a light of type {kind!r}, expected quad or sphere")
    data.color = [c / strongest for c in radiance]
    data.cycles.use_multiple_importance_sampling = True
    data.cycles.max_bounces = 1024
    item = bpy.data.objects.new(kind, data)
    item.matrix_world = matrix
    item.visible_camera = bool(light.get("camera_visible", False))
    scene.collection.objects.link(item)


def set_world(scene, environment):
    if environment and "radiance" not in environment:
        raise ValueError("found an [environment] without radiance, expected a constant one")
    world = bpy.data.worlds.new("world")
    scene.world = world
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*triple(environment.get("radiance", 0)), 1)
    background.inputs["Strength"].default_value = 1.0


def set_cycles(scene, render):
    settings = scene.render
    settings.engine = "CYCLES"
    settings.resolution_x, settings.resolution_y = render.get("width", 960), render.get("height", 540)
    settings.resolution_percentage = 100
    settings.film_transparent = settings.use_motion_blur = settings.use_compositing = settings.use_sequencer = False
    settings.dither_intensity = 0
    cycles = scene.cycles
    cycles.device, cycles.seed = "CPU", 0
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = cycles.light_sampling_threshold = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    events = render.get("max_events", 8)
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = events - 1
    cycles.min_light_bounces = min(events, 1024)  # no Russian roulette
    if hasattr(cycles, "use_light_tree"):
        cycles.use_light_tree = False
    cycles.pixel_filter_type = "BOX"
    scene.view_settings.view_transform = "Raw"
    image = settings.image_settings
    image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGB", "32"
    settings.use_file_extension = False


def build(description, frame, files):
    """An empty scene with the files at a frame, and the scene file's camera and lights."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    for file in files:
        taut_gloss.import_gloss(file, frame)
    add_camera(scene, description["camera"])
    for light in description.get("light", []):
        add_light(scene, light)
    set_world(scene, description.get("environment", {}))
    set_cycles(scene, description.get("render", {}))
    scene.frame_set(frame)
    return scene


def main():
    words = sys.argv[sys.argv.index("--") + 1 :]
    with open(words[0], "rb") as stream:
        description = tomllib.load(stream)
    scene = build(description, int(words[1]), words[4:])
    scene.cycles.samples = int(words[2])
    scene.render.filepath = os.path.abspath(words[3])
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    main()
