"""Tangents of meshes as Blender's MikkTSpace makes them.

    blender -b -noaudio --factory-startup --python-exit-code 1 --python tangents.py -- MESHES.json OUT.json

MESHES.json: [{"positions": [[x, y, z]], "faces": [[index]], "corners": [[u, v, nx, ny, nz]]}], corners in the order of the faces.
OUT.json: for each mesh and corner [tx, ty, tz, sign, nx, ny, nz], with the normal that Blender rounded to.
"""

import json
import sys

import bpy


def tangents_of(source, number):
    mesh = bpy.data.meshes.new(f"mesh{number}")
    mesh.from_pydata(source["positions"], [], source["faces"])
    layer = mesh.uv_layers.new(name="uv")
    for loop, corner in enumerate(source["corners"]):
        layer.data[loop].uv = corner[:2]
    for polygon in mesh.polygons:
        polygon.use_smooth = True
    if hasattr(mesh, "use_auto_smooth"):  # since 4.1 custom normals need no word
        mesh.use_auto_smooth = True
    mesh.normals_split_custom_set([corner[2:] for corner in source["corners"]])
    mesh.calc_tangents(uvmap="uv")
    return [[*loop.tangent, loop.bitangent_sign, *loop.normal] for loop in mesh.loops]


def main():
    source, output = sys.argv[sys.argv.index("--") + 1 :]
    with open(source, encoding="utf-8") as stream:
        meshes = json.load(stream)
    with open(output, "w", encoding="utf-8") as stream:
        json.dump([tangents_of(mesh, number) for number, mesh in enumerate(meshes)], stream)


main()
