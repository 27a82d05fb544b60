"""The panel of a mesh, its settings and buttons."""

import os

import bpy
import numpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, PointerProperty, StringProperty

from . import live, material
from .attributes import set_vectors


class TautSettings(bpy.types.PropertyGroup):
    """Of an object."""

    enabled: BoolProperty(name="Gloss Follows Deformation", update=live.settings_changed)
    rest: EnumProperty(
        name="Rest",
        items=[
            ("BIND", "Bind", "The mesh itself, before shape keys and modifiers"),
            ("FRAME", "Frame", "The shape at a frame, taken by a button and kept with the mesh"),
            ("OBJECT", "Object", "Another mesh object of the same topology"),
        ],
        update=live.settings_changed,
    )
    rest_frame: IntProperty(name="Rest Frame", default=1)
    rest_object: PointerProperty(
        name="Rest Object", type=bpy.types.Object, poll=lambda _, o: o.type == "MESH", update=live.settings_changed
    )
    alpha: FloatVectorProperty(
        name="Alpha", size=2, default=(0.1, 0.3), min=1e-4, max=10, soft_max=1, precision=3,
        description="GGX alpha along and across the tangent (dP/du), at rest; the square of Blender's roughness",
        update=live.settings_changed,
    )  # fmt: skip
    rotation: FloatProperty(
        name="Rotation", subtype="ANGLE", description="Of the rest material about the normal", update=live.settings_changed
    )
    poisson: FloatProperty(
        name="Poisson", default=0, min=-1, max=0.5,
        description="Poisson's ratio: 0 keeps the thickness, 0.5 the volume, -1 leaves alpha alone where all is scaled",
        update=live.settings_changed,
    )  # fmt: skip
    roughening: FloatProperty(
        name="Roughening", default=0, min=0, soft_max=1, precision=3,
        description="Alpha that metal gains per unit of strain beyond the yield; 0: gloss follows geometry alone, as rubber's and skin's",
        update=live.settings_changed,
    )  # fmt: skip
    yield_strain: FloatProperty(
        name="Yield", default=0, min=0, soft_max=0.1, precision=4,
        description="The strain from which metal roughens; about 0.002 to 0.01",
        update=live.settings_changed,
    )  # fmt: skip
    alpha_attribute: StringProperty(
        name="Alpha Attribute", description="An attribute of the mesh's points in the place of Alpha: a number, or two as it has",
        update=live.settings_changed,
    )  # fmt: skip
    use_cache: BoolProperty(name="Use Baked", description="Read what was baked instead of computing", update=live.settings_changed)
    cache: StringProperty(name="Folder", subtype="DIR_PATH", default="//taut_gloss/", description="Of baked gloss, a file a frame")
    message: StringProperty(options={"SKIP_SAVE"})

    def material(self):
        """The material at rest, as taut.Gloss takes it."""
        names = ("rotation", "poisson", "roughening", "yield_strain")
        return {"alpha": tuple(self.alpha), **{name: getattr(self, name) for name in names}}


class _OnMesh:
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == "MESH"


class SetMaterial(_OnMesh, bpy.types.Operator):
    """Let the Principled, Glossy or Anisotropic nodes of its materials show the gloss; a mesh without a material gets one"""

    bl_idname = "taut.set_material"
    bl_label = "Set Up Material"

    def execute(self, context):
        told = material.set_up(context.object)
        self.report({"INFO" if told[0] else "WARNING"}, told[1])
        return {"FINISHED" if told[0] else "CANCELLED"}


def _presets(_self, _context):
    """Items of a menu, which Blender wants kept."""
    try:
        import taut
    except ImportError:
        return []
    _presets.items = [(name, name.capitalize(), "") for name in taut.presets]
    return _presets.items


class TakePreset(_OnMesh, bpy.types.Operator):
    """Take the alpha, Poisson's ratio and roughening of a material whose response to a deformation is known"""

    bl_idname = "taut.take_preset"
    bl_label = "Preset"

    preset: EnumProperty(name="Preset", items=_presets)

    def execute(self, context):
        import taut

        for name, value in taut.presets[self.preset].items():
            setattr(context.object.taut, name, value)
        return {"FINISHED"}


