"""The transformed GGX microsurface over arrays, any M per row.

Every microsurface is the standard one, GGX with alpha 1, under

        | a  b  p |
    M = | 0  d  q |     micro-geometry -> M geometry,  micro-normals -> M^-T normals
        | 0  0  1 |

in local shading space: orthonormal, z the macro-normal, `wo` to the viewer, `wi` to the light, `wm` a micro-normal, unit vectors.

Shapes. M is (..., 5), [a b d p q], or (..., 3), [a b d] without lean; a, d > 0. Directions are (..., 3), uniform numbers u (..., 2) in
[0, 1). Leading axes broadcast as in numpy. Results are float32 where the arrays are float32 (and evaluate, weight, sample then run in
vectorised loops), else float64. Arrays are read in place where no axis has to be expanded. The interpreter's lock is released.

Errors: taut.InputError names the argument, or the row of M that is none.

Sources: Microsurface Transformations, CGF 41(4), 2022; Smith masking in the forms of docs/pipeline.md, "BSDF".

    >>> import taut.microsurface as ms
    >>> plate = [10, 20, 10]                               # alpha 0.1, sheared by 2
    >>> float(ms.D(plate, [0, 0, 1]))
    31.83098861837907
    >>> alpha_max, alpha_min, phi = ms.equivalent_alpha(plate)
    >>> f"{alpha_max:.4f} {alpha_min:.4f} {phi:.4f}"
    '0.2414 0.0414 -1.1781'
"""

from __future__ import annotations

from typing import Any, Dict, NamedTuple, Optional, Tuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _taut
from ._arrays import Broadcast, common_type
from ._checks import describe, fail, number, seed as _seed_of

_core: Any = _taut.microsurface  # calls spread their rows

__all__ = [
    "D", "G1", "G2", "Lambda", "albedo", "average_albedo", "canonical", "carried_slope", "conventions", "deform", "equivalent_alpha",
    "equivalent_strain", "evaluate", "evaluate_walk", "from_alpha", "from_convention", "general_D", "general_transform",
    "mapped_transform", "normal_stretch", "pdf", "roughen", "sample", "sample_normal", "slope_tensor", "surface_deformation",
    "to_convention", "visible_normal_pdf", "walk", "weight",
]  # fmt: skip

_M = (3, 5)
_W = (3,)
_U = (2,)
_ONE = (0,)


def _call(function: Any, options: Tuple[Any, ...] = (), **arguments: Any) -> Any:
    """One number a row."""
    rows = Broadcast(common_type(*(values for values, _ in arguments.values())), **arguments)
    return rows.number(function(*rows.rows, *options))


def D(M: ArrayLike, wm: ArrayLike) -> Any:
    """Distribution of micro-normals at wm/|wm|, per steradian: det |wm|^4 / (pi |M^T wm|^4), 0 where it faces down in standard space.

    wm may have any length: the half vector wo + wi as it is keeps the most digits. Normalised: the integral of D wm.z is 1.
    """
    return _call(_core.D, M=(M, _M), wm=(wm, _W))


def G1(M: ArrayLike, w: ArrayLike) -> Any:
    """Smith masking 2 |w.z| / (w.z + L(w)), L(w) = |M^-1 w|; for w below the horizon the normalisation of Tokuyoshi 2021."""
    return _call(_core.G1, M=(M, _M), w=(w, _W))


def Lambda(M: ArrayLike, w: ArrayLike) -> Any:
    """Smith's Lambda(w) = (L(w) / |w.z| - 1) / 2."""
    return _call(_core.Lambda, M=(M, _M), w=(w, _W))


def G2(M: ArrayLike, wo: ArrayLike, wi: ArrayLike, correlated: bool = True) -> Any:
    """Masking and shadowing together: height-correlated (one side: 1 / (1 + Lambda_o + Lambda_i); across: a Beta function, Heitz et al.
    2016), or the product of both G1."""
    return _call(_core.G2, (correlated,), M=(M, _M), wo=(wo, _W), wi=(wi, _W))


