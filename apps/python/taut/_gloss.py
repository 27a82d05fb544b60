"""Gloss of a mesh that somebody deforms: M and its roughness at every point, from two arrays of positions."""

from __future__ import annotations

from typing import Any, Dict, NamedTuple, Optional, Sequence, Tuple, Union, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _taut
from ._arrays import table, take
from ._checks import describe, fail, number

Faces = Union[ArrayLike, Sequence[Sequence[int]], Tuple[ArrayLike, ArrayLike]]


class VertexGloss(NamedTuple):
    """Gloss at n points (or corners), float32 throughout; rows of points that no face has are nan.

    Lengths are in the units of the positions. Local frame of a row: (tangent, cross(normal, tangent), normal) of the deformed surface,
    orthonormal, right-handed, the normal on the side from which faces run counter-clockwise.
    """

    M: NDArray[np.float32]
    """(n, 5): a, b, d, p, q of M = [a b p; 0 d q; 0 0 1] in the local frame: micro-geometry goes to M geometry, micro-normals to M^-T
    normals. p, q are its lean, 0 here. What `taut.microsurface` takes."""
    alpha_max: NDArray[np.float32]
    """(n,): GGX alpha along the rougher axis; never its square root."""
    alpha_min: NDArray[np.float32]
    """(n,): GGX alpha across it."""
    phi: NDArray[np.float32]
    """(n,): radians in (-pi/2, pi/2], from the tangent towards cross(normal, tangent) to the rougher axis. It jumps by half a turn:
    interpolate M and the tangent, not phi."""
    tangent: NDArray[np.float32]
    """(n, 3): unit, in the space of the positions: where the rest tangent (dP/du, or a smooth field without uv) has gone."""
    stretch: NDArray[np.float32]
    """(n, 2): largest and smallest stretch of the surface, deformed over rest length; their product is the area factor."""


def _faces(faces: Faces) -> Tuple[NDArray[np.uint32], NDArray[np.uint32]]:
    """Starts of the faces in the corners, and the corners."""
    if isinstance(faces, tuple) and len(faces) == 2 and all(np.ndim(part) == 1 for part in faces):
        return _indices("faces[0]", faces[0]), _indices("faces[1]", faces[1])
    if isinstance(faces, Sequence):
        polygons = [np.atleast_1d(np.asarray(face)) for face in faces]
        sizes = [len(polygon) for polygon in polygons]
        if len(set(sizes)) > 1:
            starts = np.concatenate([[0], np.cumsum(sizes[:-1])]).astype(np.uint32)
            return starts, _indices("faces", np.concatenate(polygons))
    corners = _indices("faces", cast(ArrayLike, faces))
    if corners.ndim != 2 or corners.shape[1] < 3:
        fail("faces", f"an array of shape {corners.shape}", "(faces, corners of each), a sequence of faces, or (starts, corners)")
    count, sides = corners.shape
    return np.arange(0, count * sides, sides, dtype=np.uint32), corners.reshape(-1)


def _indices(what: str, values: ArrayLike) -> NDArray[np.uint32]:
    if isinstance(values, np.ndarray) and values.dtype == np.int32:  # the same bits; what is negative is beyond every count
        return take(what, values.view(np.uint32) if values.flags.c_contiguous else values, np.uint32)
    given = np.asarray(values)
    if given.size and given.dtype.kind in "iu" and (given.min() < 0 or given.max() > 0xFFFFFFFF):
        fail(what, f"the index {int(given.min() if given.min() < 0 else given.max())}", "indices of points")
    return take(what, values, np.uint32)


def _alpha(alpha: ArrayLike, points: int) -> NDArray[np.float32]:
    """[1, 2] for all points, or [points, 2]."""
    expected = f"a number, or two: along and across the tangent; or ({points}, 2), two for each point"
    given = np.atleast_1d(np.asarray(alpha))
    if given.dtype.kind not in "fiu":
        fail("alpha", describe(alpha), expected)
    if given.shape in ((1,), (2,)):
        given = np.array([[given[0], given[-1]]], np.float32)
    elif given.shape != (points, 2):
        fail("alpha", f"an array of shape {given.shape}", expected)
    return take("alpha", given, np.float32)


