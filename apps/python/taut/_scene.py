"""A scene that Python renders: from a file, from a dict of the scene file's keys, from arrays."""

from __future__ import annotations

import json
import os
import threading
from typing import Any, Callable, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _taut
from ._arrays import table
from ._checks import describe, fail, number, seed as seed_of, text, texts, whole
from ._gloss import _faces, _indices
from ._picture import Picture
from ._refinement import Refinement

Points = Union[None, ArrayLike, Sequence[ArrayLike], Callable[[float], ArrayLike]]
_ARRAY_KEYS = ("positions", "faces", "uv", "normals", "points", "first_frame", "face_materials", "material_names")


def _frames_of(what: str, points: Any, count: Optional[int]) -> List[NDArray[np.float32]]:
    """Arrays of positions, one a frame."""
    if not isinstance(points, (np.ndarray, Sequence)) or isinstance(points, str):
        fail(what, describe(points), "arrays of positions or a function of the frame")
    frames = list(points) if not isinstance(points, np.ndarray) or points.ndim == 3 else [points]
    if not frames:
        fail(what, "no frame", "at least one array of positions")
    return [table(f"{what}[{i}]", frame, 3, np.float32, count) for i, frame in enumerate(frames)]


def _given_mesh(where: str, entry: Mapping[str, Any]) -> Tuple[Any, ...]:
    """What the library takes of a mesh of arrays."""
    if "faces" not in entry:
        fail(where, "'positions' without 'faces'", "both")
    starts, corners = _faces(entry["faces"])
    rest = table(f"{where}.positions", entry["positions"], 3, np.float32, row_name="points")
    points: Any = entry.get("points")
    if callable(points):
        function = points

        def points(frame: float) -> NDArray[np.float32]:
            return table(f"{where}.points({frame:g})", function(frame), 3, np.float32, len(rest))

    elif points is not None:
        points = _frames_of(f"{where}.points", points, len(rest))

    def optional(name: str, columns: int) -> Optional[NDArray[np.float32]]:
        values = entry.get(name)
        return None if values is None else table(f"{where}.{name}", values, columns, np.float32, row_name="points or corners")

    materials = entry.get("face_materials")
    if materials is not None:
        materials = _indices(f"{where}.face_materials", materials)
    names = [str(name) for name in entry.get("material_names", ())]
    first = number(f"{where}.first_frame", entry.get("first_frame", 1))
    return rest, starts, corners, optional("uv", 2), optional("normals", 3), points, first, materials, names