def evaluate(M: ArrayLike, wo: ArrayLike, wi: ArrayLike, correlated: bool = True) -> Any:
    """The reflecting BRDF times |wi.z|, without Fresnel (F = 1), per steradian; 0 where wi is below the horizon.

    The cosine is never split off: the product stays finite at grazing.
    """
    return _call(_core.evaluate, (correlated,), M=(M, _M), wo=(wo, _W), wi=(wi, _W))


def pdf(M: ArrayLike, wo: ArrayLike, wi: ArrayLike, bounded: bool = True) -> Any:
    """Density of `sample`, per steradian of wi: D / (2 (k wo.z + L(wo))), k the bound of Eto & Tokuyoshi 2023; bounded=False: k = 1."""
    return _call(_core.pdf, (bounded,), M=(M, _M), wo=(wo, _W), wi=(wi, _W))


def weight(M: ArrayLike, wo: ArrayLike, wi: ArrayLike, correlated: bool = True, bounded: bool = True) -> Any:
    """evaluate / pdf, finite where both vanish; 0 where wi is below the horizon. bounded=False: G2 / G1(wo)."""
    return _call(_core.weight, (correlated, bounded), M=(M, _M), wo=(wo, _W), wi=(wi, _W))


def sample(M: ArrayLike, wo: ArrayLike, u: ArrayLike, bounded: bool = True) -> Tuple[NDArray[Any], Any]:
    """Reflected directions wi (..., 3) and their density (...,), which is 0 where wi is below the horizon and the sample rejected.

    By visible normals on spherical caps (Dupuy & Benyoub 2023), bounded to what reflects upwards (Eto & Tokuyoshi 2023) unless
    bounded=False.
    """
    rows = Broadcast(common_type(M, wo, u), M=(M, _M), wo=(wo, _W), u=(u, _U))
    wi, density = _core.sample(*rows.rows, bounded)
    return rows.vector(wi), rows.number(density)


def sample_normal(M: ArrayLike, wo: ArrayLike, u: ArrayLike) -> NDArray[Any]:
    """Visible micro-normals (..., 3), unit, of density `visible_normal_pdf`."""
    rows = Broadcast(common_type(M, wo, u), M=(M, _M), wo=(wo, _W), u=(u, _U))
    return rows.vector(_core.sample_normal(*rows.rows))


def visible_normal_pdf(M: ArrayLike, wo: ArrayLike, wm: ArrayLike) -> Any:
    """Density of visible normals, per steradian: 2 <wo, wm> D(wm) / (wo.z + L(wo))."""
    return _call(_core.visible_normal_pdf, M=(M, _M), wo=(wo, _W), wm=(wm, _W))


def albedo(M: ArrayLike, wo: ArrayLike) -> Any:
    """Light that one reflection sends back up (F = 1, correlated): the integral of `evaluate` over wi, 0 where wo is below the horizon.

    A fit within 0.012 of quadrature, 0.002 typically, for alpha in [0.02, 2] and aspects to 1:20; a lean is ignored. The rest meets
    further facets: see `walk`.
    """
    return _call(_core.albedo, M=(M, _M), wo=(wo, _W))


def average_albedo(M: ArrayLike) -> Any:
    """The cosine-weighted mean of `albedo` over the hemisphere, by a fit."""
    rows = Broadcast(np.float32, M=(M, _M))
    return rows.number(_core.average_albedo(*rows.rows))


class Walk(NamedTuple):
    """Where light leaves the surface, float32."""

    wi: NDArray[np.float32]
    """(..., 3): unit direction; (0, 0, 1) of a walk that was given up."""
    throughput: NDArray[np.float32]
    """(..., 3): weight f cos / pdf, with a density that nobody knows; 0 of a walk that was given up."""
    bounces: NDArray[np.int32]
    """(...,): facets met."""


def walk(M: ArrayLike, wo: ArrayLike, color: ArrayLike = 1.0, seed: int = 0) -> Walk:
    """A random walk of light from facet to facet for each row, until it leaves (Heitz, Hanika, d'Eon & Dachsbacher 2016), for every M.

    color (3,) or (..., 3), or a number: what a facet reflects, linear. With 1 no light is lost: throughput is 1. A row's numbers follow
    from seed and row alone, whatever the threads.
    """
    rows = Broadcast(np.float32, M=(M, _M), wo=(wo, _W), color=(_color(color), _W))
    wi, throughput, bounces = _core.walk(*rows.rows, _seed_of(seed))
    return Walk(rows.vector(wi), rows.vector(throughput), rows.number(bounces))


