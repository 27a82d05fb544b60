"""Arrays of a mesh, there and back."""

import numpy


def points_of(mesh):
    """[vertices, 3] float32, object space."""
    values = numpy.empty(3 * len(mesh.vertices), numpy.float32)
    mesh.vertices.foreach_get("co", values)
    return values.reshape(-1, 3)


def faces_of(mesh):
    """(starts, corners), int32."""
    starts = numpy.empty(len(mesh.polygons), numpy.int32)
    mesh.polygons.foreach_get("loop_start", starts)
    corners = numpy.empty(len(mesh.loops), numpy.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    return starts, corners


def uv_of(mesh):
    """[corners, 2] of the active map; None without one."""
    layer = mesh.uv_layers.active
    if layer is None or len(layer.data) != len(mesh.loops):
        return None
    values = numpy.empty(2 * len(mesh.loops), numpy.float32)
    layer.data.foreach_get("uv", values)
    return values.reshape(-1, 2)


def vectors_of(mesh, name):
    """A vector attribute [n, 3]; None where there is none of its domain's size."""
    attribute = mesh.attributes.get(name)
    if attribute is None or attribute.data_type != "FLOAT_VECTOR":
        return None
    values = numpy.empty(3 * len(attribute.data), numpy.float32)
    attribute.data.foreach_get("vector", values)
    return values.reshape(-1, 3)


def numbers_of(mesh, name):
    """An attribute of points that is numbers, [vertices, columns]; None where there is none."""
    attribute = mesh.attributes.get(name)
    kinds = {"FLOAT": ("value", 1), "FLOAT2": ("vector", 2), "FLOAT_VECTOR": ("vector", 3), "FLOAT_COLOR": ("color", 4)}
    if attribute is None or attribute.domain != "POINT" or attribute.data_type not in kinds:
        return None
    key, columns = kinds[attribute.data_type]
    values = numpy.empty(columns * len(attribute.data), numpy.float32)
    attribute.data.foreach_get(key, values)
    return values.reshape(-1, columns)


def set_vectors(mesh, name, values, domain):
    """A vector at every vertex (POINT) or corner (CORNER)."""
    attribute = mesh.attributes.get(name)
    if attribute is not None and (attribute.domain != domain or attribute.data_type != "FLOAT_VECTOR"):
        mesh.attributes.remove(attribute)
        attribute = None
    if attribute is None:
        attribute = mesh.attributes.new(name, "FLOAT_VECTOR", domain)
    attribute.data.foreach_set("vector", numpy.ascontiguousarray(values, dtype=numpy.float32).ravel())


def write_in_place(mesh, values, domain):
    """Into attributes that are there, {name: [n, 3]}; False where they are not, or not of this domain."""
    attributes = [mesh.attributes.get(name) for name in values]
    if any(
        a is None or a.domain != domain or a.data_type != "FLOAT_VECTOR" or len(a.data) != len(v)
        for a, v in zip(attributes, values.values())
    ):
        return False
    for attribute, rows in zip(attributes, values.values()):
        attribute.data.foreach_set("vector", numpy.ascontiguousarray(rows, dtype=numpy.float32).ravel())
    return True


def remove(mesh, *names):
    for name in names:
        attribute = mesh.attributes.get(name)
        if attribute is not None:
            mesh.attributes.remove(attribute)
