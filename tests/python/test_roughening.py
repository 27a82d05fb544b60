"""Metal that roughens, materials of points, presets, and facets of a map: against closed forms in numpy, the library and the command."""

import numpy as np
import pytest
import taut
import taut.microsurface as ms

from conftest import grid

ROUGHENING, YIELD = 0.375, 0.0625  # floats as they stand
DEFORMATIONS = {
    "uniaxial stretch": [[1.6, 0], [0, 1]],
    "uniaxial compression": [[1, 0], [0, 0.5]],
    "equibiaxial": [[1.4, 0], [0, 1.4]],
    "shear": [[1, 0.8], [0, 1]],
    "within the yield": [[1.02, 0], [0, 1]],
}


def deformed_sheet(A):
    rest, faces, uv = grid(5, 4)
    deformed = rest.copy()
    deformed[:, :2] = rest[:, :2].astype(float) @ np.asarray(A, float).T
    return rest, deformed, faces, uv


def strain_of(A):
    """eps of DESIGN: Hencky strains of the surface, the third from volume."""
    e1, e2 = np.log(np.linalg.svd(np.asarray(A, float), compute_uv=False))
    e3 = -(e1 + e2)
    return np.sqrt(2 / 3 * (e1**2 + e2**2 + e3**2))


def closed_form(A, alpha, poisson):
    """Sigma' = lambda^2 A^-T Sigma A^-1 + (roughening max(0, eps - yield))^2 I, as alpha max, alpha min and phi."""
    A = np.asarray(A, float)
    inverse, area = np.linalg.inv(A), abs(np.linalg.det(A))
    thickness = area ** (-poisson / (1 - poisson))
    sigma = thickness**2 * inverse.T @ np.diag(np.square(alpha)) @ inverse
    sigma += (ROUGHENING * max(0, strain_of(A) - YIELD)) ** 2 * np.eye(2)
    values, vectors = np.linalg.eigh(sigma)
    along = A @ [1, 0] / np.linalg.norm(A @ [1, 0])  # the tangent: phi is from there
    rougher = vectors[:, 1]
    phi = np.arctan2(along[0] * rougher[1] - along[1] * rougher[0], along @ rougher)
    return np.sqrt(values[1]), np.sqrt(values[0]), phi


@pytest.mark.parametrize("poisson", [0.0, 0.5, -0.3])
@pytest.mark.parametrize("name", DEFORMATIONS)
def test_the_closed_form(name, poisson):
    A = DEFORMATIONS[name]
    found = taut.gloss(*deformed_sheet(A), alpha=(0.08, 0.2), poisson=poisson, roughening=ROUGHENING, yield_strain=YIELD)
    largest, smallest, phi = closed_form(A, (0.08, 0.2), poisson)
    np.testing.assert_allclose(found.alpha_max, largest, rtol=5e-6)
    np.testing.assert_allclose(found.alpha_min, smallest, rtol=5e-6)
    # The angle between two directions, whose senses say nothing.
    if largest > 1.001 * smallest:
        np.testing.assert_allclose(np.sin(found.phi - phi), 0, atol=2e-5)
    plain = taut.gloss(*deformed_sheet(A), alpha=(0.08, 0.2), poisson=poisson)
    same = np.array_equal(found.M, plain.M)
    assert same == (name == "within the yield")


def test_what_is_added_is_what_the_functions_say():
    rest, deformed, faces, uv = deformed_sheet(DEFORMATIONS["shear"])
    deformed[:, 2] = 0.3 * np.sin(4 * rest[:, 0])
    plain = taut.gloss(rest, deformed, faces, uv, alpha=(0.08, 0.2))
    found = taut.gloss(rest, deformed, faces, uv, alpha=(0.08, 0.2), roughening=ROUGHENING, yield_strain=YIELD)
    strain = ms.equivalent_strain(plain.stretch)
    np.testing.assert_allclose(strain[0], strain_of(np.diag(plain.stretch[0])), rtol=1e-6)
    np.testing.assert_array_equal(ms.roughen(plain.M, strain, ROUGHENING, YIELD), found.M)
    sums = ms.slope_tensor(plain.M) + (ROUGHENING * np.maximum(0, strain - YIELD))[:, None] ** 2 * [1, 0, 1]
    np.testing.assert_allclose(ms.slope_tensor(found.M), sums, rtol=2e-5, atol=1e-7)


