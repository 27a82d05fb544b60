"""The scene of Blender as taut.Scene takes it, rendered by Taut: camera, lights, world and meshes as they stand at the frame.

What Taut has no counterpart for is named in a warning, and its nearest stands in. Meshes whose gloss follows are given with their rest
shape; both shapes are in world space, so the object's own transform is no deformation.
"""

import itertools
import math

import bpy
import numpy
from bpy.props import IntProperty

from . import live, versions
from .attributes import faces_of, points_of, uv_of
from .surfaces import Surfaces, vector
from .textures import NoTexture, panorama

IMAGE = "Taut"


class Description:
    """A dict for taut.Scene, filled part by part."""

    def __init__(self, context, spp):
        self.warnings = []
        self.surfaces = Surfaces(self.warn)
        self.names = set()  # of meshes: an instance has one of its own
        self.depsgraph = context.evaluated_depsgraph_get()
        scene, render = context.scene, context.scene.render
        scale = render.resolution_percentage / 100
        self.size = (max(1, int(render.resolution_x * scale)), max(1, int(render.resolution_y * scale)))
        self.tree = {
            "render": {"width": self.size[0], "height": self.size[1], "spp": spp, "filter": "box"},
            "light": [],
            "material": self.surfaces.materials,
            "mesh": [],
        }
        self.add_camera(scene.camera)
        self.add_world(scene.world)
        for instance in self.depsgraph.object_instances:
            self.add(instance)

    def warn(self, text):
        if text not in self.warnings:
            self.warnings.append(text)

    # --- camera, world, lights ---

    def add_camera(self, item):
        if item is None:
            raise live.Trouble("The scene has no camera")
        item = item.evaluated_get(self.depsgraph)
        data, matrix = item.data, item.matrix_world
        width, height = self.size
        wide = data.sensor_fit == "HORIZONTAL" or (data.sensor_fit == "AUTO" and width >= height)
        camera = {
            "position": vector(matrix.translation),
            "look_at": vector(matrix.translation - matrix.col[2].xyz.normalized()),
            "up": vector(matrix.col[1].xyz),
        }
        if data.type == "ORTHO":
            camera["ortho_height"] = data.ortho_scale * (height / width if wide else 1)
        else:
            half = math.tan(data.angle_y / 2 if data.sensor_fit == "VERTICAL" else data.angle / 2)
            camera["fov_deg"] = math.degrees(2 * math.atan(half * (height / width if wide else 1)))
            if data.type != "PERSP":
                self.warn(f"camera '{item.name}': a panorama is taken as a perspective")
        if data.shift_x or data.shift_y:
            self.warn(f"camera '{item.name}': its shift is left out")
        if data.dof.use_dof:
            camera["aperture_radius"] = data.lens / 1000 / max(1e-6, data.dof.aperture_fstop) / 2
            focus = data.dof.focus_object
            camera["focus_distance"] = (
                (focus.matrix_world.translation - matrix.translation).length if focus else max(1e-6, data.dof.focus_distance)
            )
        self.tree["camera"] = camera

    def add_world(self, world):
        environment = {"radiance": [0.0, 0.0, 0.0]}
        if world is not None and world.use_nodes:
            node = next((n for n in world.node_tree.nodes if n.type == "BACKGROUND"), None)
            if node is not None:
                environment = self.background(world, node)
        elif world is not None:
            environment = {"radiance": vector(world.color)}
        self.tree["environment"] = environment

    def background(self, world, node):
        colour, strength = node.inputs["Color"], node.inputs["Strength"]
        if strength.is_linked:
            self.warn(f"world '{world.name}': what is linked to Strength is left out, its plain value stands in")
        if colour.is_linked:
            try:
                return {**panorama(colour), "scale": float(strength.default_value)}
            except NoTexture as why:
                self.warn(f"world '{world.name}': what is linked to Color ({why}) is left out, its plain value stands in")
        return {"radiance": [float(c) * strength.default_value for c in colour.default_value[:3]]}

    def add_light(self, item, matrix):
        data = item.data
        colour = [float(c) * data.energy for c in data.color]

        def times(factor):
            return [c * factor for c in colour]

        position, axis = matrix.translation, -matrix.col[2].xyz.normalized()
        light = None
        if data.type == "SUN":
            light = {"type": "directional", "direction": vector(axis), "irradiance": colour}
            if data.angle > 0.01:
                self.warn(f"light '{item.name}': a sun of {math.degrees(data.angle):.1f} degrees is taken as a point")
        elif data.type == "AREA":
            x, y = matrix.col[0].xyz * data.size, matrix.col[1].xyz * (data.size_y if data.shape in ("RECTANGLE", "ELLIPSE") else data.size)
            if data.shape in ("DISK", "ELLIPSE"):
                self.warn(f"light '{item.name}': a disk is taken as the rectangle of its area")
                x, y = x * math.sqrt(math.pi) / 2, y * math.sqrt(math.pi) / 2
            area = x.cross(y).length
            light = {
                "type": "quad", "corner": vector(position - x / 2 - y / 2), "u": vector(y), "v": vector(x),
                "radiance": times(versions.rectangle_radiance(1.0, area)), "camera_visible": item.visible_camera,
            }  # fmt: skip
        elif data.shadow_soft_size > 0 and data.type == "POINT":
            radius = data.shadow_soft_size
            light = {
                "type": "sphere", "centre": vector(position), "radius": radius,
                "radiance": times(1 / (4 * math.pi**2 * radius**2)), "camera_visible": item.visible_camera,
            }  # fmt: skip
        else:
            light = {"type": "point", "position": vector(position), "intensity": times(1 / (4 * math.pi))}
            if data.type == "SPOT":
                outer = math.degrees(data.spot_size) / 2
                light.update(
                    type="spot", direction=vector(axis), outer_deg=outer, inner_deg=min(outer * (1 - data.spot_blend), outer * 0.999)
                )
                # Cycles 3.4's spots also fall by the cosine to their axis.
                self.warn(f"light '{item.name}': a spot's falloff, blend and radius are near to Cycles', not the same")
        self.tree["light"].append(light)

    # --- meshes ---

    def add(self, instance):
        item = instance.object
        if not instance.show_self or item.original.hide_render:
            return
        matrix = instance.matrix_world.copy()
        if item.type == "LIGHT":
            self.add_light(item, matrix)
        elif item.type == "MESH":  # those of curves, texts and metaballs too, which are instances beside them
            self.add_mesh(item, matrix)
        elif item.type not in ("CURVE", "SURFACE", "FONT", "META", "CAMERA", "EMPTY", "ARMATURE", "LATTICE", "LIGHT_PROBE", "SPEAKER"):
            self.warn(f"object '{item.name}': of type {item.type}, left out")

    def add_mesh(self, item, matrix):
        mesh, original = item.data, item.original
        if len(mesh.polygons) == 0:
            self.warn(f"object '{item.name}': has no faces, left out")
            return
        world = numpy.array(matrix, dtype=numpy.float64)

        def placed(points):
            return numpy.ascontiguousarray(points.astype(numpy.float64) @ world[:3, :3].T + world[:3, 3], dtype=numpy.float32)

        name = next(n for i in itertools.count(1) if (n := item.name if i == 1 else f"{item.name} {i}") not in self.names)
        self.names.add(name)
        entry = {"name": name, "faces": faces_of(mesh), "smooth": bool(mesh.polygons[0].use_smooth)}
        uv = uv_of(mesh)
        if uv is not None:
            entry["uv"] = uv
        if original.type == "MESH" and original.taut.enabled:
            rest = live.rest_points(original, self.depsgraph)
            points = live.evaluated_points(original, self.depsgraph)  # says so where the topology has changed
            entry.update(positions=placed(rest), points=[placed(points)])
        else:
            entry.update(positions=placed(points_of(mesh)), follow=False)
        used = [self.surfaces.name_of(slot.material, item) for slot in item.material_slots] or [self.surfaces.name_of(None, item)]
        slots = [f"slot {i}" for i in range(len(used))]
        if len(used) > 1:
            chosen = numpy.empty(len(mesh.polygons), numpy.int32)
            mesh.polygons.foreach_get("material_index", chosen)
            entry.update(face_materials=numpy.minimum(chosen, len(used) - 1), material_names=slots, material=dict(zip(slots, used)))
        else:
            entry["material"] = used[0]
        self.tree["mesh"].append(entry)
        for slot, material in zip(slots, used):
            if material in self.surfaces.radiance:
                shining = {"type": "mesh", "mesh": name, "radiance": self.surfaces.radiance[material], "two_sided": True}
                self.tree["light"].append({**shining, "slot": slot} if len(used) > 1 else shining)


