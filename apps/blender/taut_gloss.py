"""Blender add-on: meshes that `taut export` wrote (.npz or .ply), frame by frame, with gloss that follows their deformation.

As an add-on (Blender 3.4 and later): Edit > Preferences > Add-ons > Install, then File > Import > Taut gloss.
As a script:

    blender --python apps/blender/taut_gloss.py -- out/####.npz 1-24

The mesh becomes one object whose points, normals and attributes are replaced at each frame. Its material, Cycles or EEVEE,
works out roughness, anisotropy and rotation where it is shaded, from M and the tangent interpolated over the triangle: phi
itself must not be interpolated, it jumps by half a turn. The node group "Taut gloss" holds the conversion of
src/taut/microsurface/conventions.h, row blender_anisotropic.
"""

import math
import os
import re
import sys

import bpy
import numpy
from bpy.app.handlers import persistent
from bpy.props import IntProperty, StringProperty

bl_info = {
    "name": "Taut gloss",
    "description": "Deforming meshes whose gloss follows the deformation, from `taut export`",
    "version": (1, 0, 0),
    "blender": (3, 4, 0),
    "location": "File > Import > Taut gloss (.npz, .ply)",
    "category": "Import-Export",
}

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


def set_attribute(mesh, name, values):
    """A vector at every vertex."""
    attribute = mesh.attributes.get(name)
    if attribute is None:
        attribute = mesh.attributes.new(name, "FLOAT_VECTOR", "POINT")
    attribute.data.foreach_set("vector", numpy.ascontiguousarray(values, dtype=numpy.float32).ravel())


def set_frame(mesh, arrays):
    """Points, normals and gloss of one frame. The topology is the mesh's."""
    if len(mesh.vertices) != len(arrays["P"]):
        raise ValueError(f"found {len(arrays['P'])} vertices, expected {len(mesh.vertices)} as in the first frame")
    mesh.vertices.foreach_set("co", numpy.ascontiguousarray(arrays["P"], dtype=numpy.float32).ravel())
    set_attribute(mesh, "taut_m", arrays["M"][:, :3])
    set_attribute(mesh, "taut_tangent", arrays["tangent"])
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
    if bpy.app.version < (3, 6, 0):  # later ones derive it
        mesh.polygons.foreach_set("loop_total", numpy.full(len(faces), 3, dtype=numpy.int32))
    mesh.polygons.foreach_set("use_smooth", numpy.ones(len(faces), dtype=bool))
    if "face_material" in arrays:
        mesh.polygons.foreach_set("material_index", numpy.ascontiguousarray(arrays["face_material"], dtype=numpy.int32))
    if "st" in arrays:
        layer = mesh.uv_layers.new(name="UVMap")
        layer.data.foreach_set("uv", numpy.ascontiguousarray(arrays["st"][faces.ravel()], dtype=numpy.float32).ravel())
    # Positions before edges: Blender drops what is degenerate only in validate(), which is not called.
    mesh.vertices.foreach_set("co", numpy.ascontiguousarray(arrays["P"], dtype=numpy.float32).ravel())
    mesh.update(calc_edges=True)
    if hasattr(mesh, "use_auto_smooth"):  # until 4.0: else custom normals are ignored
        mesh.use_auto_smooth = True
        mesh.auto_smooth_angle = math.pi
    set_frame(mesh, arrays)
    return mesh


# --- material --------------------------------------------------------------------------------------------------------


class NodeMath:
    """Writes formulas as Math nodes of a tree."""

    def __init__(self, tree):
        self.tree = tree

    def __call__(self, operation, *operands):
        node = self.tree.nodes.new("ShaderNodeMath")
        node.operation = operation
        for socket, operand in zip(node.inputs, operands):
            if isinstance(operand, (int, float)):
                socket.default_value = operand
            else:
                self.tree.links.new(operand, socket)
        return node.outputs[0]

    def hypot(self, x, y):
        return self("SQRT", self("ADD", self("MULTIPLY", x, x), self("MULTIPLY", y, y)))