# --- the library and the command --------------------------------------------------------------------------------------


def scene_of(material, rest, deformed, faces, uv):
    mesh = {"positions": rest, "faces": faces, "uv": uv, "points": [deformed], "material": "m", "name": "sheet"}
    return taut.Scene({"material": {"m": material}, "mesh": [mesh]})


def rows_by_rest_position(arrays, rest):
    """Indices of the vertices of an export at each rest position."""
    at = {bytes(key): row for row, key in enumerate(arrays["Pref"])}
    return [at[bytes(key)] for key in rest]


def assert_same_bits(found, arrays, rest):
    order = rows_by_rest_position(arrays, rest)
    for name, mine in (("M", found.M), ("tangent", found.tangent), ("alpha_max", found.alpha_max), ("alpha_min", found.alpha_min),
                       ("phi", found.phi), ("stretch_max", found.stretch[:, 0]), ("stretch_min", found.stretch[:, 1])):  # fmt: skip
        np.testing.assert_array_equal(np.asarray(arrays[name])[order], mine, err_msg=name)


def test_has_the_bits_of_the_library_and_of_the_command(tmp_path):
    rest, deformed, faces, uv = deformed_sheet(DEFORMATIONS["shear"])
    deformed[:, 2] = 0.3 * np.sin(4 * rest[:, 0])
    material = {"type": "conductor", "alpha": [0.08, 0.2], "rotation_deg": 20, "poisson": 0.3, "roughening": ROUGHENING, "yield": YIELD}
    scene = scene_of(material, rest, deformed, faces, uv)
    found = taut.gloss(rest, deformed, faces, uv, (0.08, 0.2), np.radians(20), 0.3, roughening=ROUGHENING, yield_strain=YIELD)
    assert_same_bits(found, scene.gloss(1), rest)
    scene.export(str(tmp_path / "gloss.npz"))
    assert_same_bits(found, np.load(tmp_path / "gloss.npz"), rest)


@pytest.mark.parametrize("name", taut.presets)
def test_a_preset_is_the_scene_files(name):
    sheet = deformed_sheet(DEFORMATIONS["equibiaxial"])
    assert set(taut.presets[name]) == {"alpha", "poisson", "roughening", "yield_strain"}
    found = taut.gloss(*sheet, **taut.presets[name])
    assert_same_bits(found, scene_of({"preset": name}, *sheet).gloss(1), sheet[0])
    metal = name in ("foil", "annealed aluminium")
    assert (found.alpha_max[0] > taut.presets[name]["alpha"][1]) == metal  # stretched: metal duller, the others shinier


def test_the_presets_are_those_of_scene_files():
    assert list(taut.presets) == ["rubber", "skin", "foil", "annealed aluminium"]
    with pytest.raises(taut.InputError, match="rubber, skin, foil, annealed aluminium"):
        scene_of({"preset": "lead"}, *deformed_sheet(DEFORMATIONS["shear"]))


# --- alpha of points --------------------------------------------------------------------------------------------------


def test_alpha_of_points_is_each_points_own():
    sheet = deformed_sheet(DEFORMATIONS["shear"])
    options = dict(rotation=0.4, poisson=0.2, roughening=ROUGHENING, yield_strain=YIELD)
    alphas = np.random.default_rng(2).uniform(0.05, 0.6, (len(sheet[0]), 2)).astype(np.float32)
    found = taut.gloss(*sheet, alpha=alphas, **options)
    for point in (0, 7, len(alphas) - 1):
        alone = taut.gloss(*sheet, alpha=alphas[point], **options)
        np.testing.assert_array_equal(found.M[point], alone.M[point])
    corners = taut.Gloss(sheet[0], sheet[2], sheet[3], alphas, per="corner", **options).at(sheet[1])
    np.testing.assert_array_equal(corners.M, found.M[sheet[2].ravel()])


