"""Gloss of a mesh as Blender deforms it: computed from the evaluated mesh at each frame, written to attributes of the mesh.

taut_m (a, b, d of M) and taut_tangent are what the material reads (material.py); both are vectors of points, or of corners where a seam or
a hard edge has several frames at a point. Deformation is measured in object space: the object's own transform is no deformation.

A change of the frame writes them into the evaluated mesh, in place: a mesh that is touched is evaluated once more, and in the dependency
graph of a final render it loses the animated values of its shape keys. Any other change, and saving, writes to the mesh itself.

Nothing here raises: what is wrong is written to the object's `taut.message`, which the panel shows, and the gloss stays as it was.
"""

import os

import bpy
import numpy
from bpy.app.handlers import persistent

from . import versions
from .attributes import faces_of, numbers_of, points_of, remove, set_vectors, uv_of, vectors_of, write_in_place

M, TANGENT, REST = "taut_m", "taut_tangent", "taut_rest"
NO_MODULE = "The Python package taut is not installed: `make python`"


class Trouble(Exception):
    """What the panel says instead of gloss."""


class _Kept:
    """A taut.Gloss with what it was made of, and the positions that the attributes are of."""

    def __init__(self, gloss, counts, alphas, domain):
        self.gloss, self.counts, self.alphas, self.domain, self.positions = gloss, counts, alphas, domain, None

    def is_of(self, mesh, alphas):
        return self.counts == counts_of(mesh) and numpy.array_equal(self.alphas, alphas)


_kept = {}  # by the object's full name
_writing = False


def forget(item=None):
    """Drops what is kept of an object, or of all."""
    if item is None:
        _kept.clear()
    else:
        _kept.pop(item.name_full, None)


def counts_of(mesh):
    return len(mesh.vertices), len(mesh.loops), len(mesh.polygons)


def uses_of(mesh):
    return mesh.users - (1 if mesh.use_fake_user else 0)


def rest_points(item, depsgraph):
    """The undeformed points, [vertices, 3], object space."""
    settings, mesh = item.taut, item.data
    if settings.rest == "OBJECT":
        other = settings.rest_object
        if other is None or other.type != "MESH":
            raise Trouble("Choose the mesh object that is the rest shape")
        rest = points_of(other.evaluated_get(depsgraph).data)
        if len(rest) != len(mesh.vertices):
            raise Trouble(f"Rest '{other.name}' has {len(rest)} points, expected {len(mesh.vertices)} as '{item.name}' has")
        return rest
    if settings.rest == "FRAME":
        rest = vectors_of(mesh, REST)
        if rest is None or len(rest) != len(mesh.vertices):
            raise Trouble("Press Take Rest: the shape at the rest frame is not known yet")
        return rest
    keys = mesh.shape_keys
    if keys is None:
        return points_of(mesh)
    values = numpy.empty(3 * len(mesh.vertices), numpy.float32)
    keys.reference_key.data.foreach_get("co", values)
    return values.reshape(-1, 3)


def evaluated_points(item, depsgraph):
    """Where the modifiers and shape keys have taken the points of the mesh."""
    mesh, evaluated = item.data, item.evaluated_get(depsgraph).data
    if counts_of(evaluated) != counts_of(mesh):
        names = ", ".join(m.name for m in item.modifiers if m.show_viewport) or "its modifiers"
        raise Trouble(
            f"Its modifiers change the topology ({names}): {len(evaluated.vertices)} points, expected {len(mesh.vertices)}; "
            "apply what makes faces"
        )
    return points_of(evaluated)


def alphas_of(item):
    """Alpha at rest: a pair, or [vertices, 2] of the attribute that the panel names."""
    name = item.taut.alpha_attribute
    if not name:
        return tuple(item.taut.alpha)
    values = numbers_of(item.data, name)
    if values is None:
        raise Trouble(f"Mesh '{item.data.name}' has no attribute '{name}' of numbers at its points")
    return values[:, [0, 0] if values.shape[1] == 1 else [0, 1]]


def _make(item, depsgraph, alphas):
    import taut

    mesh = item.data
    normals = None
    if versions.has_custom_normals(mesh):
        versions.split_normals(mesh)
        normals = numpy.empty(3 * len(mesh.loops), numpy.float32)
        mesh.loops.foreach_get("normal", normals)
        normals = normals.reshape(-1, 3)
    arguments = (rest_points(item, depsgraph), faces_of(mesh), uv_of(mesh))
    options = {**item.taut.material(), "alpha": alphas, "normals": normals}
    gloss = taut.Gloss(*arguments, **options)
    if gloss.split_points == 0:
        return _Kept(gloss, counts_of(mesh), alphas, "POINT")
    return _Kept(taut.Gloss(*arguments, per="corner", **options), counts_of(mesh), alphas, "CORNER")


def _check(item):
    mesh = item.data
    if len(mesh.vertices) == 0 or len(mesh.polygons) == 0:
        raise Trouble("The mesh has no faces")
    if uses_of(mesh) > 1:
        raise Trouble(f"Mesh '{mesh.name}' has {uses_of(mesh)} users, and gloss is written to the mesh: make it a single user")
    if item.mode == "EDIT":
        forget(item)
        raise Trouble("Waits until edit mode is left")
    if item.library is not None or mesh.library is not None:
        raise Trouble("Linked from another file: make it local or an override")


