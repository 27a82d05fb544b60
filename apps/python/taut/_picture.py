"""A frame as arrays, and how its channels are called in a file."""

from __future__ import annotations

import json
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import NDArray

from . import _taut
from ._checks import fail, text

_PLAIN = {"R": "rgb", "A": "coverage", "Noisy.R": "noisy", "DenoiseError": "denoise_error", "Variance.R": "variance", "Samples.X": "samples"}
_MATTES = {"CryptoObject": "crypto_object", "CryptoMaterial": "crypto_material"}
_aovs: Dict[str, Tuple[str, int]] = {channels[0]: (name, len(channels)) for name, channels in _taut.aovs}
"""Name and number of channels, by the first channel's name in a film."""
_aov_channels: Dict[str, List[str]] = {name: channels for name, channels in _taut.aovs}


class Picture(Dict[str, NDArray[Any]]):
    """What Scene.render returns: a dict of arrays, row 0 the top, that taut.write_image writes as the command writes its files.

    channels   names of a key's channels in a file, in the order of the array
    metadata   what a file says of it: seed, samples, names of mattes
    settings   how the scene wants it seen and stored: its [image]
    """

    channels: Dict[str, List[str]]
    metadata: Dict[str, str]
    settings: _taut.ImageSettings

    def __init__(self, pixels: NDArray[np.float32], names: Sequence[str], samples: NDArray[np.uint32]) -> None:
        super().__init__()
        self.channels = {}
        self.metadata = {}
        self.settings = _taut.ImageSettings()
        at = 0
        while at < len(names):
            key, count = self._place(names, at)
            self.channels[key] = list(names[at : at + count])
            if key.startswith("crypto_"):
                self[key] = pixels[..., at : at + count].reshape(*pixels.shape[:2], -1, 2)
            elif key != "samples":
                self[key] = pixels[..., at] if count == 1 else pixels[..., at : at + count]
            if key == "coverage":
                self["samples"] = samples
            at += count

    @staticmethod
    def _place(names: Sequence[str], at: int) -> Tuple[str, int]:
        """Key and number of the channels that begin at one."""
        first = names[at]
        if first in _aovs:
            return _aovs[first]
        layer = first.rpartition(".")[0]
        for begin, key in _MATTES.items():
            if layer.startswith(begin):
                return key, sum(name.startswith(begin) for name in names)
        key = "light_" + layer[len("Light_") :] if layer.startswith("Light_") else _PLAIN[first]
        return key, 1 if key in ("coverage", "denoise_error", "samples") else 3

    def matte(self, name: str, kind: str = "object") -> NDArray[np.float32]:
        """The share of each pixel, (height, width), that an object covers by its name in the scene, or with `kind` "material" what has that
        material: of a picture with `crypto_object` or `crypto_material` among its aovs, as far as their ranks go (Cryptomatte 1.2.0)."""
        key = f"crypto_{kind}"
        if key not in self:
            fail("matte", f"a picture without '{key}'", f"one that was rendered with aovs=[{key!r}]")
        layer = {value: begin for begin, value in _MATTES.items()}[key]
        root = next(entry[: -len("name")] for entry, value in self.metadata.items() if entry.endswith("/name") and value == layer)
        manifest: Dict[str, str] = json.loads(self.metadata[root + "manifest"])
        if text("matte", name) not in manifest:
            fail("matte", repr(name), "one of " + ", ".join(manifest))
        ids = np.ascontiguousarray(self[key][..., 0]).view(np.uint32)
        share: NDArray[np.float32] = np.where(ids == int(manifest[name], 16), self[key][..., 1], 0).sum(-1, dtype=np.float32)
        return share


def channels_of(picture: Mapping[str, NDArray[Any]]) -> Tuple[NDArray[np.float32], List[str]]:
    """All that a file of a picture holds, (height, width, channels), with the channels' names."""
    known: Optional[Dict[str, List[str]]] = getattr(picture, "channels", None)
    if known is None:
        known = {"rgb": ["R", "G", "B"], "coverage": ["A"], **_aov_channels}
    parts: List[NDArray[Any]] = [picture["rgb"]]
    names = ["R", "G", "B"]
    for key, values in picture.items():
        channels = known.get(key, [])
        if channels and key != "rgb":
            parts.append(values.reshape(*values.shape[:2], len(channels)))
            names += channels
    return np.concatenate(parts, 2, dtype=np.float32), names
