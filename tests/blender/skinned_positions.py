"""World positions of every mesh vertex of a glTF animation, as Blender evaluates them: an independent reference.

    blender -b -noaudio --factory-startup --python skinned_positions.py -- FILE.glb OUT.json SECONDS... [--clip NAME]

Writes {"file", "blender", "clip", "seconds", "objects": [{"name", "mesh", "times": [[[x, y, z], ...], ...]}]}: one list of
positions per given time, in glTF's space (y up, metres). Written for Blender 3.4.

What to know when comparing:
- Vertices come in the file's order, the primitives of a mesh one after the other; those that no face uses are left out.
- Blender works in float32, and its armatures normalise the weights of a vertex.
- Blender interpolates LINEAR rotations component by component and normalises, glTF asks for a slerp: times between keys differ
  by the third power of the angle between the keys. The importer ignores the tangents of CUBICSPLINE. Key times are exact.
- Only the clip asked for (else the first) is imported, so that what it does not animate stays as the file stores it.
"""

import argparse
import json
import os
import sys
import traceback

import bpy


def parse_arguments():
    own = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    parser = argparse.ArgumentParser(prog="skinned_positions.py", description=__doc__.splitlines()[0])
    parser.add_argument("file")
    parser.add_argument("output")
    parser.add_argument("seconds", nargs="*", type=float)
    parser.add_argument("--clip", help="name of the animation; default: the first one of the file")
    return parser.parse_args(own)


def import_clip(path, clip):
    """Imports the file with one of its animations. Returns the animation's name, None where the file has none."""
    import numpy
    from io_scene_gltf2.io.imp.gltf2_io_gltf import glTFImporter

    if not hasattr(numpy, "bool"):  # the importer of 3.4 wants the old alias, numpy 1.24 has dropped it
        numpy.bool = bool
    chosen = []
    read = glTFImporter.read

    def read_one_clip(importer):
        read(importer)
        animations = importer.data.animations or []
        names = [animation.name or str(index) for index, animation in enumerate(animations)]
        if clip is not None and clip not in names:
            raise ValueError(f"{path}: no clip {clip!r}; it has {names}")
        if names:
            index = names.index(clip) if clip is not None else 0
            importer.data.animations = [animations[index]]
            chosen.append(names[index])

    glTFImporter.read = read_one_clip
    try:
        bpy.ops.import_scene.gltf(filepath=path, merge_vertices=False)
    finally:
        glTFImporter.read = read
    return chosen[0] if chosen else None


def widen_shape_key_ranges():
    """The importer widens a morph's range for its first key only; values outside would be clamped."""
    for keys in bpy.data.shape_keys:
        for block in keys.key_blocks:
            block.slider_min = -10
            block.slider_max = 10


def mesh_objects():
    """The file's mesh objects; not the shape that the importer draws bones with."""
    return [
        item
        for item in bpy.context.scene.objects
        if item.type == "MESH" and not any(c.name.startswith("glTF_not_exported") for c in item.users_collection)
    ]


def go_to(seconds):
    """The importer puts a key of t seconds at frame t * fps."""
    scene = bpy.context.scene
    frame = seconds * scene.render.fps / scene.render.fps_base
    whole = int(frame // 1)
    scene.frame_set(whole, subframe=frame - whole)


def positions_of(item):
    """Evaluated positions in the world, turned from z up to y up."""
    import numpy

    evaluated = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    local = numpy.empty(3 * len(mesh.vertices), dtype=numpy.float32)
    mesh.vertices.foreach_get("co", local)
    evaluated.to_mesh_clear()
    world_from_object = numpy.array(evaluated.matrix_world, dtype=numpy.float64)
    world = local.reshape(-1, 3).astype(numpy.float64) @ world_from_object[:3, :3].T + world_from_object[:3, 3]
    return numpy.stack([world[:, 0], world[:, 2], -world[:, 1]], axis=1)


def write_whole(path, data):
    temporary = f"{path}.{os.getpid()}.tmp"
    with open(temporary, "w", encoding="utf-8") as stream:
        json.dump(data, stream)
    os.replace(temporary, path)


def main():
    arguments = parse_arguments()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    clip = import_clip(os.path.abspath(arguments.file), arguments.clip)
    widen_shape_key_ranges()
    items = mesh_objects()
    objects = [{"name": item.name, "mesh": item.data.name, "times": []} for item in items]
    for seconds in arguments.seconds:
        go_to(seconds)
        for item, entry in zip(items, objects):
            entry["times"].append(positions_of(item).tolist())
    for item, entry in zip(items, objects):
        first = [round(x, 6) for x in entry["times"][0][0]] if entry["times"] and entry["times"][0] else None
        print(f"{os.path.basename(arguments.file)}: {clip}: {item.name}: {len(item.data.vertices)} vertices, first {first}")
    write_whole(
        arguments.output,
        {
            "file": os.path.basename(arguments.file),
            "blender": bpy.app.version_string,
            "clip": clip,
            "seconds": arguments.seconds,
            "objects": objects,
        },
    )


if __name__ == "__main__":
    try:
        main()
    except Exception:  # Blender would report success
        traceback.print_exc()
        sys.exit(1)