def new_socket(group, kind, name, where):
    if hasattr(group, "interface"):  # 4.0
        return group.interface.new_socket(name, in_out=where, socket_type=kind)
    return (group.inputs if where == "INPUT" else group.outputs).new(kind, name)


def gloss_group():
    """Node group: M as a vector (a, b, d) -> roughness, anisotropy, rotation of the Glossy / Anisotropic BSDF."""
    known = bpy.data.node_groups.get("Taut gloss")
    if known is not None:
        return known
    group = bpy.data.node_groups.new("Taut gloss", "ShaderNodeTree")
    new_socket(group, "NodeSocketVector", "M", "INPUT")
    for name in ("Roughness", "Anisotropy", "Rotation"):
        new_socket(group, "NodeSocketFloat", name, "OUTPUT")
    start = group.nodes.new("NodeGroupInput")
    end = group.nodes.new("NodeGroupOutput")
    split = group.nodes.new("ShaderNodeSeparateXYZ")
    group.links.new(start.outputs[0], split.inputs[0])
    a, b, d = split.outputs
    math_node = NodeMath(group)
    # Singular values of [a b; 0 d]: their product is a d, the larger is hypot((a + d)/2, b/2) + hypot((a - d)/2, b/2).
    half = math_node("MULTIPLY", b, 0.5)
    larger = math_node(
        "ADD",
        math_node.hypot(math_node("MULTIPLY", math_node("ADD", a, d), 0.5), half),
        math_node.hypot(math_node("MULTIPLY", math_node("SUBTRACT", a, d), 0.5), half),
    )
    product = math_node("MULTIPLY", a, d)
    # alphaMax alphaMin = 1 / (a d); q = alphaMin / alphaMax = a d / larger^2.
    roughness = math_node("POWER", product, -0.25)
    anisotropy = math_node("SUBTRACT", math_node("DIVIDE", math_node("SQRT", product), larger), 1.0)
    # phi = atan2(-2 b d, d^2 - a^2 - b^2) / 2, as a share of a full turn.
    squares = math_node(
        "SUBTRACT",
        math_node("MULTIPLY", d, d),
        math_node("ADD", math_node("MULTIPLY", a, a), math_node("MULTIPLY", b, b)),
    )
    angle = math_node("ARCTAN2", math_node("MULTIPLY", math_node("MULTIPLY", b, d), -2.0), squares)
    rotation = math_node("MULTIPLY", angle, 0.25 / math.pi)
    for socket, value in zip(end.inputs, (roughness, anisotropy, rotation)):
        group.links.new(value, socket)
    return group


def make_material(name, color=(1.0, 1.0, 1.0)):
    """A metal of one colour whose microsurface is that of the attributes taut_m and taut_tangent."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    output = nodes.new("ShaderNodeOutputMaterial")
    glossy = nodes.new("ShaderNodeBsdfAnisotropic")
    glossy.distribution = "GGX"
    glossy.inputs["Color"].default_value = (*color, 1.0)
    group = nodes.new("ShaderNodeGroup")
    group.node_tree = gloss_group()
    for attribute, vector in (("taut_m", group.inputs["M"]), ("taut_tangent", glossy.inputs["Tangent"])):
        node = nodes.new("ShaderNodeAttribute")
        node.attribute_type = "GEOMETRY"
        node.attribute_name = attribute
        links.new(node.outputs["Vector"], vector)
    for value in ("Roughness", "Anisotropy", "Rotation"):
        links.new(group.outputs[value], glossy.inputs[value])
    links.new(glossy.outputs["BSDF"], output.inputs["Surface"])
    return material


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


def main(words):
    """PATTERN [FIRST-LAST]"""
    first, last = (words[1].split("-") * 2)[:2] if len(words) > 1 else ("1", "1")
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = int(first), int(last)
    item = import_gloss(words[0], int(first))
    start_following()
    scene.frame_set(int(first))
    print(f"{item.name}: {len(item.data.vertices)} vertices, frames {first} to {last}")


if __name__ == "__main__":
    if "--" in sys.argv and len(sys.argv) > sys.argv.index("--") + 1:
        main(sys.argv[sys.argv.index("--") + 1 :])
    else:
        register()
