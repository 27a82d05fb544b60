"""Cycles as Taut's peer: one set of unbiased settings, one way to render.

    blender -b -noaudio --factory-startup --python-exit-code 1 --python cycles.py -- serve SCENE.json
    blender ... -- render SCENE.toml FRAME SPP OUT.exr [seed=N] FILE...
    blender ... -- compare REFERENCE.exr OUT.png NAME=IMAGE.exr... [materials=NUMBERS.exr:NAME,...]

serve, for taut_bench and taut chart: builds a scene once, then renders what it is asked for. SCENE.json and the binary meshes beside it
are written by them (apps/study/measures/cycles_peer.cpp says what is in them). Requests come on standard input, one JSON object a line:
{"frame", "spp", "seed", "width", "height", "output"}; frame counts from 0, an empty output saves nothing. Each is answered by one line
"CYCLES {json}": seconds of the render call, and the peak memory in MB. Scene data stay in memory between renders, so that a render of
the same frame is path tracing alone.

render: files of `taut export` (.npz of that frame, one an object; each a metal of reflectance 1 without multiple scattering) under the
camera and lights of a Taut scene. Of the scene file it reads [render] width height max_events, [camera] position look_at up fov_deg
(constant), [environment] radiance, [[light]] of type quad and sphere.

compare: a picture. OUT.png: the reference, then for each image the image itself and under it its difference, grey
0.5 + 2 (image - reference) / scale, where scale is the 99th percentile of the reference. With materials: the mean colour of each one's
pixels as a ratio. Numbers of pictures are those of `taut compare`.

Whatever trades truth for speed is off: no clamps, no blurred gloss, no light threshold, no adaptive sampling, no denoising, no
Russian roulette. Dictionaries have the keys of a scene file (docs/scene.md).
"""

import json
import math
import os
import re
import sys
import time

import bpy
import numpy
from mathutils import Matrix, Vector

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from taut_gloss import versions  # noqa: E402
FOLDER = ""


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
        data.energy = versions.rectangle_power(strongest, u.length * v.length)
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


def array(name, kind, columns):
    return numpy.fromfile(os.path.join(FOLDER, name), kind).reshape(-1, columns)


def add_mesh(scene, description, materials):
    points = array(description["points"][0], "<f4", 3)
    triangles = array(description["triangles"], "<i4", 3)
    corner_uvs = array(description["corner_uvs"], "<f4", 2)
    mesh = bpy.data.meshes.new(description["name"])
    mesh.vertices.add(len(points))
    mesh.vertices.foreach_set("co", points.ravel())
    mesh.loops.add(3 * len(triangles))
    mesh.loops.foreach_set("vertex_index", triangles.ravel())
    mesh.polygons.add(len(triangles))
    mesh.polygons.foreach_set("loop_start", numpy.arange(0, 3 * len(triangles), 3, dtype="i4"))
    versions.set_loop_totals(mesh, numpy.full(len(triangles), 3, "i4"))
    mesh.polygons.foreach_set("use_smooth", numpy.full(len(triangles), True))
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", corner_uvs.ravel())
    mesh.update(calc_edges=True)
    for name in description["materials"]:
        mesh.materials.append(materials[name])
    if "slots" in description:
        mesh.polygons.foreach_set("material_index", array(description["slots"], "<i4", 1).ravel())
    if "corner_normals" in description:
        versions.keep_custom_normals(mesh)
        mesh.normals_split_custom_set(array(description["corner_normals"], "<f4", 3))
    scene.collection.objects.link(bpy.data.objects.new(description["name"], mesh))
    return mesh


def add_material(description):
    """alpha = roughness^2; Cycles' anisotropy < 0 or >= 0 stretches alpha along or across the tangent by 1 - |anisotropy|."""
    material = bpy.data.materials.new(description["name"])
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    kind = description["type"]
    if kind == "conductor":
        node = tree.nodes.new("ShaderNodeBsdfAnisotropic")
        node.distribution = "GGX"
        x, y = description["alpha"]
        node.inputs["Roughness"].default_value = (x * y) ** 0.25
        node.inputs["Anisotropy"].default_value = 1 - math.sqrt(x / y) if x <= y else math.sqrt(y / x) - 1
        tangent = tree.nodes.new("ShaderNodeTangent")
        tangent.direction_type, tangent.uv_map = "UV_MAP", "UVMap"
        tree.links.new(tangent.outputs["Tangent"], node.inputs["Tangent"])
    elif kind == "dielectric":
        node = tree.nodes.new("ShaderNodeBsdfGlass")
        node.distribution = "GGX"
        node.inputs["Roughness"].default_value = math.sqrt(description["alpha"][0])
        node.inputs["IOR"].default_value = description["ior"]
    elif kind == "diffuse":
        node = tree.nodes.new("ShaderNodeBsdfDiffuse")
        node.inputs["Roughness"].default_value = 0
    elif kind == "metallic_roughness":
        add_metallic_roughness(tree, description, output)
        return material
    else:
        raise ValueError(f"found a material of type {kind!r}, expected conductor, dielectric, diffuse or metallic_roughness")
    set_color(tree, description, node)
    tree.links.new(node.outputs["BSDF"], output.inputs["Surface"])
    return material


