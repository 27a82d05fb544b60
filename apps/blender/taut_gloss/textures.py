"""Images that a material's nodes read, as textures of a scene file (docs/scene.md)."""

import os

import bpy
import numpy

from . import versions

LARGEST = 1 << 24  # texels of an image that is looked through


class NoTexture(Exception):
    """What a socket is linked to cannot be said as a texture; why."""


def source(socket):
    """The output that a linked socket has its values from, past reroutes."""
    found = socket.links[0].from_socket
    while found.node.type == "REROUTE" and found.node.inputs[0].is_linked:
        found = found.node.inputs[0].links[0].from_socket
    return found


def file_of(image):
    """The path of an image; one that is packed, made or painted here is written to Blender's temporary folder first."""
    import taut

    if image.source not in ("FILE", "GENERATED"):
        raise NoTexture(f"the {image.source.lower()} '{image.name}'")
    path = bpy.path.abspath(image.filepath, library=image.library)
    if image.source == "FILE" and image.packed_file is None and not image.is_dirty:
        if not os.path.isfile(path):
            raise NoTexture(f"the image '{image.name}', which is missing: {path}")
        return path
    folder = os.path.join(bpy.app.tempdir, "taut")
    os.makedirs(folder, exist_ok=True)
    if image.packed_file is not None and not image.is_dirty:
        path = os.path.join(folder, bpy.path.clean_name(image.name_full) + os.path.splitext(path)[1])
        with open(path, "wb") as file:
            file.write(image.packed_file.data)
        return path
    path = os.path.join(folder, bpy.path.clean_name(image.name_full) + ".exr")
    if image.size[0] * image.size[1] == 0:
        raise NoTexture(f"the image '{image.name}', which has no pixels")
    taut.write_image(path, texels_of(image)[::-1])
    return path


def texels_of(image):
    """As they are stored, [height, width, channels], rows from the bottom."""
    texels = numpy.empty(len(image.pixels), numpy.float32)
    image.pixels.foreach_get(texels)
    return texels.reshape(image.size[1], image.size[0], image.channels)


def _is_grey(image):
    if image.channels == 1:
        return True
    if image.size[0] * image.size[1] > LARGEST:
        return False
    texels = texels_of(image)
    return bool((texels[..., :1] == texels[..., 1:3]).all())


def _tiles(node):
    """How often the image stands on a unit of u and of v, by a Mapping node; and the socket it maps."""
    inputs = node.inputs
    moved = any(inputs[name].is_linked or any(inputs[name].default_value) for name in ("Location", "Rotation") if name in inputs)
    scale = tuple(inputs["Scale"].default_value)[:2]
    if moved or inputs["Scale"].is_linked or min(scale) <= 0 or node.vector_type not in ("POINT", "TEXTURE"):
        raise NoTexture("a Mapping that does more than scale")
    if not inputs["Vector"].is_linked:
        raise NoTexture("a Mapping of nothing")
    return [float(s) if node.vector_type == "POINT" else 1 / float(s) for s in scale], inputs["Vector"]


def _placement(node, mesh):
    """Keys that say where the image of a node stands on a mesh, whose active UV map is the one that Taut is given."""
    if node.projection != "FLAT":
        raise NoTexture("an image that is not projected flat")
    keys, at = {}, node.inputs["Vector"]
    if at.is_linked and source(at).node.type == "MAPPING":
        keys["tile"], at = _tiles(source(at).node)
    name = ""
    if at.is_linked:
        out = source(at)
        if out.node.type == "UVMAP":
            name = out.node.uv_map
        elif out.node.type == "ATTRIBUTE":
            name = out.node.attribute_name
        elif out.node.type != "TEX_COORD" or out.name != "UV":
            raise NoTexture(f"coordinates by {out.node.bl_label}, {out.name}")
    if not mesh.uv_layers:
        raise NoTexture("a mesh without a UV map")
    name = name or next((layer.name for layer in mesh.uv_layers if layer.active_render), mesh.uv_layers[0].name)
    if name != mesh.uv_layers.active.name:
        raise NoTexture(f"the UV map '{name}', which is not the active one")
    if node.extension == "EXTEND":
        keys["repeat"] = False
    return keys


def texture(socket, mesh, number, warn):
    """A linked socket as a texture, of numbers or of colours; NoTexture where it is none. warn(text): of what stands in."""
    out, channel = source(socket), None
    if number and out.node.type in ("SEPARATE_COLOR", "SEPRGB") and getattr(out.node, "mode", "RGB") == "RGB":
        if not out.node.inputs[0].is_linked:
            raise NoTexture("a colour that is not an image's")
        channel = out.name[0].lower()
        out = source(out.node.inputs[0])
    node = out.node
    if node.type != "TEX_IMAGE":
        raise NoTexture(node.bl_label)
    image = node.image
    if image is None:
        raise NoTexture("an Image Texture without an image")
    keys = {"file": file_of(image), **_placement(node, mesh)}
    space = versions.colour_space(image.colorspace_settings.name)
    if space is None:
        warn(f"image '{image.name}': its colour space {image.colorspace_settings.name} is taken as its file says")
    else:
        keys["color_space"] = space
    if node.extension not in ("REPEAT", "EXTEND"):
        warn(f"image '{image.name}': repeats, instead of {node.extension.lower()}")
    if node.interpolation not in ("Linear", "Cubic", "Smart"):
        warn(f"image '{image.name}': is interpolated linearly, instead of {node.interpolation.lower()}")
    if number and out.name == "Alpha":
        channel, keys["color_space"] = "a", "linear"
    elif number and channel is None:
        channel = "r" if _is_grey(image) else "g"
        if channel == "g":
            warn(f"image '{image.name}': is coloured, and its green stands for its luminance")
    elif out.name != "Color":
        raise NoTexture(f"{out.name} of an image for a colour")
    if channel is not None:
        keys["channel"] = channel
    return keys


def panorama(socket):
    """A linked colour of the world: keys of [environment]."""
    node = source(socket).node
    if node.type != "TEX_ENVIRONMENT" or node.projection != "EQUIRECTANGULAR":
        raise NoTexture(node.bl_label)
    if node.image is None:
        raise NoTexture("an Environment Texture without an image")
    keys, at = {"file": file_of(node.image)}, node.inputs["Vector"]
    if at.is_linked and source(at).node.type == "MAPPING":
        mapping = source(at).node
        turn = mapping.inputs["Rotation"].default_value
        plain = not any(mapping.inputs[name].is_linked for name in ("Location", "Rotation", "Scale") if name in mapping.inputs)
        if not plain or turn[0] or turn[1] or len(set(mapping.inputs["Scale"].default_value)) > 1 or mapping.vector_type != "POINT":
            raise NoTexture("a Mapping that does more than turn about z")
        keys["rotation_deg"] = -float(numpy.degrees(turn[2]))
        at = mapping.inputs["Vector"]
    if at.is_linked and (source(at).node.type != "TEX_COORD" or source(at).name not in ("Generated", "Object")):
        raise NoTexture(f"coordinates by {source(at).node.bl_label}")
    return keys
