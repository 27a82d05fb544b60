"""What differs between the Blender of Debian 12 (3.4) and that of Debian 13 (4.3): all of it is here, for the add-on and the scripts."""

import math

import bpy


def set_sobol(cycles):
    """Cycles' Sobol points."""
    items = {item.identifier for item in cycles.bl_rna.properties["sampling_pattern"].enum_items}
    cycles.sampling_pattern = "SOBOL" if "SOBOL" in items else "TABULATED_SOBOL"


def _first_colour_space(settings, names):
    """The first of several names of a colour space that this Blender has."""
    known = {item.identifier for item in settings.bl_rna.properties["name"].enum_items}
    settings.name = next(name for name in names if name in known)


def set_linear(settings):
    """Linear light of Rec. 709's primaries, for an image's colorspace_settings."""
    _first_colour_space(settings, ("Linear", "Linear Rec.709"))


def set_raw(settings):
    """Numbers as they are."""
    _first_colour_space(settings, ("Raw", "Non-Color"))


def colour_space(name):
    """A texture's `color_space` for an image's; None where it has none."""
    if name == "sRGB":
        return "srgb"
    return "linear" if name in ("Linear", "Linear Rec.709", "Raw", "Non-Color") else None


def rectangle_power(radiance, area):
    """Power of a rectangular lamp of this radiance: 3.4 divides by 4 areas, 4.3 by pi areas, as of a Lambertian emitter."""
    return radiance * area * (4.0 if bpy.app.version < (4, 0, 0) else math.pi)


def rectangle_radiance(power, area):
    """Its inverse."""
    return power / rectangle_power(1.0, area)


def new_socket(group, kind, name, where):
    """A socket of a node group; `where` is INPUT or OUTPUT."""
    if hasattr(group, "interface"):  # 4.0
        return group.interface.new_socket(name, in_out=where, socket_type=kind)
    return (group.inputs if where == "INPUT" else group.outputs).new(kind, name)


def set_loop_totals(mesh, totals):
    """Corners of each polygon; since 3.6 they follow from where the polygons start."""
    if bpy.app.version < (3, 6, 0):
        mesh.polygons.foreach_set("loop_total", totals)


def keep_custom_normals(mesh):
    """Until 4.0 custom normals are ignored without this."""
    if hasattr(mesh, "use_auto_smooth"):
        mesh.use_auto_smooth = True
        mesh.auto_smooth_angle = math.pi


def split_normals(mesh):
    """Brings the normals of its corners up to date; since 4.1 they are whenever they are asked for."""
    if hasattr(mesh, "calc_normals_split"):
        mesh.calc_normals_split()


def has_custom_normals(mesh):
    """Whether normals of its corners are not those of its faces' angles and smoothness."""
    return mesh.has_custom_normals


def has_one_glossy_node():
    """Since 4.0 the anisotropic node is the glossy one."""
    return bpy.app.version >= (4, 0, 0)


GLOSSY_NODES = {"BSDF_ANISOTROPIC", "BSDF_GLOSSY"}  # one node since 4.0, under the first name

EMISSION = ("Emission", "Emission Color")  # of a Principled node; the second since 4.0
# Sockets of a Principled node that Render with Taut does not read, and where each says nothing; the second name is that since 4.0.
PRINCIPLED_PARTS = {
    "Subsurface": 0.0, "Subsurface Weight": 0.0, "Specular": 0.5, "Specular IOR Level": 0.5, "Transmission": 0.0,
    "Transmission Weight": 0.0, "Sheen": 0.0, "Sheen Weight": 0.0, "Clearcoat": 0.0, "Coat Weight": 0.0,
}  # fmt: skip