def show(picture):
    """The picture as Blender's image of this name, linear, rows upwards as Blender has them."""
    rgb, coverage = picture["rgb"], picture["coverage"]
    height, width = coverage.shape
    image = bpy.data.images.get(IMAGE)
    if image is None or tuple(image.size) != (width, height):
        if image is not None:
            bpy.data.images.remove(image)
        image = bpy.data.images.new(IMAGE, width, height, float_buffer=True)
        versions.set_linear(image.colorspace_settings)
    pixels = numpy.concatenate([rgb, numpy.ones_like(coverage)[..., None]], 2)[::-1]
    image.pixels.foreach_set(numpy.ascontiguousarray(pixels, dtype=numpy.float32).ravel())
    image.update()
    return image


def start(context, spp):
    """(taut.Refinement, warnings) of the scene as it stands."""
    try:
        import taut
    except ImportError:
        raise live.Trouble(live.NO_MODULE) from None
    try:
        description = Description(context, spp)
        scene = taut.Scene(description.tree)
        return scene.refine(1), [*description.warnings, *scene.warnings]
    except (taut.InputError, taut.RunError) as error:
        raise live.Trouble(str(error)) from None


class RenderWithTaut(bpy.types.Operator):
    """Render the scene's camera, lights and meshes with Taut, into the image "Taut"; Escape stops"""

    bl_idname = "taut.render"
    bl_label = "Render with Taut"

    samples: IntProperty(name="Samples", default=64, min=1, max=1 << 20)

    def _start(self, context):
        try:
            refinement, warnings = start(context, self.samples)
        except live.Trouble as trouble:
            self.report({"ERROR"}, str(trouble))
            return None
        for warning in warnings:
            self.report({"WARNING"}, warning)
        return refinement

    def execute(self, context):
        refinement = self._start(context)
        if refinement is None:
            return {"CANCELLED"}
        refinement.advance()
        show(refinement.picture())
        return {"FINISHED"}

    def invoke(self, context, event):
        self._refinement = self._start(context)
        if self._refinement is None:
            return {"CANCELLED"}
        self._timer = context.window_manager.event_timer_add(0.05, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "TIMER":
            state = self._refinement.advance(seconds=0.15)
            show(self._refinement.picture())
            context.workspace.status_text_set(f"Taut: {100 * self._refinement.share:.0f} %, Escape stops")
            if state != "going":
                return self._end(context, {"FINISHED"})
        if event.type == "ESC":
            return self._end(context, {"FINISHED"})
        return {"PASS_THROUGH"}

    def _end(self, context, result):
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)
        return result


def menu_entry(self, _):
    self.layout.operator(RenderWithTaut.bl_idname)


def register():
    bpy.utils.register_class(RenderWithTaut)
    bpy.types.TOPBAR_MT_render.append(menu_entry)


def unregister():
    bpy.types.TOPBAR_MT_render.remove(menu_entry)
    bpy.utils.unregister_class(RenderWithTaut)
