"""A glTF file as Blender shows it at one time: linear picture, material of each pixel, and the camera that Taut is to use.

    blender -b -noaudio --factory-startup --python-exit-code 1 --python gltf_picture.py -- FILE.glb SECONDS SPP OUT [--clip NAME] [--formula]

Writes OUT.exr (linear, world z up), OUT.materials.exr (red: number of the material at the pixel's centre, from 1; 0: none) and OUT.json:
{"camera": {"position", "look_at", "fov_deg"}, "light": {"corner", "u", "v", "radiance"}, "environment", "width", "height", "materials"}.

Materials are the importer's, a Principled BSDF; --formula puts glTF's own in their place where they are opaque and dielectric: Fresnel
mix of a diffuse and a GGX lobe, for the Principled one adds its lobe to an undarkened diffuse part. Settings are cycles.py's.
"""

import argparse
import importlib.util
import json
import os
import sys

import bpy
from mathutils import Vector

HERE = os.path.dirname(os.path.abspath(__file__))


def load_script(path):
    """By its path: Blender has a module `cycles` of its own."""
    spec = importlib.util.spec_from_file_location("taut_" + os.path.basename(path)[:-3], path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


cycles = load_script(os.path.join(HERE, "..", "..", "apps", "blender", "cycles.py"))
skinned_positions = load_script(os.path.join(HERE, "skinned_positions.py"))

WIDTH, HEIGHT, FOV_DEG, EVENTS, ENVIRONMENT = 320, 240, 40, 4, 0.5


def bounds():
    graph = bpy.context.evaluated_depsgraph_get()
    points = []
    for item in skinned_positions.mesh_objects():
        mesh = item.evaluated_get(graph).to_mesh()
        points += [item.matrix_world @ v.co for v in mesh.vertices]
    return [Vector([pick(p[k] for p in points) for k in range(3)]) for pick in (min, max)]


def view_of(lower, upper):
    """A camera from the front right, and a square light above to the left, in proportion to the box."""
    centre, size = (lower + upper) / 2, (upper - lower).length
    eye = centre + Vector((0.6, -1.25, 0.5)) * size
    corner = centre + Vector((-0.9, -0.7, 1.1)) * size
    u, v = Vector((0, 0.5, 0)) * size, Vector((0.5, 0, 0)) * size  # u x v points down, as the light shines
    return (
        {"position": list(eye), "look_at": list(centre), "fov_deg": FOV_DEG},
        {"type": "quad", "corner": list(corner), "u": list(u), "v": list(v), "radiance": 8},
    )


def use_the_formula(material):
    tree = material.node_tree
    principled = next((n for n in tree.nodes if n.type == "BSDF_PRINCIPLED"), None)
    if principled is None:
        return False
    inputs = principled.inputs
    if any(inputs[k].is_linked or inputs[k].default_value > 0 for k in ("Metallic", "Transmission", "Clearcoat")) or inputs["Alpha"].is_linked:
        return False
    diffuse, glossy = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeBsdfGlossy")
    fresnel, mix = tree.nodes.new("ShaderNodeFresnel"), tree.nodes.new("ShaderNodeMixShader")
    glossy.distribution = "GGX"
    diffuse.inputs["Roughness"].default_value = 0
    fresnel.inputs["IOR"].default_value = 1.5

    def follow(name, target):
        if inputs[name].is_linked:
            tree.links.new(inputs[name].links[0].from_socket, target)
        else:
            target.default_value = inputs[name].default_value

    follow("Base Color", diffuse.inputs["Color"])
    follow("Roughness", glossy.inputs["Roughness"])
    glossy.inputs["Color"].default_value = (1, 1, 1, 1)
    tree.links.new(fresnel.outputs["Fac"], mix.inputs[0])
    tree.links.new(diffuse.outputs["BSDF"], mix.inputs[1])
    tree.links.new(glossy.outputs["BSDF"], mix.inputs[2])
    for link in list(principled.outputs["BSDF"].links):
        tree.links.new(mix.outputs["Shader"], link.to_socket)
    return True


def numbers_of_materials(materials):
    """Every surface black, and emitting the number of its material."""
    for number, material in enumerate(materials, 1):
        material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        emission, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
        emission.inputs["Color"].default_value = (number, number, number, 1)
        tree.links.new(emission.outputs["Emission"], output.inputs["Surface"])
    bpy.context.scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
    for item in list(bpy.context.scene.objects):
        if item.type == "LIGHT":
            bpy.data.objects.remove(item)


def render(path, spp):
    scene = bpy.context.scene
    scene.cycles.samples = spp
    scene.render.filepath = os.path.abspath(path)
    bpy.ops.render.render(write_still=True)


def main():
    parser = argparse.ArgumentParser(prog="gltf_picture.py", description=__doc__.splitlines()[0])
    parser.add_argument("file")
    parser.add_argument("seconds", type=float)
    parser.add_argument("spp", type=int)
    parser.add_argument("output")
    parser.add_argument("--clip")
    parser.add_argument("--formula", action="store_true")
    arguments = parser.parse_args(sys.argv[sys.argv.index("--") + 1 :])
    bpy.ops.wm.read_factory_settings(use_empty=True)
    skinned_positions.import_clip(arguments.file, arguments.clip)
    skinned_positions.widen_shape_key_ranges()
    skinned_positions.go_to(arguments.seconds)
    scene = bpy.context.scene
    for item in list(scene.objects):
        if item.type in ("LIGHT", "CAMERA"):
            bpy.data.objects.remove(item)
        elif item.type == "MESH" and item not in skinned_positions.mesh_objects():
            item.hide_render = True
    camera, light = view_of(*bounds())
    cycles.add_camera(scene, camera)
    cycles.add_light(scene, light)
    cycles.set_environment(scene, {"radiance": ENVIRONMENT}, sampled=True)
    cycles.set_cycles(scene, {"width": WIDTH, "height": HEIGHT, "max_events": EVENTS}, arguments.spp)
    seen = [m for item in skinned_positions.mesh_objects() for m in item.data.materials if m]
    materials = list(dict.fromkeys(seen))
    formula = [m.name for m in materials if arguments.formula and use_the_formula(m)]
    render(arguments.output + ".exr", arguments.spp)
    with open(arguments.output + ".json", "w", encoding="utf-8") as stream:
        json.dump(
            {"camera": camera, "light": light, "environment": ENVIRONMENT, "width": WIDTH, "height": HEIGHT, "events": EVENTS,
             "materials": [m.name for m in materials], "formula": formula, "blender": bpy.app.version_string},
            stream,
        )
    numbers_of_materials(materials)
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.filter_width = 0.01
    render(arguments.output + ".materials.exr", 1)


if __name__ == "__main__":
    main()
