"""Meshes that `taut export` wrote (.npz or .ply), frame by frame.

The mesh becomes one object whose points, normals and attributes are replaced at each frame. Its material (material.py) works out
roughness, anisotropy and rotation where it is shaded.
"""

import os
import re

import bpy
import numpy
from bpy.app.handlers import persistent
from bpy.props import IntProperty, StringProperty

from . import versions
from .attributes import set_vectors
from .material import make_material

PATTERN = "taut_pattern"  # custom property of an imported object: path with #### or without


# --- files -----------------------------------------------------------------------------------------------------------


def path_of_frame(pattern, frame):
    """The last run of # in the file's own name becomes the zero-padded frame number."""
    runs = list(re.finditer("#+(?=[^/]*$)", pattern))
    if not runs:
        return pattern
    run = runs[-1]
    return pattern[: run.start()] + str(frame).zfill(run.end() - run.start()) + pattern[run.end() :]


def read_ply(path):
    """The arrays of a .npz from a binary .ply of `taut export`."""
    with open(path, "rb") as stream:
        data = stream.read()
    head, body = data.split(b"end_header\n", 1)
    lines = [line.split() for line in head.decode("utf-8", "replace").splitlines()]
    if ["format", "binary_little_endian", "1.0"] not in lines:
        raise ValueError(f"{path}: found no binary little-endian PLY, expected one of taut export (without --ascii)")
    counts = {line[1]: int(line[2]) for line in lines if line[:1] == ["element"]}
    names = []
    for line in lines:
        if line[:2] == ["element", "face"]:
            break
        if line[:1] == ["property"]:
            names.append(line[2])
    table = numpy.frombuffer(body, "<f4", counts["vertex"] * len(names)).reshape(-1, len(names))
    faces = numpy.frombuffer(body, [("n", "u1"), ("v", "<i4", 3), ("m", "<i4")], counts["face"], table.nbytes)
    column = {name: i for i, name in enumerate(names)}

    def columns(*wanted):
        return table[:, [column[name] for name in wanted]]

    if "M_x" not in column:
        raise ValueError(f"{path}: found no property M_x, expected a file of taut export")
    arrays = {
        "P": columns("x", "y", "z"),
        "N": columns("nx", "ny", "nz"),
        "M": columns("M_x", "M_y", "M_z", "M_p_x", "M_q_x"),
        "tangent": columns("tangent_x", "tangent_y", "tangent_z"),
        "faces": faces["v"],
        "face_material": faces["m"],
    }
    if "s" in column:
        arrays["st"] = columns("s", "t")
    return arrays


def read_arrays(path):
    if path.lower().endswith(".ply"):
        return read_ply(path)
    with numpy.load(path) as archive:
        arrays = {name: archive[name] for name in archive.files}
    if "M" not in arrays:
        raise ValueError(f"{path}: found no array M, expected a file of taut export")
    return arrays


# --- mesh ------------------------------------------------------------------------------------------------------------


def set_frame(mesh, arrays):
    """Points, normals and gloss of one frame. The topology is the mesh's."""
    if len(mesh.vertices) != len(arrays["P"]):
        raise ValueError(f"found {len(arrays['P'])} vertices, expected {len(mesh.vertices)} as in the first frame")
    mesh.vertices.foreach_set("co", numpy.ascontiguousarray(arrays["P"], dtype=numpy.float32).ravel())
    set_vectors(mesh, "taut_m", arrays["M"][:, :3], "POINT")
    set_vectors(mesh, "taut_tangent", arrays["tangent"], "POINT")
    mesh.update()
    mesh.normals_split_custom_set_from_vertices(numpy.asarray(arrays["N"], dtype=numpy.float64).tolist())


