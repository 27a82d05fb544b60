"""Taut: gloss that follows the deformation of a mesh, over numpy arrays, and the path tracer that shows it.

    import taut

    gloss = taut.Gloss(rest, faces, uv, alpha=(0.1, 0.3))     # topology and rest shape, once
    M, alpha_max, alpha_min, phi, tangent, stretch = gloss.at(positions)   # each frame

    taut.gloss(rest, deformed, faces, ...)      one frame, one call
    taut.presets["foil"]                        materials whose response to a deformation is known: what taut.Gloss takes
    taut.microsurface                           D, G1, G2, evaluate, pdf, sample, weight, albedo, walk, ... any M per row
    taut.Scene("scene.toml")                    a scene from a file, a dict of the scene file's keys, arrays: render, plan, export
    taut.write_image(path, picture), taut.read_image(path)   .exr and .png
    taut.relative_error(image, reference)       relMSE, as `taut compare` says it
    taut.copies()                               arrays that had to be copied on their way in
    taut.limit_threads(n)                       0: all

Spaces and units. Positions are in any unit; scenes are in metres, z up, right-handed. Angles are radians, but for keys of a scene file
that say `_deg`. alpha is GGX alpha, never its square root. Frame f is at (f - 1) / fps seconds and may be fractional.

Arrays are read in place where they have the type and layout that a function names, and computed on by all threads without the
interpreter's lock.

Errors. InputError (a ValueError): one line, `where: found X, expected Y`, as the command prints it. RunError (a RuntimeError):
something failed while running. An exception in a callback comes out as itself.

Source: "Microsurface Transformations", Computer Graphics Forum 41(4), 2022; docs/pipeline.md says what happens in which order.
"""

from . import _checks, _taut, microsurface
from ._arrays import copies
from ._gloss import Gloss, VertexGloss, gloss, presets
from ._image import read_image, relative_error, write_image
from ._picture import Picture
from ._refinement import Refinement
from ._scene import Scene
from ._taut import InputError, RunError
from ._taut import version as __version__

for _thing in (InputError, RunError):
    _thing.__module__ = "taut"  # where they are found
del _thing


def limit_threads(threads: int) -> None:
    """Limits the threads of everything that taut computes to this many; 0: all of the machine's."""
    _taut.limit_threads(_checks.whole("threads", threads, 0, 1024))


__all__ = [
    "Gloss",
    "InputError",
    "Picture",
    "Refinement",
    "RunError",
    "Scene",
    "VertexGloss",
    "copies",
    "gloss",
    "limit_threads",
    "microsurface",
    "presets",
    "read_image",
    "relative_error",
    "write_image",
]
