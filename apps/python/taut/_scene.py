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

Picture = Dict[str, NDArray[Any]]
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
    ) -> None:
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
            tree, os.path.join(text("folder", folder), ""), given, texts("overrides", overrides), str(model), tolerance
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
        progress: Optional[Callable[[float], Any]] = None,
    ) -> Picture:
        """A frame as arrays, row 0 the top: "rgb" (height, width, 3) linear and "coverage" (height, width), the share of its
        samples that hit something, float32; "samples" (height, width); and one array for each of `aovs`, named as those of the
        command ("depth", "normal", "m", ..., or "all"): (height, width) or (height, width, channels), in world space where it is a
        place or a direction.

        frame     the scene's first by default; may be fractional.
        seconds   stop after the pass in which this much time is over; noise: adaptive sampling to this relative noise, spp the upper bound.
        crop      pixels (x0, y0, x1, y1), x1 and y1 excluded.
        progress  called with the share done in [0, 1], by this thread; False stops. What it throws comes out as itself.

        Ctrl-C, `stop` or a false progress end it within a tile; Ctrl-C raises KeyboardInterrupt, the others return what there is.
        The same arguments give the same bits, whatever the threads.
        """
        with self._rendering:
            refinement = self.refine(frame, spp, aovs, noise=noise, crop=crop, seed=seed)
            refinement.advance(0, seconds, progress)
            return refinement.picture()

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
    ) -> "Refinement":
        """A frame that gets better while one looks: iterate over pictures about `every` so many seconds, until all samples are there.

            for picture in scene.refine(1, spp=1024):
                show(picture["rgb"])

        Its last picture has the bits of `render`.
        """
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
        return Refinement(_taut.Refinement(self._core, at, samples, 0, noise, window, texts("aovs", aovs), seed_of(seed)), every)

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


class Refinement:
    """One frame, rendered in steps. Made by Scene.refine, of which only the latest may go on."""

    def __init__(self, core: Any, every: float) -> None:
        self._core: _taut.Refinement = core
        self._every = every
        self._stopped = False

    def advance(self, samples: int = 0, seconds: Optional[float] = None, progress: Optional[Callable[[float], Any]] = None) -> str:
        """Renders on: by `samples` more for every pixel, or about `seconds`; to the end where neither is given.

        Returns "going", "stopped" or "done". `progress` as in Scene.render. Ctrl-C raises KeyboardInterrupt within a tile; what the
        picture has is whole, and advance goes on from there.
        """
        if progress is not None and not callable(progress):
            fail("progress", describe(progress), "a function of the share done")
        most = 0.0 if seconds is None else number("seconds", seconds, 0, 1e12, "a time above 0")
        return self._core.advance(whole("samples", samples, 0, 1 << 24), most, progress)

    def picture(self) -> Picture:
        """The frame as it stands, as Scene.render returns it; from any thread, while another advances too."""
        pixels, samples = self._core.film()
        picture: Picture = {"rgb": pixels[..., :3], "coverage": pixels[..., 3], "samples": samples}
        at, channels = 4, self._core.channels
        while at < len(channels):
            name, count = _aovs[channels[at]]
            picture[name] = pixels[..., at] if count == 1 else pixels[..., at : at + count]
            at += count
        return picture

    def __iter__(self) -> Iterator[Picture]:
        while not self.done and not self._stopped:
            if self.advance(seconds=self._every) == "stopped":
                self._stopped = True
            yield self.picture()

    def stop(self) -> None:
        """Ends what goes on in another thread, within a tile; iteration ends after one more picture."""
        self._stopped = True
        self._core.stop()

    @property
    def done(self) -> bool:
        """Whether all samples are there."""
        return self._core.done

    @property
    def share(self) -> float:
        """Share of the samples that are done, [0, 1]."""
        return self._core.share

    def save(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """A checkpoint: all that `restore` needs to go on, in another process too."""
        self._core.save(text("path", path))

    def restore(self, path: Union[str, "os.PathLike[str]"]) -> "Refinement":
        """Goes on from a checkpoint of the same frame and options (spp may be higher). Raises InputError saying what differs or is
        damaged, and leaves things as they were."""
        self._core.restore(text("path", path))
        return self

    def __repr__(self) -> str:
        return f"<taut.Refinement, {100 * self.share:.0f} % done>"


_aovs: Dict[str, Tuple[str, int]] = {channels[0]: (name, len(channels)) for name, channels in _taut.aovs}
"""Name and number of channels, by the first channel's name in a film."""