def evaluate_walk(M: ArrayLike, wo: ArrayLike, wi: ArrayLike, color: ArrayLike = 1.0, seed: int = 0) -> NDArray[np.float32]:
    """f cos of one and more bounces, (..., 3), per steradian: an unbiased estimate by one walk a row with next events at each facet."""
    rows = Broadcast(np.float32, M=(M, _M), wo=(wo, _W), wi=(wi, _W), color=(_color(color), _W))
    return rows.vector(_core.evaluate_walk(*rows.rows, _seed_of(seed)))


def _color(color: ArrayLike) -> ArrayLike:
    return np.full(3, color, np.float32) if np.ndim(color) == 0 else color


# --- M: made, deformed, compared -------------------------------------------------------------------------------------


def from_alpha(alpha_x: ArrayLike, alpha_y: Optional[ArrayLike] = None, rotation: ArrayLike = 0.0) -> NDArray[Any]:
    """M (..., 5) of a GGX surface: alpha along x and across (None: the same), turned by `rotation` radians, counter-clockwise."""
    dtype = common_type(alpha_x, alpha_x if alpha_y is None else alpha_y, rotation)
    x, y = np.broadcast_arrays(np.asarray(alpha_x, dtype), np.asarray(alpha_x if alpha_y is None else alpha_y, dtype))
    rows = Broadcast(dtype, alpha=(np.stack([x, y], -1), _U), rotation=(rotation, _ONE))
    return rows.vector(_core.from_alpha(*rows.rows))


def canonical(block: ArrayLike, lean: ArrayLike = (0.0, 0.0)) -> NDArray[Any]:
    """M (..., 5) of any 2 x 2 block (..., 2, 2), by rows, and a lean (..., 2): the canonical M with the same M M^T.

    Singular values are held in [1e-5, 1e5]: a collapsed surface becomes very rough, never not-a-number.
    """
    block = _matrix("block", block, 2)
    rows = Broadcast(common_type(block, lean), block=(block, (4,)), lean=(lean, _U))
    return rows.vector(_core.canonical(*rows.rows))


def deform(A: ArrayLike, M: ArrayLike, normal_stretch: ArrayLike = 1.0, lean: ArrayLike = (0.0, 0.0)) -> NDArray[Any]:
    """M (..., 5) of a surface M after a deformation: [A/lambda, lean/lambda; 0, 1] M.

    A (..., 2, 2), by rows, is the surface gradient between orthonormal tangent frames, rest to deformed; `normal_stretch` lambda,
    the stretch along the normal; `lean` (..., 2) how far points are carried sideways per unit of height, before division by lambda.
    """
    A = _matrix("A", A, 2)
    rows = Broadcast(
        common_type(A, M, normal_stretch, lean), A=(A, (4,)), M=(M, _M), normal_stretch=(normal_stretch, _ONE), lean=(lean, _U)
    )
    return rows.vector(_core.deform(*rows.rows))


def _matrix(name: str, values: ArrayLike, size: int) -> NDArray[Any]:
    try:
        array = np.asarray(values)
    except ValueError:  # rows of different lengths
        fail(name, describe(values), f"(..., {size}, {size})")
    if array.shape[-2:] != (size, size):
        fail(name, f"an array of shape {array.shape}", f"(..., {size}, {size})")
    return array.reshape(*array.shape[:-2], size * size)


def normal_stretch(area: ArrayLike, poisson: float) -> Any:
    """lambda = area^(-nu / (1 - nu)) of a material with Poisson's ratio nu in [-1, 0.5] whose surface grows by the factor `area`."""
    rows = Broadcast(np.float32, area=(area, _ONE))
    return rows.number(_core.normal_stretch(*rows.rows, number("poisson", poisson, -1, 0.5, "a number in [-1, 0.5]")))


def equivalent_alpha(M: ArrayLike) -> Tuple[Any, Any, Any]:
    """alpha_max, alpha_min, phi of the GGX that looks the same: phi to the rougher axis, radians in (-pi/2, pi/2]. Ignores a lean."""
    rows = Broadcast(common_type(M), M=(M, _M))
    values = _core.equivalent_alpha(*rows.rows)
    return _three(rows, values)


