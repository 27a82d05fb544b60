"""Pictures to and from files."""

from __future__ import annotations

import os
from typing import Any, List, Mapping, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _taut
from ._arrays import take
from ._checks import fail, text

_aov_channels = {name: channels for name, channels in _taut.aovs}


def write_image(path: Union[str, "os.PathLike[str]"], picture: Union[ArrayLike, Mapping[str, NDArray[Any]]]) -> None:
    """Writes what Scene.render returned, or an array (height, width) or (height, width, 3 or 4), linear, row 0 the top.

    .exr: all channels as float, named as by the command; .png: 8 bit sRGB of the first three. Beside its name first, then renamed.
    """
    if isinstance(picture, Mapping):
        parts: List[NDArray[Any]] = [picture["rgb"]]
        names = ["R", "G", "B"]
        for key, values in picture.items():
            channels = ["A"] if key == "coverage" else _aov_channels.get(key, [])
            if channels:
                parts.append(values.reshape(*values.shape[:2], len(channels)))
                names += channels
        pixels = np.concatenate(parts, 2, dtype=np.float32)
    else:
        pixels = take("picture", picture, np.float32)
        if pixels.ndim == 2:
            pixels = np.repeat(pixels[..., None], 3, 2)
        if pixels.ndim != 3 or pixels.shape[2] not in (3, 4) or pixels.size == 0:
            fail("picture", f"an array of shape {pixels.shape}", "(height, width), (height, width, 3) or (height, width, 4)")
        names = list("RGBA"[: pixels.shape[2]])
    _taut.write_image(text("path", path), np.ascontiguousarray(pixels), names)


def read_image(path: Union[str, "os.PathLike[str]"]) -> Tuple[NDArray[np.float32], List[str]]:
    """An image as (height, width, channels) float32 with the names of its channels; of a .png the values stand as stored, in [0, 1]."""
    pixels, names = _taut.read_image(text("path", path))
    return pixels, names