def set_color(tree, description, node):
    color, texture = description["color"], description.get("color_texture")
    node.inputs["Color"].default_value = (*color, 1)
    if texture is None:
        return
    image = tree.nodes.new("ShaderNodeTexImage")
    path = os.path.join(FOLDER, texture["file"])
    image.image = next((i for i in bpy.data.images if i.filepath == path), None) or bpy.data.images.load(path)
    versions.set_linear(image.image.colorspace_settings)
    image.extension = "REPEAT" if texture["repeats"] else "EXTEND"
    out = image.outputs["Color"]
    if color != [1, 1, 1]:
        scaled = tree.nodes.new("ShaderNodeVectorMath")
        scaled.operation = "MULTIPLY"
        tree.links.new(out, scaled.inputs[0])
        scaled.inputs[1].default_value = color
        out = scaled.outputs["Vector"]
    tree.links.new(out, node.inputs["Color"])


def add_metallic_roughness(tree, description, output):
    """glTF's formula, its Fresnel term at the surface's normal, as Cycles has no node with that at the half vector: a diffuse lobe under a
    dielectric's, mixed with a metal's."""

    def glossy(colored):
        node = tree.nodes.new("ShaderNodeBsdfAnisotropic" if versions.has_one_glossy_node() else "ShaderNodeBsdfGlossy")
        node.distribution = "GGX"
        node.inputs["Roughness"].default_value = math.sqrt(description["alpha"][0])
        if colored:
            set_color(tree, description, node)
        else:
            node.inputs["Color"].default_value = (1, 1, 1, 1)
        return node.outputs["BSDF"]

    def mixed(first, second, share):
        node = tree.nodes.new("ShaderNodeMixShader")
        if isinstance(share, float):
            node.inputs[0].default_value = share
        else:
            tree.links.new(share, node.inputs[0])
        tree.links.new(first, node.inputs[1])
        tree.links.new(second, node.inputs[2])
        return node.outputs["Shader"]

    metallic = float(description["metallic"])
    shader = None
    if metallic < 1:
        diffuse, fresnel = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeFresnel")
        diffuse.inputs["Roughness"].default_value = 0
        set_color(tree, description, diffuse)
        fresnel.inputs["IOR"].default_value = description["ior"]
        shader = mixed(diffuse.outputs["BSDF"], glossy(False), fresnel.outputs["Fac"])
    if metallic > 0:
        metal = glossy(True)
        shader = metal if shader is None else mixed(shader, metal, metallic)
    tree.links.new(shader, output.inputs["Surface"])


def set_environment(scene, description, sampled):
    world = bpy.data.worlds.new("world")
    scene.world = world
    world.use_nodes = True
    tree = world.node_tree
    background = tree.nodes["Background"]
    background.inputs["Strength"].default_value = 1.0
    if "file" in description:
        texture = tree.nodes.new("ShaderNodeTexEnvironment")
        texture.image = bpy.data.images.load(os.path.join(FOLDER, description["file"]))
        versions.set_linear(texture.image.colorspace_settings)
        texture.interpolation = "Linear"
        tree.links.new(texture.outputs["Color"], background.inputs["Color"])
        world.cycles.sampling_method = "MANUAL"
        world.cycles.sample_map_resolution = description["width"]
    else:
        background.inputs["Color"].default_value = (*triple(description.get("radiance", 0)), 1)
        if not sampled:
            world.cycles.sampling_method = "NONE"  # nothing to find in it: scattered rays meet it anyway, and light samples cost rays