def make_mesh(name, arrays):
    faces = numpy.ascontiguousarray(arrays["faces"], dtype=numpy.int32)
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(arrays["P"]))
    mesh.loops.add(faces.size)
    mesh.loops.foreach_set("vertex_index", faces.ravel())
    mesh.polygons.add(len(faces))
    mesh.polygons.foreach_set("loop_start", numpy.arange(0, faces.size, 3, dtype=numpy.int32))
    versions.set_loop_totals(mesh, numpy.full(len(faces), 3, dtype=numpy.int32))
    mesh.polygons.foreach_set("use_smooth", numpy.ones(len(faces), dtype=bool))
    if "face_material" in arrays:
        mesh.polygons.foreach_set("material_index", numpy.ascontiguousarray(arrays["face_material"], dtype=numpy.int32))
    if "st" in arrays:
        layer = mesh.uv_layers.new(name="UVMap")
        layer.data.foreach_set("uv", numpy.ascontiguousarray(arrays["st"][faces.ravel()], dtype=numpy.float32).ravel())
    # Positions before edges: Blender drops what is degenerate only in validate(), which is not called.
    mesh.vertices.foreach_set("co", numpy.ascontiguousarray(arrays["P"], dtype=numpy.float32).ravel())
    mesh.update(calc_edges=True)
    versions.keep_custom_normals(mesh)
    set_frame(mesh, arrays)
    return mesh


# --- objects and frames ----------------------------------------------------------------------------------------------


def import_gloss(pattern, frame, color=(1.0, 1.0, 1.0)):
    """An object of the scene that shows `pattern` at every frame; built from `frame`. Points are in the world."""
    pattern = os.path.abspath(pattern)
    arrays = read_arrays(path_of_frame(pattern, frame))
    name = re.sub("[._#-]+$", "", os.path.splitext(os.path.basename(pattern))[0]) or "taut"
    mesh = make_mesh(name, arrays)
    slots = int(arrays["face_material"].max()) + 1 if len(arrays.get("face_material", ())) else 1
    for _ in range(slots):
        mesh.materials.append(make_material(name + " gloss", color))
    item = bpy.data.objects.new(name, mesh)
    item[PATTERN] = pattern
    bpy.context.scene.collection.objects.link(item)
    return item


@persistent
def show_frame(scene, *_):
    """Handler: brings every imported object to the scene's frame, where there is a file for it."""
    for item in scene.objects:
        pattern = item.get(PATTERN)
        if not pattern or "#" not in os.path.basename(pattern):
            continue
        path = path_of_frame(pattern, scene.frame_current)
        if os.path.exists(path):
            set_frame(item.data, read_arrays(path))


def start_following():
    handlers = bpy.app.handlers.frame_change_pre
    if not any(handler.__name__ == show_frame.__name__ for handler in handlers):
        handlers.append(show_frame)


class ImportTautGloss(bpy.types.Operator):
    """Import what taut export wrote"""

    bl_idname = "import_scene.taut_gloss"
    bl_label = "Taut gloss"
    bl_options = {"UNDO"}

    filepath: StringProperty(subtype="FILE_PATH")
    filter_glob: StringProperty(default="*.npz;*.ply", options={"HIDDEN"})
    digits: IntProperty(name="Digits", default=4, min=0, max=9, description="Of the frame number in the name; 0: one frame only")

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        pattern = self.filepath
        found = list(re.finditer(r"\d{%d}" % self.digits, os.path.basename(pattern))) if self.digits else []
        frame = context.scene.frame_current
        if found:
            frame = int(found[-1].group())
            at = len(pattern) - len(os.path.basename(pattern)) + found[-1].start()
            pattern = pattern[:at] + "#" * self.digits + pattern[at + self.digits :]
        try:
            import_gloss(pattern, frame)
        except (OSError, ValueError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        start_following()
        return {"FINISHED"}


def menu_entry(self, _):
    self.layout.operator(ImportTautGloss.bl_idname, text="Taut gloss (.npz, .ply)")


def register():
    bpy.utils.register_class(ImportTautGloss)
    bpy.types.TOPBAR_MT_file_import.append(menu_entry)
    start_following()


def unregister():
    bpy.app.handlers.frame_change_pre[:] = [h for h in bpy.app.handlers.frame_change_pre if h.__name__ != show_frame.__name__]
    bpy.types.TOPBAR_MT_file_import.remove(menu_entry)
    bpy.utils.unregister_class(ImportTautGloss)