def _three(rows: Broadcast, values: NDArray[Any]) -> Tuple[Any, Any, Any]:
    largest, smallest, phi = (rows.number(np.ascontiguousarray(values[:, i])) for i in range(3))
    return largest, smallest, phi


def slope_tensor(M: ArrayLike) -> NDArray[Any]:
    """Sigma = (M M^T)^-1 as (..., 3): xx, xy, yy. Its eigenvalues are the squares of alpha; what may be averaged."""
    rows = Broadcast(common_type(M), M=(M, _M))
    return rows.vector(_core.slope_tensor(*rows.rows))


def general_transform(T: ArrayLike) -> Tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Any invertible T (..., 3, 3), by rows, on the standard microsurface: its M (..., 5) and the frame (..., 3, 3) that this M lives in.

    Rows of the frame are its axes s, t, n' in the space that T maps to; n' = T^-T z / |T^-T z| is the new macro-normal.
    Raises InputError naming the row of a matrix without an inverse.
    """
    T = _matrix("T", T, 3)
    rows = Broadcast(np.float64, T=(T, (9,)))
    M, frame = _core.general_transform(*rows.rows)
    return rows.vector(M), frame.reshape(*rows.shape, 3, 3)


def general_D(T: ArrayLike, normal: ArrayLike) -> Any:
    """D at unit normals (..., 3) in T's own space: |det T| / (pi |T^-T z| |T^T m|^4), 0 where (T^T m).z <= 0."""
    rows = Broadcast(np.float64, T=(_matrix("T", T, 3), (9,)), normal=(normal, _W))
    return rows.number(_core.general_D(*rows.rows))


# --- metal that roughens ---------------------------------------------------------------------------------------------


def equivalent_strain(stretch: ArrayLike) -> Any:
    """eps of a surface with the stretches (..., 2), larger and smaller, as `taut.gloss` returns them; (...,), float64, no unit.

    The equivalent Hencky strain with the thickness from volume: e1, e2 the logarithms of both, e3 = -(e1 + e2),
    eps = sqrt(2/3 (e1^2 + e2^2 + e3^2)). A stretch below 1e-5 counts as 1e-5.
    """
    rows = Broadcast(np.float64, stretch=(stretch, _U))
    return rows.number(_core.equivalent_strain(*rows.rows))


def roughen(M: ArrayLike, strain: ArrayLike, roughening: float, yield_strain: float = 0.0) -> NDArray[np.float32]:
    """M (..., 5) of metal that was strained: Sigma' = Sigma + (roughening max(0, strain - yield_strain))^2 I; its lean is kept.

    `roughening` is alpha per unit of strain, at least 0; `strain` (...,) as of `equivalent_strain`, of which what lies beyond
    `yield_strain` counts. In slope tensors the sum is exact for Gaussian slopes and a model for GGX. Source: Stoudt & Ricker 2002,
    Metall. Mater. Trans. A 33, 2883.
    """
    rate = number("roughening", roughening, 0, expected="a number, at least 0")
    limit = number("yield_strain", yield_strain, 0, expected="a number, at least 0")
    rows = Broadcast(np.float64, M=(M, _M), strain=(strain, _ONE))
    return rows.vector(_core.roughen(rows.rows[0].astype(np.float32), rows.rows[1], rate, limit))


# --- facets of a normal or height map --------------------------------------------------------------------------------


def surface_deformation(A: ArrayLike, normal_stretch: ArrayLike = 1.0, lean: ArrayLike = (0.0, 0.0)) -> NDArray[np.float64]:
    """F = [A lean; 0 normal_stretch], (..., 3, 3) by rows: a deformation of the space at a surface, arguments as of `deform`."""
    A = _matrix("A", A, 2)
    rows = Broadcast(np.float64, A=(A, (4,)), normal_stretch=(normal_stretch, _ONE), lean=(lean, _U))
    F = np.zeros((int(np.prod(rows.shape)), 3, 3))
    F[:, :2, :2], F[:, 2, 2], F[:, :2, 2] = rows.rows[0].reshape(-1, 2, 2), rows.rows[1], rows.rows[2]
    return F.reshape(*rows.shape, 3, 3)


