"""A plate under a normal map as Cycles shows it: a rough conductor of reflectance 1, seen from above, under a quad light and a dim sky.

    blender -b -noaudio --factory-startup --python-exit-code 1 --python mapped_plate.py -- NORMALS.exr ALPHA SPP OUT.exr OTHER.exr SCENE.toml

The map covers the plate [-1, 1]^2 once, u along x. SCENE.toml receives what Taut is to render: the same camera, lights, plate and map.
Masking is separable there, as Cycles 3.4 has it, and light is scattered once. OTHER.exr has another seed.
"""

import importlib.util
import os
import sys

import bpy

HERE = os.path.dirname(os.path.abspath(__file__))
SPEC = importlib.util.spec_from_file_location("taut_cycles", os.path.join(HERE, "..", "..", "apps", "blender", "cycles.py"))
cycles = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(cycles)

SIZE = 128
CAMERA = {"position": [0.4, -1.2, 3.2], "look_at": [0, 0, 0], "fov_deg": 26}
LIGHT = {"type": "quad", "corner": [-1.6, 0.6, 1.8], "u": [0, 1, 0], "v": [1, 0, 0], "radiance": 12}
ENVIRONMENT = 0.3


def add_plate(normals, alpha):
    mesh = bpy.data.meshes.new("plate")
    mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
    layer = mesh.uv_layers.new(name="uv")
    for loop, uv in enumerate([(0, 0), (1, 0), (1, 1), (0, 1)]):
        layer.data[loop].uv = uv
    material = bpy.data.materials.new("plate")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    image, bend = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeNormalMap")
    glossy, output = tree.nodes.new("ShaderNodeBsdfGlossy"), tree.nodes.new("ShaderNodeOutputMaterial")
    image.image = bpy.data.images.load(normals)
    image.image.colorspace_settings.name = "Non-Color"
    bend.uv_map = "uv"
    glossy.distribution = "GGX"
    glossy.inputs["Color"].default_value = (1, 1, 1, 1)
    glossy.inputs["Roughness"].default_value = alpha**0.5
    tree.links.new(image.outputs["Color"], bend.inputs["Color"])
    tree.links.new(bend.outputs["Normal"], glossy.inputs["Normal"])
    tree.links.new(glossy.outputs["BSDF"], output.inputs["Surface"])
    mesh.materials.append(material)
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("plate", mesh))


def scene_of(normals, alpha, folder):
    with open(os.path.join(folder, "plate.obj"), "w", encoding="utf-8") as stream:
        stream.write("v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n")
    return "\n".join([
        "[render]", f"width = {SIZE}", f"height = {SIZE}", "max_events = 1", 'filter = "box"',
        "[camera]", *(f"{key} = {value}" for key, value in CAMERA.items()),
        "[environment]", f"radiance = {ENVIRONMENT}",
        "[[light]]", 'type = "quad"', *(f"{key} = {LIGHT[key]}" for key in ("corner", "u", "v", "radiance")), "camera_visible = false",
        "[material.plate]", 'type = "conductor"', "f0 = 1", f"alpha = {alpha}", 'masking = "separable"',
        f'normal = {{ file = "{normals}" }}',
        "[[mesh]]", 'file = "plate.obj"', 'material = "plate"',
    ]) + "\n"


def main():
    normals, alpha, spp, output, other, toml = sys.argv[sys.argv.index("--") + 1 :]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    add_plate(os.path.abspath(normals), float(alpha))
    cycles.add_camera(scene, CAMERA)
    cycles.add_light(scene, LIGHT)
    cycles.set_environment(scene, {"radiance": ENVIRONMENT}, sampled=True)
    cycles.set_cycles(scene, {"width": SIZE, "height": SIZE, "max_events": 1}, int(spp))
    for scene.cycles.seed, file in enumerate([output, other]):
        scene.render.filepath = os.path.abspath(file)
        bpy.ops.render.render(write_still=True)
    with open(toml, "w", encoding="utf-8") as stream:
        stream.write(scene_of(os.path.abspath(normals), float(alpha), os.path.dirname(os.path.abspath(toml))))


main()