class Scene:
    """A scene, its plan, and what is rendered and exported of it.

    source     the path of a scene .toml, a .glb or .gltf, or a mesh; or a dict of the scene file's keys (docs/scene.md):

                   taut.Scene({"render": {"width": 320, "height": 180},
                               "camera": {"position": [0, -3, 2], "look_at": [0, 0, 0]},
                               "material": {"brushed": {"type": "conductor", "alpha": [0.08, 0.4]}},
                               "mesh": [{"positions": rest, "faces": faces, "uv": uv, "points": points, "material": "brushed"}]})

               A mesh of the dict has a `file`, or arrays instead of one:
                   positions  (n, 3) float32, object space, metres: the rest shape, what deformation is measured against
                   faces      as taut.Gloss takes them
                   uv         (n, 2) or (corners, 2); normals (n, 3) or (corners, 3): optional
                   points     where the points are: an array (frames, n, 3) or a sequence of (n, 3), linear between frames and held
                              outside; or a function of the frame (a float, motion blur asks between frames) that returns (n, 3)
                   first_frame  the frame of the first array, 1 by default
                   face_materials  (faces,) indices into material_names, which `material` gives materials to, as to an OBJ file's
               Every other key of a [[mesh]] goes with arrays too, but for `cache`. Arrays of `points` are read in place where they are
               float32 and C-contiguous, at each render: they may be rewritten in between.
    overrides  as -D of the command: "render.width=320", "mesh.0.follow=false".
    folder     where relative paths of a dict start; the current folder by default.
    model      "auto": the cheapest model within the tolerance over the frames that the scene names (`taut info`); a frame outside them,
               and any of a mesh with `points`, of which nobody knows what they will be, everything per vertex. "full": every saving off.
    ground     whether its pictures stand on a ground, in a neutral studio where nothing else lights them, framed where no camera is said
               (docs/scene.md). None: as the scene says, which a mesh or glTF file alone does, as by the command. Exports, `gloss` and
               `objects` know nothing of it.
    tolerance  relative RMS error that the savings may have together; None: 0.01, and light of several facets only where it shows.

    Raises InputError with the message of the command; of a dict it names the key: `mesh[0].material: found 'brased', ...`.
    What a loader has to say without failing is in `warnings`. A scene may be used by several threads, which wait for each other; not by
    the functions that it calls.
    """

    def __init__(
        self,
        source: Union[str, "os.PathLike[str]", Mapping[str, Any]],
        overrides: Sequence[str] = (),
        folder: Union[str, "os.PathLike[str]"] = ".",
        model: str = "auto",
        tolerance: Optional[float] = None,
        ground: Optional[bool] = None,
    ) -> None:
        said = texts("overrides", overrides)
        if ground is not None:
            said.append(f"render.ground={'true' if ground else 'false'}")
        given: Dict[str, Tuple[Any, ...]] = {}
        tree: Any
        if isinstance(source, Mapping):
            tree = dict(source)
            entries = tree.get("mesh", [])
            if isinstance(entries, Mapping) or not isinstance(entries, Sequence) or isinstance(entries, str):
                fail("mesh", type(entries).__name__, "a list of meshes")
            tree["mesh"] = [self._entry(i, entry, given) for i, entry in enumerate(entries)]
        else:
            tree = text("source", source, "a path or a dict")
        self._rendering = threading.RLock()
        if tolerance is not None:
            tolerance = number("tolerance", tolerance, 1e-6, 1, "a number in [1e-6, 1]")
        self._core = _taut.Scene(
            tree, os.path.join(text("folder", folder), ""), given, said, str(model), tolerance
        )

    @staticmethod
    def _entry(number: int, entry: Any, given: Dict[str, Tuple[Any, ...]]) -> Any:
        if not isinstance(entry, Mapping) or "positions" not in entry:
            return entry
        where = f"mesh[{number}]"
        if "file" in entry:
            fail(where, "'positions' and 'file'", "one of the two")
        given[where] = _given_mesh(where, entry)
        return {"file": where, **{key: value for key, value in entry.items() if key not in _ARRAY_KEYS}}

    # --- what it is ---------------------------------------------------------------------------------------------------

    @property
    def size(self) -> Tuple[int, int]:
        """Width and height of its pictures, pixels."""
        return self._core.size

    @property
    def spp(self) -> int:
        """Samples a pixel, where a render does not say."""
        return self._core.spp

    @property
    def frames(self) -> List[int]:
        """The frames that it names."""
        return self._core.frames

    @property
    def fps(self) -> float:
        """Frames a second: frame f is at (f - 1) / fps seconds."""
        return self._core.fps

    @property
    def objects(self) -> List[str]:
        """Names of its meshes, in order."""
        return self._core.objects

    @property
    def warnings(self) -> List[str]:
        """What was read otherwise than it stands, or left out, a line each."""
        return self._core.warnings

    def __repr__(self) -> str:
        return f"<taut.Scene of {len(self.objects)} objects, {self.size[0]} x {self.size[1]}>"

    # --- what is made of it -------------------------------------------------------------------------------------------

    def render(
        self,
        frame: Optional[float] = None,
        spp: Optional[int] = None,
        aovs: Union[str, Sequence[str]] = (),
        *,
        seconds: Optional[float] = None,
        noise: Optional[float] = None,
        crop: Optional[Tuple[int, int, int, int]] = None,
        seed: Optional[int] = None,
        denoise: bool = False,
        progress: Optional[Callable[[float], Any]] = None,
    ) -> Picture:
        """A frame as arrays, row 0 the top: "rgb" (height, width, 3) linear and "coverage" (height, width), the share of its
        samples that hit something, float32; "samples" (height, width); and one array for each of `aovs`, named as those of the
        command ("depth", "normal", "m", ..., or "all"): (height, width) or (height, width, channels), in world space where it is a
        place or a direction. Of the layers (docs/aovs.md) "crypto_object" and "crypto_material" are (height, width, ranks, 2), an id
        and its share, which Picture.matte finds by name; "lights" gives a "light_NAME" (height, width, 3) for each group, which sum
        to rgb; "variance" is (height, width, 3); "samples" goes into files too.

        frame     the scene's first by default; may be fractional.
        seconds   stop after the pass in which this much time is over; noise: adaptive sampling to this relative noise, spp the upper bound.
        crop      pixels (x0, y0, x1, y1), x1 and y1 excluded.
        denoise   takes the noise out of "rgb" (docs/denoise.md); what was rendered is "noisy" (height, width, 3), and "denoise_error"
                  (height, width) the standard error that is estimated to be left. A picture that was stopped stays as it is.
        progress  called with the share done in [0, 1], by this thread; False stops. What it throws comes out as itself.

        Ctrl-C, `stop` or a false progress end it within a tile; Ctrl-C raises KeyboardInterrupt, the others return what there is.
        The same arguments give the same bits, whatever the threads.
        """
        with self._rendering:
            denoiser = _taut.Denoiser(False) if denoise else None
            return self._render(frame, spp, aovs, seconds, noise, crop, seed, progress, denoiser)

    def _render(
        self,
        frame: Optional[float],
        spp: Optional[int],
        aovs: Union[str, Sequence[str]],
        seconds: Optional[float],
        noise: Optional[float],
        crop: Optional[Tuple[int, int, int, int]],
        seed: Optional[int],
        progress: Optional[Callable[[float], Any]],
        denoiser: Optional[_taut.Denoiser],
    ) -> Picture:
        refinement = self._refine(frame, spp, aovs, 0.5, noise, crop, seed, denoiser, seconds is not None)
        end = refinement.advance(0, seconds, progress)
        return refinement._picture(denoiser is not None and end != "stopped")

    def render_frames(
        self,
        frames: Optional[Sequence[int]] = None,
        spp: Optional[int] = None,
        aovs: Union[str, Sequence[str]] = (),
        *,
        denoise: Union[bool, str] = False,
        seed: Optional[int] = None,
        progress: Optional[Callable[[float], Any]] = None,
    ) -> Iterator[Picture]:
        """Frames one after the other, the scene's by default: an iterator of what `render` returns. With denoise="frames" each is
        denoised with what the one before shows of the same points as well, as by --denoise-frames."""
        if denoise not in (False, True, "frames"):
            fail("denoise", describe(denoise), "True, False or 'frames'")
        if denoise == "frames" and self._core.fixed_seed:
            fail("denoise", "'frames' with a fixed seed", "numbers of their own in all frames, or True, which takes each for itself")
        chosen = self.frames if frames is None else [whole("frames", frame, -(10**9), 10**9) for frame in frames]
        over_frames = _taut.Denoiser(True) if denoise == "frames" else None
        for frame in chosen:
            with self._rendering:
                denoiser = _taut.Denoiser(False) if denoise is True else over_frames
                picture = self._render(frame, spp, aovs, None, None, None, seed, progress, denoiser)
            yield picture

    def refine(
        self,
        frame: Optional[float] = None,
        spp: Optional[int] = None,
        aovs: Union[str, Sequence[str]] = (),
        *,
        every: float = 0.5,
        noise: Optional[float] = None,
        crop: Optional[Tuple[int, int, int, int]] = None,
        seed: Optional[int] = None,
    ) -> Refinement:
        """A frame that gets better while one looks: iterate over pictures about `every` so many seconds, until all samples are there.

            for picture in scene.refine(1, spp=1024):
                show(picture["rgb"])

        Its last picture has the bits of `render`.
        """
        return self._refine(frame, spp, aovs, every, noise, crop, seed, None, False)

    def _refine(
        self,
        frame: Optional[float],
        spp: Optional[int],
        aovs: Union[str, Sequence[str]],
        every: float,
        noise: Optional[float],
        crop: Optional[Tuple[int, int, int, int]],
        seed: Optional[int],
        denoiser: Optional[_taut.Denoiser],
        is_timed: bool,
    ) -> Refinement:
        samples = 0 if spp is None else whole("spp", spp, 1, 1 << 24)
        if noise is not None:
            noise = number("noise", noise, 1e-9, 1 - 1e-9, "a relative noise level above 0 and below 1")
        window = [0, 0, 0, 0]
        if crop is not None:
            edges: Any = crop
            if not isinstance(edges, Sequence) or len(edges) != 4:
                fail("crop", describe(crop), "(x0, y0, x1, y1)")
            window = [whole("crop", edge, 0, 32768) for edge in edges]
            if window == [0, 0, 0, 0]:
                fail("crop", describe(crop), "a part of the picture")
        at = self._frame(frame)
        core = _taut.Refinement(self._core, at, samples, 0, noise, window, texts("aovs", aovs), seed_of(seed), denoiser, is_timed)
        return Refinement(core, every, self._core.image)

    def _frame(self, frame: Optional[float]) -> float:
        return float(self.frames[0]) if frame is None else number("frame", frame, -1e9, 1e9, "a frame in [-1e9, 1e9]")

    def stop(self) -> None:
        """Ends the render that goes on in another thread, within a tile."""
        self._core.stop()

    def set_points(self, object: str, points: Union[ArrayLike, Sequence[ArrayLike]], first_frame: float = 1) -> None:
        """Other positions for a mesh that was made with `points` or moves otherwise; topology is not built again."""
        self._core.set_points(text("object", object), _frames_of("points", points, None), number("first_frame", first_frame))

    def gloss(self, frame: Optional[float] = None, object: str = "") -> Dict[str, NDArray[Any]]:
        """The arrays of `taut export` to .npz for one object at a frame, in world space: P, N, M (n, 5), faces, tangent, alpha_max, ...
        (docs/export.md). `object` may be left out where there is one."""
        return self._core.gloss(self._frame(frame), text("object", object))

    def export(
        self,
        path: Union[str, "os.PathLike[str]", Sequence[Union[str, "os.PathLike[str]"]]],
        frames: Union[None, str, int, Sequence[int]] = None,
        objects: Sequence[str] = (),
        convention: str = "matrix",
        positions: str = "deformed",
        space: str = "world",
        ascii: bool = False,
    ) -> Dict[str, Any]:
        """Files that other tools read, as `taut export` (docs/export.md): .ply .csv .npz .glb .gltf .usda .pc2 .mdd, by the name.

        frames: the scene's by default; "1-24", a number or numbers. Returns the command's report: "files", "bytes", "clipped", ...
        """
        outputs = texts("path", path)
        if not outputs:
            fail("path", "none", "a file name")
        if frames is None or isinstance(frames, str):
            chosen = frames or ""
        else:
            listed = frames if isinstance(frames, Sequence) else [frames]
            chosen = ",".join(str(whole("frames", frame, -(10**9), 10**9)) for frame in listed)
        report = self._core.export(outputs, chosen, texts("objects", objects), str(convention), str(positions), str(space), bool(ascii))
        result: Dict[str, Any] = json.loads(report)
        return result

    def plan(self) -> Dict[str, Any]:
        """What `taut info --json` says: the plan with each question's choices, the ranges of stretch and alpha over the scene's frames,
        what policies did."""
        result: Dict[str, Any] = json.loads(self._core.plan())
        return result
