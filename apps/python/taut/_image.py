"""Pictures to and from files."""

from __future__ import annotations

import os
from typing import Any, List, Mapping, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _taut
from ._arrays import take
from ._checks import fail, text, whole
from ._picture import Picture, channels_of


def write_image(
    path: Union[str, "os.PathLike[str]"], picture: Union[ArrayLike, Mapping[str, NDArray[Any]]], **image: Any
) -> None:
    """Writes what Scene.render returned, or an array (height, width) or (height, width, 3 or 4), linear, row 0 the top.

    .exr: all channels, named as by the command, scene linear; .png: the first three for a display. Beside its name first, then renamed.
    image  keys of a scene file's [image]: exposure, view, display, look, ocio, space, bits, compression; what is not given is as the
           picture's scene says, else as by default (docs/colour.md): write_image("a.png", picture, exposure=1, view="filmic").
    """
    metadata: Sequence[Tuple[str, str]] = []
    settings = _taut.ImageSettings()
    if isinstance(picture, Picture):
        metadata, settings = list(picture.metadata.items()), picture.settings
    if isinstance(picture, Mapping):
        pixels, names = channels_of(picture)
    else:
        pixels = take("picture", picture, np.float32)
        if pixels.ndim == 2:
            pixels = np.repeat(pixels[..., None], 3, 2)
        if pixels.ndim != 3 or pixels.shape[2] not in (3, 4) or pixels.size == 0:
            fail("picture", f"an array of shape {pixels.shape}", "(height, width), (height, width, 3) or (height, width, 4)")
        names = list("RGBA"[: pixels.shape[2]])
    _taut.write_image(text("path", path), np.ascontiguousarray(pixels), names, metadata, settings, image, "")


def read_image(path: Union[str, "os.PathLike[str]"]) -> Tuple[NDArray[np.float32], List[str]]:
    """An image as (height, width, channels) float32 with the names of its channels; of a .png the values stand as stored, in [0, 1]."""
    pixels, names = _taut.read_image(text("path", path))
    return pixels, names


def relative_error(image: ArrayLike, reference: ArrayLike, box: int = 1) -> float:
    """How far an image (height, width, 3) is from a reference, linear: relMSE of `taut compare`, the mean over the pixels that either lights,
    and colours, of (image - reference)^2 / (reference^2 + 0.01 mean(reference)^2). box: of means of so many pixels each way, which noise
    hardly touches."""
    pixels = [take(name, value, np.float32) for name, value in (("image", image), ("reference", reference))]
    for name, values in zip(("image", "reference"), pixels):
        if values.ndim != 3 or values.shape[2] != 3 or values.shape != pixels[0].shape or values.size == 0:
            fail(name, f"an array of shape {values.shape}", "(height, width, 3), the same for both")
    size = whole("box", box, 1, min(pixels[0].shape[:2]))
    return _taut.relative_error(np.ascontiguousarray(pixels[0]), np.ascontiguousarray(pixels[1]), size)
