"""Blender add-on: gloss that follows the deformation of meshes, live and from files of `taut export`.

Blender 3.4 and 4.3, those of Debian 12 and 13. `make blender-addon` packs it; Edit > Preferences > Add-ons > Install takes the zip.
Properties > Object Data > Taut Gloss computes gloss of any mesh at each frame, with the Python package taut (`make python`);
Render > Render with Taut renders the scene; File > Import > Taut gloss shows what `taut export` wrote.
"""

bl_info = {
    "name": "Taut gloss",
    "description": "Gloss that follows the deformation of meshes",
    "version": (2, 0, 0),
    "blender": (3, 4, 0),
    "location": "Properties > Object Data > Taut Gloss; Render > Render with Taut; File > Import > Taut gloss",
    "category": "Material",
}

from . import files, live, panel, render  # noqa: E402
from .files import import_gloss, start_following  # noqa: E402, F401: for scripts


def register():
    panel.register()
    render.register()
    files.register()
    live.register()


def unregister():
    live.unregister()
    files.unregister()
    render.unregister()
    panel.unregister()
