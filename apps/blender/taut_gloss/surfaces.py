"""Materials of objects as [material.NAME] of a scene file, and what they emit.

What Taut has no counterpart for is named in a warning, and its nearest stands in.
"""

import math

import bpy

from . import material as gloss_material
from . import versions
from .textures import NoTexture, source, texture


def vector(v):
    return [float(x) for x in v]


def _reflectance(colour):
    return [min(1.0, max(0.0, float(x))) for x in colour[:3]]


def _scaled(given, factor):
    """A colour or a texture times a number or three."""
    if isinstance(given, dict):
        return {**given, "scale": factor}
    return [g * f for g, f in zip(given, factor if isinstance(factor, list) else [factor] * 3)]


class _Shader:
    """The sockets of a shader node."""

    def __init__(self, material, node, mesh, warn):
        self.material, self.node, self.mesh = material, node, mesh
        self.warn = lambda text: warn(f"material '{material.name}': {text}")

    def has(self, name):
        return name in self.node.inputs

    def plain(self, name):
        """The number or colour of a socket, whatever is linked to it."""
        socket = self.node.inputs[name]
        if socket.is_linked and not self.is_ours(socket):
            self.warn(f"what is linked to {name} is left out, its plain value stands in")
        return socket.default_value

    @staticmethod
    def is_ours(socket):
        """Whether the gloss that the panel computes is linked to it."""
        node = source(socket).node
        return node.type == "GROUP" and node.node_tree is not None and node.node_tree.name == gloss_material.GROUP

    def given(self, name, number):
        """A socket's texture, number or colour."""
        socket = self.node.inputs[name]
        if socket.is_linked and not self.is_ours(socket):
            try:
                return texture(socket, self.mesh, number, self.warn)
            except NoTexture as why:
                self.warn(f"what is linked to {name} ({why}) is left out, its plain value stands in")
        return float(socket.default_value) if number else vector(socket.default_value[:3])

    def colour(self, name):
        """Of what reflects, at most 1."""
        given = self.given(name, False)
        return given if isinstance(given, dict) else _reflectance(given)

    def slopes(self):
        """{"normal": a map}, or nothing."""
        socket = self.node.inputs.get("Normal")
        if socket is None or not socket.is_linked:
            return {}
        node = source(socket).node
        try:
            if node.type != "NORMAL_MAP" or node.space != "TANGENT" or not node.inputs["Color"].is_linked:
                raise NoTexture(node.bl_label)
            keys = texture(node.inputs["Color"], self.mesh, False, self.warn)
            strength = float(node.inputs["Strength"].default_value)
        except NoTexture as why:
            self.warn(f"what is linked to Normal ({why}) is left out")
            return {}
        if strength != 1:
            self.warn(f"the strength {strength:g} of its normal map is taken as a scale of slopes")
        return {"normal": {**keys, "scale": strength}}


def _alphas(largest, smallest):
    return [min(10.0, max(1e-4, float(a))) for a in (largest, smallest)]


def _masking(shader):
    if shader.node.distribution == "MULTI_GGX":
        return {"multiscatter": "auto", "masking": "correlated"}
    # "Separable" is the masking of Cycles 3.4; correlated since.
    return {"multiscatter": "off", "masking": "separable" if bpy.app.version < (4, 0, 0) else "correlated"}


def _glossy(shader):
    import taut.microsurface as ms

    shown = {"roughness": abs(shader.plain("Roughness")), "anisotropy": 0.0, "rotation": 0.0}
    if shader.has("Anisotropy"):
        shown.update(anisotropy=shader.plain("Anisotropy"), rotation=shader.plain("Rotation"))
    largest, smallest, phi = ms.from_convention("blender_anisotropic", **shown)
    return {
        "type": "conductor", "f0": shader.colour("Color"), "alpha": _alphas(largest, smallest), "rotation_deg": math.degrees(phi),
        **_masking(shader),
    }  # fmt: skip


