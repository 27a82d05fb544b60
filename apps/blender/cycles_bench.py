"""Cycles as the peer of taut_bench and taut chart: builds a scene once, then renders what it is asked for.

    blender -b -noaudio --factory-startup --python-exit-code 1 --python cycles_bench.py -- SCENE.json

SCENE.json and the binary meshes beside it are written by them (apps/study/cycles_peer.cpp says what is in them). Requests
come on standard input, one JSON object a line: {"frame", "spp", "seed", "width", "height", "output"}; frame counts from 0, an empty
output saves nothing. Each is answered by one line "CYCLES {json}": seconds of the render call, and the peak memory in MB.

Whatever trades truth for speed is off: no clamps, no blurred gloss, no light threshold, no adaptive sampling, no denoising, no
Russian roulette. Scene data stay in memory between renders, so that a render of the same frame is path tracing alone.
"""

import json
import math
import os
import re
import sys
import time

import bpy
import numpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from cycles_settings import add_camera, add_light, set_cycles, triple  # noqa: E402: found beside this file

FOLDER = ""


def array(name, kind, columns):
    return numpy.fromfile(os.path.join(FOLDER, name), kind).reshape(-1, columns)


def add_mesh(scene, description, material):
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
    mesh.polygons.foreach_set("loop_total", numpy.full(len(triangles), 3, "i4"))
    mesh.polygons.foreach_set("use_smooth", numpy.full(len(triangles), True))
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", corner_uvs.ravel())
    mesh.update(calc_edges=True)
    mesh.materials.append(material)
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
    else:
        raise ValueError(f"found a material of type {kind!r}, expected conductor, dielectric or diffuse")
    node.inputs["Color"].default_value = (*description["color"], 1)
    tree.links.new(node.outputs["BSDF"], output.inputs["Surface"])
    return material


def set_environment(scene, description):
    world = bpy.data.worlds.new("world")
    scene.world = world
    world.use_nodes = True
    tree = world.node_tree
    background = tree.nodes["Background"]
    background.inputs["Strength"].default_value = 1.0
    if "file" in description:
        texture = tree.nodes.new("ShaderNodeTexEnvironment")
        texture.image = bpy.data.images.load(os.path.join(FOLDER, description["file"]))
        texture.image.colorspace_settings.name = "Linear"
        texture.interpolation = "Linear"
        tree.links.new(texture.outputs["Color"], background.inputs["Color"])
        world.cycles.sampling_method = "MANUAL"
        world.cycles.sample_map_resolution = description["width"]
    else:
        background.inputs["Color"].default_value = (*triple(description.get("radiance", 0)), 1)
        world.cycles.sampling_method = "NONE"  # nothing to find in it: scattered rays meet it anyway, and light samples cost rays


def move_mesh(mesh, points):
    mesh.vertices.foreach_set("co", points.ravel())
    mesh.update()


def main():
    global FOLDER
    path = os.path.abspath(sys.argv[sys.argv.index("--") + 1])
    FOLDER = os.path.dirname(path)
    with open(path, encoding="utf-8") as stream:
        description = json.load(stream)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    materials = {material["name"]: add_material(material) for material in description["materials"]}
    moving = []
    for item in description["meshes"]:
        mesh = add_mesh(scene, item, materials[item["material"]])
        if len(item["points"]) > 1:
            moving.append((mesh, [array(name, "<f4", 3) for name in item["points"]]))
    add_camera(scene, description["camera"])
    for light in description["lights"]:
        add_light(scene, light)
    set_environment(scene, description["environment"])
    set_cycles(scene, description["render"], 1)
    scene.render.threads_mode, scene.render.threads = "FIXED", description["threads"]
    scene.render.use_persistent_data = True
    scene.cycles.sampling_pattern = "SOBOL"
    frame = 0
    print("CYCLES", json.dumps({"ready": True, "version": bpy.app.version_string}), flush=True)
    for line in sys.stdin:
        request = json.loads(line)
        scene.cycles.samples, scene.cycles.seed = request["spp"], request["seed"]
        scene.render.resolution_x, scene.render.resolution_y = request["width"], request["height"]
        if request["frame"] != frame:
            frame = request["frame"]
            for mesh, positions in moving:
                move_mesh(mesh, positions[frame])
        start = time.perf_counter()
        bpy.ops.render.render()
        seconds = time.perf_counter() - start
        if request["output"]:
            bpy.data.images["Render Result"].save_render(request["output"])
        with open("/proc/self/status", encoding="utf-8") as status:
            peak = int(re.search(r"VmHWM:\s+(\d+)", status.read()).group(1)) / 1024
        print("CYCLES", json.dumps({"seconds": seconds, "peak_mb": peak}), flush=True)


main()