def serve(path):
    global FOLDER
    path = os.path.abspath(path)
    FOLDER = os.path.dirname(path)
    with open(path, encoding="utf-8") as stream:
        description = json.load(stream)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    materials = {material["name"]: add_material(material) for material in description["materials"]}
    moving = []
    for item in description["meshes"]:
        mesh = add_mesh(scene, item, materials)
        if len(item["points"]) > 1:
            moving.append((mesh, [array(name, "<f4", 3) for name in item["points"]]))
    add_camera(scene, description["camera"])
    for light in description["lights"]:
        add_light(scene, light)
    set_environment(scene, description["environment"], sampled=False)
    set_cycles(scene, description["render"], 1)
    scene.render.threads_mode, scene.render.threads = "FIXED", description["threads"]
    scene.render.use_persistent_data = True
    versions.set_sobol(scene.cycles)
    frame = 0
    print("CYCLES", json.dumps({"ready": True, "version": bpy.app.version_string}), flush=True)
    for line in sys.stdin:
        request = json.loads(line)
        scene.cycles.samples, scene.cycles.seed = request["spp"], request["seed"]
        scene.render.resolution_x, scene.render.resolution_y = request["width"], request["height"]
        if request["frame"] != frame:
            frame = request["frame"]
            for mesh, positions in moving:
                mesh.vertices.foreach_set("co", positions[frame].ravel())
                mesh.update()
        start = time.perf_counter()
        bpy.ops.render.render()
        seconds = time.perf_counter() - start
        if request["output"]:
            bpy.data.images["Render Result"].save_render(request["output"])
        with open("/proc/self/status", encoding="utf-8") as status:
            peak = int(re.search(r"VmHWM:\s+(\d+)", status.read()).group(1)) / 1024
        print("CYCLES", json.dumps({"seconds": seconds, "peak_mb": peak}), flush=True)


def render(path, frame, spp, output, *files):
    import tomllib

    from taut_gloss import import_gloss

    with open(path, "rb") as stream:
        description = tomllib.load(stream)
    environment = description.get("environment", {})
    if environment and "radiance" not in environment:
        raise ValueError("found an [environment] without radiance, expected a constant one")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    set_cycles(scene, description.get("render", {}), int(spp))
    scene.cycles.seed = next((int(word[5:]) for word in files if word.startswith("seed=")), 0)
    for file in (word for word in files if not word.startswith("seed=")):
        import_gloss(file, int(frame))
    add_camera(scene, description["camera"])
    for light in description.get("light", []):
        add_light(scene, light)
    set_environment(scene, environment, sampled=True)
    scene.frame_set(int(frame))
    scene.render.filepath = os.path.abspath(output)
    bpy.ops.render.render(write_still=True)


def load(path):
    image = bpy.data.images.load(path)
    versions.set_raw(image.colorspace_settings)
    pixels = numpy.empty(len(image.pixels), numpy.float32)
    image.pixels.foreach_get(pixels)
    width, height = image.size
    return pixels.reshape(height, width, -1)[..., :3].astype(numpy.float64)


def save(path, picture):
    height, width = picture.shape[:2]
    image = bpy.data.images.new("comparison", width, height)
    srgb = numpy.where(picture <= 0.0031308, 12.92 * picture, 1.055 * numpy.clip(picture, 1e-9, None) ** (1 / 2.4) - 0.055)
    rgba = numpy.ones((height, width, 4), numpy.float32)
    rgba[..., :3] = numpy.clip(srgb, 0, 1)
    image.pixels.foreach_set(rgba.ravel())
    image.filepath_raw, image.file_format = path, "PNG"
    image.save()


def print_materials(name, image, reference, word):
    """Of each material of FILE:NAME,NAME...: its pixels, whose number in the file's red is theirs, and the ratio of mean colours."""
    file, names = word.split(":", 1)
    numbers = load(file)[..., 0]
    for number, material in enumerate(names.split(","), 1):
        pixels = numpy.abs(numbers - number) < 1e-3
        if pixels.any():
            ratio = image[pixels].mean(0) / numpy.maximum(reference[pixels].mean(0), 1e-9)
            print(f"material {material}: {pixels.sum()} pixels, {name} / reference", *(f"{r:.3f}" for r in ratio))


def compare(path, output, *images):
    reference = load(path)
    scale = numpy.percentile(reference, 99)
    columns = [numpy.concatenate([numpy.full_like(reference, 0.05), reference / scale], 0)]  # rows run upwards
    materials = next((word.split("=", 1)[1] for word in images if word.startswith("materials=")), None)
    for word in images:
        name, file = word.split("=", 1)
        if name == "materials":
            continue
        image = load(file)
        assert image.shape == reference.shape, (name, image.shape, reference.shape)
        if materials:
            print_materials(name, image, reference, materials)
        difference = 0.5 + 2 * (image - reference) / scale
        grey = numpy.clip(difference, 0, 1) ** 2.2  # so that 0.5 is mid grey on screen
        columns.append(numpy.concatenate([grey, image / scale], 0))
    save(output, numpy.concatenate(columns, 1))


def main():
    way, *words = sys.argv[sys.argv.index("--") + 1 :]
    {"serve": serve, "render": render, "compare": compare}[way](*words)


if __name__ == "__main__":
    main()