def carried_slope(F: ArrayLike, slope: ArrayLike) -> NDArray[np.float64]:
    """Where the deformation F (..., 3, 3) takes a slope s = -grad h (..., 2) of the surface: lambda A^-T s / (1 - lean . A^-T s).

    In the rest and the deformed tangent frame, lengths over lengths. Not finite where the facet is turned to stand upright.
    """
    rows = Broadcast(np.float64, F=(_matrix("F", F, 3), (9,)), slope=(slope, _U))
    return rows.vector(_core.carried_slope(*rows.rows))


def mapped_transform(
    F: ArrayLike, slope: ArrayLike, M: ArrayLike, covariance: ArrayLike = (0.0, 0.0, 0.0)
) -> Tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A facet of a normal or height map under a deformation: its leaning M (..., 5), and the frame (..., 3, 3) that this M lives in.

    F           (..., 3, 3): the deformation of the mesh, `surface_deformation`.
    slope       (..., 2): s = -grad h of the map in the rest tangent frame; the facet's normal there is (s, 1) / |(s, 1)|.
    M           (..., 3) or (..., 5): the rest material in the facet's own frame, x the tangent projected on it; its lean has no say.
    covariance  (..., 3), xx, xy, yy: of the slopes around the mean `slope`, where a footprint sees many facets.

    T = F R(slope) M brought to canonical form as by `general_transform`, whose frame and errors it has. Turning the normal alone and
    keeping A is wrong by that lean. Sources: docs/pipeline.md, "Mesostructure"; Olano & Baker 2010 and Dupuy et al. 2013 for
    footprints (the slope tensor of M grows by 2 C, GGX's best fit).
    """
    rows = Broadcast(np.float64, F=(_matrix("F", F, 3), (9,)), slope=(slope, _U), M=(M, _M), covariance=(covariance, _W))
    found, frame = _core.mapped_transform(*rows.rows)
    return rows.vector(found), frame.reshape(*rows.shape, 3, 3)


# --- other renderers -------------------------------------------------------------------------------------------------

conventions: Dict[str, Tuple[str, ...]] = {name: tuple(filter(None, parts)) for name, *parts in _core.conventions}
"""Names of other renderers' parameters, by convention: {"blender": ("roughness", "anisotropic", "rotation"), ...}. What each means and
its limits are in docs/export.md; one without a rotation takes the tangent along the rougher axis."""


def to_convention(convention: str, alpha_max: ArrayLike, alpha_min: ArrayLike, phi: ArrayLike = 0.0) -> Dict[str, Any]:
    """Parameters of another renderer, by their names, and "clipped": where the gloss lay outside its limits and was held at them."""
    rows = Broadcast(np.float32, alpha_max=(alpha_max, _ONE), alpha_min=(alpha_min, _ONE), phi=(phi, _ONE))
    columns = [np.broadcast_to(row, max(r.size for r in rows.rows)) for row in rows.rows]
    values, clipped = _core.to_convention(convention, np.ascontiguousarray(np.stack(columns, -1)))
    result = {name: rows.number(np.ascontiguousarray(values[:, i])) for i, name in enumerate(conventions[convention])}
    result["clipped"] = rows.number(clipped)
    return result


def from_convention(convention: str, **parameters: ArrayLike) -> Tuple[Any, Any, Any]:
    """alpha_max, alpha_min, phi of what another renderer shows for its parameters, which are named as in `conventions`."""
    names = conventions.get(convention, ())
    if names and set(parameters) != set(names):
        fail(f"from_convention({convention!r})", ", ".join(sorted(parameters)) or "no parameters", ", ".join(names))
    rows = Broadcast(np.float32, **{name: (parameters[name], _ONE) for name in names})
    columns = [np.broadcast_to(row, max((r.size for r in rows.rows), default=1)) for row in rows.rows]
    columns += [np.zeros_like(columns[0]) if columns else np.zeros(1, np.float32)] * (3 - len(columns))
    values = _core.from_convention(convention, np.ascontiguousarray(np.stack(columns, -1), dtype=np.float32))
    return _three(rows, values)
