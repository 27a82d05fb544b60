"""Camera, lights and unbiased settings of Cycles for scenes of Taut: shared by the scripts here.

Dictionaries have the keys of a scene file (docs/scene.md).
"""

import math

import bpy
from mathutils import Matrix, Vector


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


def set_cycles(scene, render, spp):
    settings = scene.render
    settings.engine = "CYCLES"
    settings.resolution_x, settings.resolution_y = render.get("width", 960), render.get("height", 540)
    settings.resolution_percentage = 100
    settings.film_transparent = settings.use_motion_blur = settings.use_compositing = settings.use_sequencer = False
    settings.dither_intensity = 0
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.seed = "CPU", spp, 0
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