def _principled(shader):
    import taut.microsurface as ms

    found = {"type": "metallic_roughness", "color": shader.colour("Base Color"), "metallic": shader.given("Metallic", True)}
    found.update(_masking(shader))
    roughness = shader.given("Roughness", True)
    if isinstance(roughness, dict):
        found["roughness"] = roughness
        if shader.plain("Anisotropic"):
            shader.warn("its anisotropy is left out, with a texture for Roughness")
    else:
        largest, smallest, phi = ms.from_convention(
            "blender", roughness=roughness, anisotropic=shader.plain("Anisotropic"), rotation=shader.plain("Anisotropic Rotation")
        )
        found.update(alpha=_alphas(largest, smallest), rotation_deg=math.degrees(phi))
    opacity = shader.given("Alpha", True)
    if isinstance(opacity, dict) or opacity < 1:
        found["opacity"] = opacity
    for name, neutral in versions.PRINCIPLED_PARTS.items():
        if shader.has(name) and (shader.node.inputs[name].is_linked or shader.node.inputs[name].default_value != neutral):
            shader.warn(f"{name} is left out")
    return found


def _principled_radiance(shader):
    name = next(name for name in versions.EMISSION if shader.has(name))
    return _scaled(shader.given(name, False), float(shader.plain("Emission Strength")))


def _glass(shader):
    alpha = min(10.0, max(1e-4, shader.plain("Roughness") ** 2))
    return {"type": "dielectric", "color": shader.colour("Color"), "ior": shader.plain("IOR"), "alpha": alpha}


def _diffuse(shader):
    return {"type": "diffuse", "color": shader.colour("Color")}


def _emission(_):
    return {"type": "diffuse", "color": 0.0}


def _emission_radiance(shader):
    return _scaled(shader.given("Color", False), float(shader.plain("Strength")))


SHADERS = {
    **{kind: (_glossy, None) for kind in versions.GLOSSY_NODES},
    "BSDF_PRINCIPLED": (_principled, _principled_radiance),
    "BSDF_GLASS": (_glass, None),
    "BSDF_DIFFUSE": (_diffuse, None),
    "EMISSION": (_emission, _emission_radiance),
}


def _shines(radiance):
    return max(vector([radiance["scale"]] if isinstance(radiance, dict) else radiance)) > 0


class Surfaces:
    """`materials` of a scene, filled as objects ask for them, and `radiance` of those that emit, by the same names."""

    def __init__(self, warn):
        self.warn, self.materials, self.radiance = warn, {}, {}

    def name_of(self, material, item):
        """The name of a material of an object; gloss that follows has the rest gloss of the object's panel."""
        settings = item.original.taut
        name = (material.name if material else "none") + (f" of {item.name}" if settings.enabled else "")
        if name not in self.materials:
            found = self.materials[name] = self._described(name, material, item.data)
            if settings.enabled and found["type"] != "diffuse":
                rest = settings.material()
                found.pop("roughness", None)
                found.update(
                    alpha=vector(rest["alpha"]), rotation_deg=math.degrees(rest["rotation"]), poisson=rest["poisson"],
                    roughening=rest["roughening"], **{"yield": rest["yield_strain"]},
                )  # fmt: skip
                if settings.alpha_attribute:
                    self.warn(f"object '{item.name}': its alpha by attribute is left out, the panel's numbers stand in")
        return name

    def _described(self, name, material, mesh):
        tree = material.node_tree if material is not None and material.use_nodes else None
        if tree is None:
            return {"type": "diffuse", "color": _reflectance(material.diffuse_color) if material else [0.8] * 3}
        output = tree.get_output_node("CYCLES") or tree.get_output_node("ALL")
        surface = output.inputs["Surface"] if output else None
        node = source(surface).node if surface is not None and surface.is_linked else None
        if node is None or node.type not in SHADERS:
            self.warn(f"material '{material.name}': {node.bl_label if node else 'nothing'} at its output is taken as grey paint")
            return {"type": "diffuse", "color": 0.8}
        shader = _Shader(material, node, mesh, self.warn)
        describe, radiance = SHADERS[node.type]
        if radiance is not None:
            shines = radiance(shader)
            if _shines(shines):
                self.radiance[name] = shines
        return {**describe(shader), **shader.slopes()}
