"""The material of a transformed microsurface: roughness, anisotropy and rotation worked out where the surface is shaded, from M and the
tangent interpolated over the triangle. phi itself must not be interpolated: it jumps by half a turn.

The node group "Taut gloss" holds the conversions of src/taut/microsurface/conventions.h, rows blender_anisotropic and blender.
"""

import math

import bpy

from . import versions

GROUP = "Taut gloss"  # the node group's name


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


def gloss_group():
    """Node group: M as a vector (a, b, d) -> roughness, anisotropy, rotation of the Glossy / Anisotropic BSDF.

    Anisotropic is Principled's.
    """
    known = bpy.data.node_groups.get(GROUP)
    if known is not None:
        return known
    group = bpy.data.node_groups.new(GROUP, "ShaderNodeTree")
    versions.new_socket(group, "NodeSocketVector", "M", "INPUT")
    for name in ("Roughness", "Anisotropy", "Rotation", "Anisotropic"):
        versions.new_socket(group, "NodeSocketFloat", name, "OUTPUT")
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
    # Row blender: (1 - q) / 0.9 with q = (1 + anisotropy)^2, held in [0, 1].
    ratio = math_node("ADD", anisotropy, 1.0)
    principled = math_node("DIVIDE", math_node("SUBTRACT", 1.0, math_node("MULTIPLY", ratio, ratio)), 0.9)
    principled = math_node("MAXIMUM", math_node("MINIMUM", principled, 1.0), 0.0)
    for socket, value in zip(end.inputs, (roughness, anisotropy, rotation, principled)):
        group.links.new(value, socket)
    return group


def _attribute(tree, name):
    """The Vector of an attribute node, made once a tree."""
    for node in tree.nodes:
        if node.type == "ATTRIBUTE" and node.attribute_name == name:
            return node.outputs["Vector"]
    node = tree.nodes.new("ShaderNodeAttribute")
    node.attribute_type, node.attribute_name = "GEOMETRY", name
    return node.outputs["Vector"]


def _group_node(tree):
    group = gloss_group()
    for node in tree.nodes:
        if node.type == "GROUP" and node.node_tree == group:
            return node
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    tree.links.new(_attribute(tree, "taut_m"), node.inputs["M"])
    return node


def _connect(tree, node, names):
    """Links the group's outputs and the tangent to a BSDF's sockets of these names."""
    group = _group_node(tree)
    for output, socket in names.items():
        tree.links.new(group.outputs[output], node.inputs[socket])
    tree.links.new(_attribute(tree, "taut_tangent"), node.inputs["Tangent"])


_ANISOTROPIC = {"Roughness": "Roughness", "Anisotropy": "Anisotropy", "Rotation": "Rotation"}
_PRINCIPLED = {"Roughness": "Roughness", "Anisotropic": "Anisotropic", "Rotation": "Anisotropic Rotation"}


def _as_anisotropic(tree, node):
    """A Glossy node without anisotropy gives way to one that has it."""
    if "Anisotropy" in node.inputs:
        return node
    new = tree.nodes.new("ShaderNodeBsdfAnisotropic")
    new.location, new.distribution = node.location, "GGX"
    for name in ("Color", "Normal"):
        new.inputs[name].default_value = node.inputs[name].default_value
        for link in node.inputs[name].links:
            tree.links.new(link.from_socket, new.inputs[name])
    for link in list(node.outputs[0].links):
        tree.links.new(new.outputs[0], link.to_socket)
    tree.nodes.remove(node)
    return new


def follow(material):
    """Connects every Principled, Glossy and Anisotropic node of a material; how many there were."""
    if not material.use_nodes:
        material.use_nodes = True
    tree, count = material.node_tree, 0
    for node in list(tree.nodes):
        if node.type == "BSDF_PRINCIPLED":
            if hasattr(node, "distribution"):
                node.distribution = "GGX"
            _connect(tree, node, _PRINCIPLED)
        elif node.type in versions.GLOSSY_NODES:
            node = _as_anisotropic(tree, node)
            node.distribution = "GGX"
            _connect(tree, node, _ANISOTROPIC)
        else:
            continue
        count += 1
    return count


def set_up(item):
    """All materials of an object; (whether any shows the gloss, a sentence)."""
    materials = [slot.material for slot in item.material_slots if slot.material is not None]
    if not materials:
        materials = [make_material(item.name + " gloss")]
        if item.material_slots:
            item.material_slots[0].material = materials[0]
        else:
            item.data.materials.append(materials[0])
        return True, f"{item.name} had no material and has a metal now"
    counts = {m.name: follow(m) for m in materials if m.library is None}
    none = [name for name, count in counts.items() if count == 0]
    if none:
        return len(none) < len(counts), f"No Principled, Glossy or Anisotropic node in {', '.join(none)}"
    if not counts:
        return False, "Its materials are linked from another file"
    count = sum(counts.values())
    return True, f"{count} node{'s follow' if count > 1 else ' follows'} the gloss"


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
    _connect(material.node_tree, glossy, _ANISOTROPIC)
    links.new(glossy.outputs["BSDF"], output.inputs["Surface"])
    return material