@pytest.mark.parametrize(
    "options, message",
    [
        (dict(roughening=-1), "roughening: found -1, expected a number, at least 0"),
        (dict(yield_strain="a"), "yield_strain: found 'a', expected a number, at least 0"),
        (dict(roughening=np.nan), "roughening: found nan, expected a number, at least 0"),
        (dict(alpha=np.full((5, 2), 0.1)), "alpha: found an array of shape (5, 2), expected a number, or two: along and across the "
         "tangent; or (30, 2), two for each point"),
        (dict(alpha=[[0.1, 0.1]] * 29 + [[0.1, 0]]), "alpha[29]: found 0, expected a number in [1e-4, 10]"),
    ],
)  # fmt: skip
def test_mistakes(options, message):
    with pytest.raises(taut.InputError) as raised:
        taut.gloss(*deformed_sheet(DEFORMATIONS["shear"]), **options)
    assert str(raised.value) == message


# --- facets of a map --------------------------------------------------------------------------------------------------

FACETS = [
    # A, lambda, l, s, alpha; s', lean along the projected tangent and across it, alpha max and min
    ([[2, 0], [0, 1]], 1, (0, 0), (0.5, 0), (0.1, 0.1), (0.25, 0), (0.6, 0), 0.1084652, 0.0588235),
    ([[2, 0], [0, 1]], 0.5, (0, 0), (0.5, 0), (0.1, 0.1), (0.125, 0), (1.5, 0), 0.0554700, 0.0307692),
    ([[1, 1], [0, 1]], 1, (0, 0), (0.3, -0.4), (0.1, 0.3), (0.3, -0.7), (-0.3493205, 0.2471421), 0.2707013, 0.0779849),
    ([[1, 1], [0, 1]], 1, (0.2, 0), (0.3, -0.4), (0.1, 0.3), (0.3191489, -0.7446809), (-0.1560674, 0.2675568), 0.2823243, 0.0838696),
]


def test_mapped_facets():
    A, stretch, lean, slope, alpha, carried, leans, largest, smallest = (np.array(column, float) for column in zip(*FACETS))
    F = ms.surface_deformation(A, stretch, lean)
    np.testing.assert_array_equal(F[3], [[1, 1, 0.2], [0, 1, 0], [0, 0, 1]])
    np.testing.assert_allclose(ms.carried_slope(F, slope), carried, atol=1e-7)
    M, frame = ms.mapped_transform(F, slope, ms.from_alpha(alpha[:, 0], alpha[:, 1]))
    np.testing.assert_allclose(frame[:, 2, :2] / frame[:, 2, 2:], carried, atol=1e-6)
    found = ms.equivalent_alpha(M)
    np.testing.assert_allclose(found[0], largest, atol=1e-6)
    np.testing.assert_allclose(found[1], smallest, atol=1e-6)
    # The lean along the tangent that is projected on the facet, and across it.
    tangent = (F @ [1, 0, 0]) - (np.einsum("ni,ni->n", F @ [1, 0, 0], frame[:, 2]))[:, None] * frame[:, 2]
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    world = np.einsum("nc,nci->ni", M[:, 3:], frame[:, :2])
    along, across = np.einsum("ni,ni->n", world, tangent), np.einsum("ni,ni->n", world, np.cross(frame[:, 2], tangent))
    np.testing.assert_allclose(np.stack([along, across], -1), leans, atol=1e-6)


def test_a_facet_without_a_slope_is_the_surface():
    A, rest = [[1.3, 0.4], [0.2, 0.8]], ms.from_alpha(0.1, 0.3, 0.7)
    M, frame = ms.mapped_transform(ms.surface_deformation(A, 1.4, (0.2, -0.1)), (0, 0), rest)
    np.testing.assert_allclose(M, ms.deform(A, rest, 1.4, (0.2, -0.1)), rtol=1e-6)
    np.testing.assert_array_equal(frame, np.eye(3))
    broad, _ = ms.mapped_transform(np.eye(3), (0, 0), rest, covariance=(0.01, 0.002, 0.03))
    sums = ms.slope_tensor(rest) + 2 * np.array([0.01, 0.002, 0.03])
    np.testing.assert_allclose(ms.slope_tensor(broad), sums, rtol=1e-5)
    with pytest.raises(taut.InputError, match=r"F\[1\]: found a matrix without an inverse"):
        ms.mapped_transform([np.eye(3), np.zeros((3, 3))], (0, 0), rest)