class Gloss:
    """A mesh whose topology and rest shape are kept, for frame after frame of its positions.

    rest       (n, 3) float32: the undeformed positions, in any unit. Deformation is measured against them.
    faces      (f, k) whole numbers: f polygons of k corners, counter-clockwise from outside; or a sequence of faces of any sizes; or
               (starts, corners), two arrays, as Blender and USD have them.
    uv         (n, 2) a point or (corners, 2) a corner: the tangent is dP/du. None: a smooth field of tangents.
    alpha      GGX alpha at rest in [1e-4, 10]: one number, or (along, across) the tangent, or (n, 2), these two for each point. Never
               roughness, its square root.
    rotation   radians that turn the rest material about the normal, counter-clockwise from the tangent.
    poisson    Poisson's ratio in [-1, 0.5]: 0 keeps the thickness, 0.5 the volume, -1 scales it with the surface.
    normals    (n, 3) or (corners, 3) rest normals. None: smooth ones.
    per        "point": one row a point, from the first corner there where a seam or a hard edge has several (`split_points` counts
               them); "corner": one row a corner, in the order of the faces.
    gradient   how the surface gradient is had: "auto", "area", "angle", "least-squares" (docs/pipeline.md, "Estimators").
    roughening alpha that metal gains per unit of equivalent strain beyond `yield_strain`; 0: gloss follows geometry alone.
    yield_strain  the strain from which it does (`yield` of a scene file, which is a keyword of Python); about 0.002 to 0.01.
               With both, Sigma' = lambda^2 A^-T Sigma A^-1 + (roughening max(0, eps - yield_strain))^2 I; eps as
               taut.microsurface.equivalent_strain of `stretch`. Metals want it, rubber and skin do not: see taut.presets.

    Raises InputError for anything malformed, with the message of the command. Source: Microsurface Transformations, CGF 41(4), 2022;
    M = (A / lambda) M0 (docs/pipeline.md).

        gloss = taut.Gloss(rest, faces, uv, alpha=(0.1, 0.3))
        for positions in frames:
            M, alpha_max, alpha_min, phi, tangent, stretch = gloss.at(positions)
    """

    def __init__(
        self,
        rest: ArrayLike,
        faces: Faces,
        uv: Optional[ArrayLike] = None,
        alpha: ArrayLike = (0.1, 0.3),
        rotation: float = 0.0,
        poisson: float = 0.0,
        normals: Optional[ArrayLike] = None,
        per: str = "point",
        gradient: str = "auto",
        roughening: float = 0.0,
        yield_strain: float = 0.0,
    ) -> None:
        if per not in ("point", "corner"):
            fail("per", repr(per), "'point' or 'corner'")
        starts, corners = _faces(faces)
        points = table("rest", rest, 3, np.float32, row_name="points")
        self._core = _taut.PointGloss(
            points,
            starts,
            corners,
            None if uv is None else table("uv", uv, 2, np.float32, row_name="points or corners"),
            None if normals is None else table("normals", normals, 3, np.float32, row_name="points or corners"),
            _alpha(alpha, len(points)),
            [
                number("rotation", rotation),
                number("poisson", poisson),
                number("roughening", roughening, 0, expected="a number, at least 0"),
                number("yield_strain", yield_strain, 0, expected="a number, at least 0"),
            ],
            str(gradient),
            per == "corner",
        )

    def at(self, deformed: ArrayLike) -> VertexGloss:
        """Gloss where the points are at `deformed`, (n, 3).

        float32 and C-contiguous it is read in place (else it is copied, which `taut.copies` counts). The interpreter's lock is released
        meanwhile: other threads of Python run, and frames of several Gloss may be computed at once.
        """
        return VertexGloss(*self._core.at(table("deformed", deformed, 3, np.float32, self._core.points)))

    @property
    def points(self) -> int:
        """How many points the mesh has."""
        return self._core.points

    @property
    def split_points(self) -> int:
        """Points with more than one tangent frame (seams of uv, hard edges), of which per="point" shows the first."""
        return self._core.split_points

    @property
    def loose_points(self) -> int:
        """Points that no face has; their rows are nan."""
        return self._core.loose_points

    def __repr__(self) -> str:
        return f"<taut.Gloss of {self.points} points, {self._core.rows} rows>"


def gloss(
    rest: ArrayLike,
    deformed: ArrayLike,
    faces: Faces,
    uv: Optional[ArrayLike] = None,
    alpha: ArrayLike = (0.1, 0.3),
    rotation: float = 0.0,
    poisson: float = 0.0,
    normals: Optional[ArrayLike] = None,
    **options: Any,
) -> VertexGloss:
    """M, alpha_max, alpha_min, phi, tangent, stretch of a mesh whose points have gone from `rest` to `deformed`.

    One frame of a Gloss: its arguments are those of that class (`per`, `gradient`, `roughening` and `yield_strain` by name), shapes and
    units of what comes back those of VertexGloss. For more than one frame keep a Gloss, which builds topology once.

    >>> import numpy as np, taut
    >>> x, y = np.meshgrid(np.linspace(0, 1, 3, dtype="f4"), np.linspace(0, 1, 3, dtype="f4"))
    >>> rest = np.stack([x, y, 0 * x], -1).reshape(-1, 3)
    >>> faces = [[i, i + 1, i + 4, i + 3] for i in (0, 1, 3, 4)]
    >>> stretched = taut.gloss(rest, rest * np.float32([2, 1, 1]), faces, uv=rest[:, :2].copy())
    >>> print(stretched.alpha_max[0], stretched.alpha_min[0], stretched.stretch[0])  # 0.1 along u is halved, 0.3 across is kept
    0.3 0.05 [2. 1.]
    """
    return Gloss(rest, faces, uv, alpha, rotation, poisson, normals, **options).at(deformed)


presets: Dict[str, Dict[str, Any]] = _taut.presets
"""Materials whose response to a deformation is known, by the names of a scene file's `preset`: rubber, skin, foil, annealed aluminium.

Each is what taut.Gloss takes: alpha, poisson, roughening, yield_strain. Sources, and what of them is measured, geometry or a choice, are
in docs/scene.md, "Presets, and what metal does".

    taut.gloss(rest, deformed, faces, uv, **taut.presets["foil"])
"""