def cache_path(item, frame):
    return os.path.join(bpy.path.abspath(item.taut.cache), f"{bpy.path.clean_name(item.name)}.{frame:04}.npz")


def _write(item, gloss, domain, depsgraph, in_place):
    """True where the mesh itself has the values now."""
    global _writing
    values = dict(zip((M, TANGENT), gloss))
    if in_place and write_in_place(item.evaluated_get(depsgraph).data, values, domain):
        return False
    _writing = True
    try:
        for name, rows in values.items():
            set_vectors(item.data, name, rows, domain)
        item.data.update()
    finally:
        _writing = False
    return True


def _from_cache(item, frame, depsgraph, in_place):
    path = cache_path(item, frame)
    try:
        with numpy.load(path) as arrays:
            gloss, domain = (arrays[M], arrays[TANGENT]), str(arrays["domain"])
    except (OSError, KeyError, ValueError):
        raise Trouble(f"No baked gloss for frame {frame}: {path}") from None
    expected = len(item.data.vertices if domain == "POINT" else item.data.loops)
    if len(gloss[0]) != expected:
        raise Trouble(f"The baked gloss is of another mesh: {len(gloss[0])} rows, expected {expected}")
    _write(item, gloss, domain, depsgraph, in_place)


def compute(item, depsgraph, anew=True):
    """(M, tangent), domain and positions of an object as it stands; None, unless `anew`, where the mesh has these values."""
    try:
        import taut
    except ImportError:
        raise Trouble(NO_MODULE) from None
    _check(item)
    positions = evaluated_points(item, depsgraph)
    alphas = alphas_of(item)
    kept = _kept.get(item.name_full)
    try:
        if kept is None or not kept.is_of(item.data, alphas):
            kept = _kept[item.name_full] = _make(item, depsgraph, alphas)
        elif (
            not anew
            and kept.positions is not None
            and numpy.array_equal(kept.positions, positions)
            and item.data.attributes.get(M) is not None
        ):
            return None
        found = kept.gloss.at(positions)
    except taut.InputError as error:
        raise Trouble(str(error)) from None
    m = numpy.ascontiguousarray(found.M[:, :3])
    if kept.gloss.loose_points:
        numpy.nan_to_num(m, copy=False, nan=1.0)
        numpy.nan_to_num(found.tangent, copy=False)
    return (m, found.tangent), kept.domain, positions


def update(item, depsgraph, frame, in_place=False):
    """Brings an object's attributes to what is shown; says in its panel what is wrong."""
    message = ""
    try:
        if item.taut.use_cache:
            _check(item)
            _from_cache(item, frame, depsgraph, in_place)
        else:
            new = compute(item, depsgraph, anew=in_place)
            if new is not None:
                gloss, domain, positions = new
                kept = _kept[item.name_full]
                kept.positions = positions if _write(item, gloss, domain, depsgraph, in_place) else None
    except Trouble as trouble:
        message = str(trouble)
    if item.taut.message != message:
        item.taut.message = message


def followers(scene):
    return [item for item in scene.objects if item.type == "MESH" and item.taut.enabled]


@persistent
def on_frame(scene, depsgraph=None):
    """Handler: after each change of the frame, in the viewport and in a render."""
    for item in followers(scene):
        update(item, depsgraph or bpy.context.evaluated_depsgraph_get(), scene.frame_current, in_place=True)


@persistent
def on_change(scene, depsgraph):
    """Handler: after anything else that may have moved points (a pose, a shape key, edit mode left)."""
    if _writing:
        return
    changed = {update.id.original for update in depsgraph.updates if update.is_updated_geometry}
    for item in followers(scene):
        if item in changed or item.data in changed:
            update(item, depsgraph, scene.frame_current)


@persistent
def on_save(*_):
    """Handler: before a file is saved, the meshes get what is shown."""
    scene = bpy.context.scene
    for item in followers(scene):
        update(item, bpy.context.evaluated_depsgraph_get(), scene.frame_current)


@persistent
def on_forget(*_):
    """Handler: after undo, redo and the loading of a file nothing that was kept is known to be true."""
    forget()
    on_save()


def settings_changed(self, _):
    """Of a property: computes anew."""
    item = self.id_data
    forget(item)
    if self.enabled:
        update(item, bpy.context.evaluated_depsgraph_get(), bpy.context.scene.frame_current)
    else:
        self.message = ""
        remove(item.data, M, TANGENT)


HANDLERS = (
    ("frame_change_post", on_frame),
    ("depsgraph_update_post", on_change),
    ("save_pre", on_save),
    ("undo_post", on_forget),
    ("redo_post", on_forget),
    ("load_post", on_forget),
)


def register():
    for name, handler in HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister():
    for name, handler in HANDLERS:
        handlers = getattr(bpy.app.handlers, name)
        handlers[:] = [h for h in handlers if h is not handler]
    forget()
