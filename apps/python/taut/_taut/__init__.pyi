"""The compiled part. Arrays must have the type and layout that is named: nothing is converted here."""

from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from . import microsurface as microsurface

F32 = NDArray[np.float32]
U32 = NDArray[np.uint32]

version: str
presets: Dict[str, Dict[str, Any]]
aovs: List[Tuple[str, List[str]]]

class InputError(ValueError): ...
class RunError(RuntimeError): ...

def limit_threads(threads: int) -> None: ...
def write_image(
    path: str,
    pixels: F32,
    channels: Sequence[str],
    metadata: Sequence[Tuple[str, str]],
    settings: ImageSettings,
    image: Mapping[str, Any],
    folder: str,
) -> None: ...
def relative_error(image: F32, reference: F32, box: int) -> float: ...
def read_image(path: str) -> Tuple[F32, List[str]]: ...

class ImageSettings:
    def __init__(self) -> None: ...

class Denoiser:
    def __init__(self, over_frames: bool) -> None: ...

class PointGloss:
    def __init__(
        self,
        rest: F32,
        starts: U32,
        corners: U32,
        uvs: Optional[F32],
        normals: Optional[F32],
        alphas: F32,
        material: Sequence[float],
        gradient: str,
        per_corner: bool,
    ) -> None: ...
    def at(self, deformed: F32) -> Tuple[F32, F32, F32, F32, F32, F32]: ...
    @property
    def points(self) -> int: ...
    @property
    def rows(self) -> int: ...
    @property
    def vertices(self) -> int: ...
    @property
    def split_points(self) -> int: ...
    @property
    def loose_points(self) -> int: ...

class Scene:
    def __init__(
        self,
        source: Union[str, Dict[str, Any]],
        folder: str,
        given: Dict[str, Tuple[Any, ...]],
        overrides: Sequence[str],
        model: str,
        tolerance: Optional[float],
    ) -> None: ...
    @property
    def warnings(self) -> List[str]: ...
    @property
    def size(self) -> Tuple[int, int]: ...
    @property
    def spp(self) -> int: ...
    @property
    def image(self) -> ImageSettings: ...
    @property
    def fixed_seed(self) -> bool: ...
    @property
    def fps(self) -> float: ...
    @property
    def frames(self) -> List[int]: ...
    @property
    def objects(self) -> List[str]: ...
    def plan(self) -> str: ...
    def export(
        self,
        outputs: Sequence[str],
        frames: str,
        objects: Sequence[str],
        convention: str,
        positions: str,
        space: str,
        ascii: bool,
    ) -> str: ...
    def gloss(self, frame: float, object: str) -> Dict[str, NDArray[Any]]: ...
    def set_points(self, object: str, frames: Sequence[F32], first_frame: float) -> None: ...
    def stop(self) -> None: ...

class Refinement:
    def __init__(
        self,
        scene: Scene,
        frame: float,
        spp: int,
        first_sample: int,
        noise: Optional[float],
        crop: Sequence[int],
        aovs: Sequence[str],
        seed: Optional[int],
        denoiser: Optional[Denoiser],
        is_timed: bool,
    ) -> None: ...
    def advance(self, samples: int, seconds: float, progress: Optional[Callable[[float], Any]]) -> str: ...
    def stop(self) -> None: ...
    @property
    def done(self) -> bool: ...
    @property
    def share(self) -> float: ...
    def film(self) -> Tuple[F32, List[str], U32, List[Tuple[str, str]]]: ...
    def denoised(self) -> Tuple[F32, List[str], U32, List[Tuple[str, str]]]: ...
    def save(self, path: str) -> None: ...
    def restore(self, path: str) -> None: ...