class TakeRest(_OnMesh, bpy.types.Operator):
    """Take the evaluated shape at the rest frame as the rest shape, and keep it with the mesh"""

    bl_idname = "taut.take_rest"
    bl_label = "Take Rest"

    def execute(self, context):
        item, scene = context.object, context.scene
        frame = scene.frame_current
        enabled = item.taut.enabled
        try:
            if live.uses_of(item.data) > 1:
                raise live.Trouble(f"Mesh '{item.data.name}' has several users: make it a single user")
            item.taut["enabled"] = False  # no gloss of the shape that is to be replaced
            scene.frame_set(item.taut.rest_frame)
            rest = live.evaluated_points(item, context.evaluated_depsgraph_get())
            set_vectors(item.data, live.REST, rest, "POINT")
        except live.Trouble as trouble:
            self.report({"ERROR"}, str(trouble))
            return {"CANCELLED"}
        finally:
            item.taut["enabled"] = enabled
            live.forget(item)
            scene.frame_set(frame)
        return {"FINISHED"}


class Bake(_OnMesh, bpy.types.Operator):
    """Write the gloss of the scene's frames to files, which are read instead of computing"""

    bl_idname = "taut.bake"
    bl_label = "Bake"

    def execute(self, context):
        item, scene = context.object, context.scene
        frame = scene.frame_current
        if item.taut.cache.startswith("//") and not bpy.data.filepath:
            self.report({"ERROR"}, "Save the file first, or choose a folder that is not relative to it")
            return {"CANCELLED"}
        try:
            os.makedirs(bpy.path.abspath(item.taut.cache), exist_ok=True)
            item.taut["use_cache"] = False
            for number in range(scene.frame_start, scene.frame_end + 1):
                scene.frame_set(number)
                live.forget(item)
                (m, tangent), domain, _ = live.compute(item, context.evaluated_depsgraph_get())
                path = live.cache_path(item, number)
                numpy.savez(path + ".part.npz", **{live.M: m, live.TANGENT: tangent, "domain": domain})
                os.replace(path + ".part.npz", path)
        except (live.Trouble, OSError) as trouble:
            self.report({"ERROR"}, str(trouble))
            return {"CANCELLED"}
        finally:
            scene.frame_set(frame)
        item.taut.use_cache = True
        return {"FINISHED"}


class SingleUser(_OnMesh, bpy.types.Operator):
    """Give the object a mesh of its own"""

    bl_idname = "taut.single_user"
    bl_label = "Make Single User"

    def execute(self, context):
        context.object.data = context.object.data.copy()
        live.forget(context.object)
        return {"FINISHED"}


class TautPanel(bpy.types.Panel):
    bl_idname = "DATA_PT_taut_gloss"
    bl_label = "Taut Gloss"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "data"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == "MESH"

    def draw_header(self, context):
        self.layout.prop(context.object.taut, "enabled", text="")

    def draw(self, context):
        layout, item = self.layout, context.object
        settings = item.taut
        layout.use_property_split = True
        if settings.message:
            for line in _wrapped(settings.message, 60):
                layout.label(text=line, icon="ERROR" if line == settings.message[: len(line)] else "NONE")
        if live.uses_of(item.data) > 1:
            layout.operator(SingleUser.bl_idname)
        layout.prop(settings, "rest")
        if settings.rest == "FRAME":
            row = layout.row(align=True)
            row.prop(settings, "rest_frame")
            row.operator(TakeRest.bl_idname, text="Take")
        elif settings.rest == "OBJECT":
            layout.prop(settings, "rest_object")
        layout.operator_menu_enum(TakePreset.bl_idname, "preset")
        layout.prop_search(settings, "alpha_attribute", item.data, "attributes")
        for name in ("alpha", "rotation", "poisson", "roughening", "yield_strain"):
            layout.prop(settings, name)
        layout.operator(SetMaterial.bl_idname)
        layout.prop(settings, "cache")
        row = layout.row(align=True)
        row.prop(settings, "use_cache")
        row.operator(Bake.bl_idname)


def _wrapped(text, width):
    lines, line = [], ""
    for word in text.split():
        if line and len(line) + 1 + len(word) > width:
            lines.append(line)
            line = ""
        line = f"{line} {word}".strip()
    return [*lines, line]


CLASSES = (TautSettings, SetMaterial, TakePreset, TakeRest, Bake, SingleUser, TautPanel)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Object.taut = PointerProperty(type=TautSettings)


def unregister():
    del bpy.types.Object.taut
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
