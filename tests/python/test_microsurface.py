"""taut.microsurface against the values that the C++ tests hold, against quadrature, and row by row against itself."""

import doctest
import math

import numpy as np
import pytest
import taut
import taut.microsurface as ms

PLATE = [10, 20, 10]  # alpha 0.1, sheared by 2
LEANING = [2, 0.5, 1.5, 0.8, -0.4]


def unit(*w):
    w = np.asarray(w[0] if len(w) == 1 else w, float)
    return w / np.linalg.norm(w, axis=-1, keepdims=True)


def direction(theta, phi):
    t, p = np.radians(theta), np.radians(phi)
    return np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], -1)


def hemisphere(n):
    """Directions and solid angles, equal in area."""
    z, phi = np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(4 * n) + 0.5) * np.pi / (2 * n))
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], -1).reshape(-1, 3), 2 * np.pi / z.size


# --- values of microsurface_test.cpp, conventions_test.cpp, general_transform_test.cpp, random_walk_test.cpp -----------------


def test_the_talks_plates():
    np.testing.assert_allclose(ms.D(PLATE, unit([0.1, 0, 1], [0, 0.1, 1], [0.1, -0.1, 1])), [0.9019664, 8.1176979, 3.6796623], rtol=1e-6)
    np.testing.assert_allclose(ms.D([[10, 0, 30], PLATE, [30, 0, 10]], [0, 0, 1]), [95.4930, 31.8310, 95.4930], rtol=1e-6)
    np.testing.assert_allclose(ms.G1(PLATE, [[0.6, 0, 0.8], [0, 0.6, 0.8]]), [0.9985977, 0.9930659], rtol=1e-6)
    # The cosine in standard space, w.z / L(w) = 1 / (1 + 2 Lambda).
    np.testing.assert_allclose(1 / (1 + 2 * ms.Lambda(LEANING, [[0.6, 0, 0.8], [-0.6, 0, 0.8]])), [0.9624671, 0.7496341], rtol=1e-6)


def test_the_half_vector_needs_no_length():
    wo, wi = direction(30, 10), direction(50, 200)
    assert ms.D(LEANING, wo + wi) == pytest.approx(ms.D(LEANING, unit(wo + wi)), rel=1e-12)


def test_conventions():
    known = {
        "alpha": (0.4, 0.1, None),
        "blender": (0.4472136, 0.8333333, 0.07957747),
        "blender_anisotropic": (0.4472136, -0.5, 0.07957747),
        "openpbr": (0.085**0.25, 0.75, None),
        "materialx": (0.4472136, 0.75, 0.5),
        "khr": (0.3162278, 0.5773503, 0.5),
    }
    assert set(known) == set(ms.conventions)
    for name, values in known.items():
        found = ms.to_convention(name, 0.4, 0.1, 0.5)
        assert not found.pop("clipped")
        np.testing.assert_allclose(list(found.values()), [v for v in values if v is not None], rtol=1e-6)
        back = ms.from_convention(name, **found)
        np.testing.assert_allclose(back[:2], [0.4, 0.1], rtol=1e-5)
        assert back[2] == pytest.approx(0.5 if values[2] is not None else 0, abs=1e-5)
    np.testing.assert_allclose(
        ms.from_convention("blender_anisotropic", roughness=0.5, anisotropy=0.5, rotation=0), [0.5, 0.125, 1.5707963]
    )
    assert ms.to_convention("blender", [0.5, 0.5], [0.01, 0.3])["clipped"].tolist() == [True, False]
    with pytest.raises(taut.InputError, match="expected one of alpha, blender.*did you mean 'khr'"):
        ms.to_convention("khl", 0.4, 0.1)
    with pytest.raises(taut.InputError, match="roughness, strength, rotation"):
        ms.from_convention("khr", roughness=0.3)


def test_general_transforms():
    random = np.random.default_rng(3)
    T = random.uniform(-1.5, 1.5, (200, 3, 3))
    T = T[np.abs(np.linalg.det(T)) > 0.3]
    M, frame = ms.general_transform(T)
    inverse_transposed = np.linalg.inv(T).swapaxes(-1, -2)
    np.testing.assert_allclose(frame[:, 2], unit(inverse_transposed[:, :, 2]), atol=1e-6)
    np.testing.assert_allclose(frame @ frame.swapaxes(1, 2), np.tile(np.eye(3), (len(T), 1, 1)), atol=1e-6)
    m = unit(random.normal(size=(len(T), 3)))
    s = np.einsum("nji,nj->ni", T, m)  # T^T m
    expected = np.where(
        s[:, 2] > 0, np.abs(np.linalg.det(T)) / (np.pi * np.linalg.norm(inverse_transposed[:, :, 2], axis=1) * (s**2).sum(1) ** 2), 0
    )
    np.testing.assert_allclose(ms.general_D(T, m), expected, rtol=1e-9)
    np.testing.assert_allclose(ms.D(M, np.einsum("nij,nj->ni", frame, m)), expected, rtol=2e-4, atol=1e-6)
    with pytest.raises(taut.InputError, match=r"T\[1\]: found a matrix without an inverse"):
        ms.general_transform([np.eye(3), np.zeros((3, 3))])


def test_a_deformation_is_the_product_of_matrices():
    random = np.random.default_rng(4)
    A, lean, lam = random.uniform(-2, 2, (50, 2, 2)), random.uniform(-2, 2, (50, 2)), 0.5 + random.random(50)
    M = ms.canonical(random.uniform(-2, 2, (50, 2, 2)), random.uniform(-2, 2, (50, 2)))
    gradient, whole = np.zeros((50, 3, 3)), np.zeros((50, 3, 3))
    gradient[:, :2, :2], gradient[:, :2, 2], gradient[:, 2, 2] = A, lean, lam
    whole[:, 0, 0], whole[:, 0, 1], whole[:, 1, 1], whole[:, :2, 2], whole[:, 2, 2] = M[:, 0], M[:, 1], M[:, 2], M[:, 3:], 1
    np.testing.assert_allclose(ms.deform(A, M, lam, lean), ms.general_transform(gradient @ whole)[0], rtol=1e-5, atol=1e-5)


def test_canonical_form_keeps_the_product_and_the_alphas():
    block = np.random.default_rng(7).uniform(-3, 3, (1000, 2, 2))
    M = ms.canonical(block)
    product = block @ block.swapaxes(1, 2)
    np.testing.assert_allclose(M[:, 0] ** 2 + M[:, 1] ** 2, product[:, 0, 0], rtol=1e-9)
    np.testing.assert_allclose(M[:, 1] * M[:, 2], product[:, 0, 1], atol=1e-9)
    good = np.abs(np.linalg.det(block)) > 0.05 * (block**2).sum((1, 2))
    largest, smallest, phi = ms.equivalent_alpha(M)
    np.testing.assert_allclose(ms.from_alpha(largest, smallest, phi)[good], M[good], rtol=1e-6, atol=1e-6)
    tensor = np.linalg.inv(product[good])
    np.testing.assert_allclose(
        ms.slope_tensor(M)[good], np.stack([tensor[:, 0, 0], tensor[:, 0, 1], tensor[:, 1, 1]], 1), rtol=1e-6, atol=1e-9
    )
    assert np.isfinite(ms.canonical([[0, 0], [0, 0]])).all()


def test_albedo():
    np.testing.assert_allclose(ms.albedo(ms.from_alpha([1, 0.5, 0.25]), [0, 0, 1]), [1 - math.log(2), 0.6878485, 0.9158124], atol=6e-3)
    # The integral of evaluate.
    w, area = hemisphere(600)
    assert (ms.evaluate(ms.from_alpha(0.5), [0, 0, 1], w) * area).sum() == pytest.approx(0.6878485, abs=1e-5)
    for M in (ms.from_alpha(0.5, 1.0, 0.3), [1, 2, 1]):
        for wo in (direction(20, 40), direction(70, 100)):
            assert ms.albedo(M, wo) == pytest.approx((ms.evaluate(M, wo, w) * area).sum(), abs=0.012)
    for M in (ms.from_alpha(0.1), ms.from_alpha(1.0), ms.from_alpha(0.2, 0.6)):
        assert ms.average_albedo(M) == pytest.approx((ms.albedo(M, w) * w[:, 2] * area).sum() / np.pi, abs=6e-3)


def test_mean_bounces_of_walks():
    for M, truth in ((ms.from_alpha(1.0), 2.302), ([1, 2, 1], 3.263), (ms.from_alpha(2.0), 4.383), (PLATE, 1.046)):
        bounces = ms.walk(np.tile(np.asarray(M, "f4"), (400000, 1)), [0, 0, 1], seed=5).bounces
        assert bounces.mean() == pytest.approx(truth, abs=0.001 + 3 * bounces.std() / math.sqrt(bounces.size))


def test_the_walk_loses_nothing():
    random = np.random.default_rng(2)
    M = ms.canonical(random.uniform(-3, 3, (3000, 2, 2)), random.uniform(-0.5, 0.5, (3000, 2)))
    M = M[ms.equivalent_alpha(M)[0] < 4]  # rougher ones are given up after 1024 facets now and then
    assert len(M) > 2000
    wi, throughput, bounces = ms.walk(M, direction(60, 50), seed=1)
    assert (throughput == 1).all() and (wi[:, 2] >= 0).all() and (bounces >= 1).all()
    assert np.abs(np.linalg.norm(wi, axis=1) - 1).max() < 1e-4
    again = ms.walk(M, direction(60, 50), seed=1)
    other = ms.walk(M, direction(60, 50), seed=2)
    assert (again.wi == wi).all() and (other.wi != wi).any(1).mean() > 0.9
    taut.limit_threads(1)
    assert (ms.walk(M, direction(60, 50), seed=1).wi == wi).all()
    taut.limit_threads(0)


def test_the_walks_evaluation_is_a_white_furnace():
    w, area = hemisphere(250)
    total = (ms.evaluate_walk(ms.from_alpha(1.0), direction(40, 10), w, seed=3)[:, 0] * area).sum()
    single = (ms.evaluate(ms.from_alpha(1.0), direction(40, 10), w) * area).sum()
    assert single < 0.75 and total == pytest.approx(1, abs=0.005)


# --- quadrature and chi-squared -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("M", [[2, 0, 1], [1, 2, 1], LEANING])
def test_normalisation(M):
    z, phi = np.meshgrid((np.arange(1200) + 0.5) / 600 - 1, (np.arange(1200) + 0.5) * np.pi / 600)
    w = np.stack([np.sqrt(1 - z * z) * np.cos(phi), np.sqrt(1 - z * z) * np.sin(phi), z], -1)
    area = 4 * np.pi / z.size
    assert (ms.D(M, w) * z * area).sum() == pytest.approx(1, abs=2e-3)
    for theta in (0, 30, 80, 130):
        assert (ms.visible_normal_pdf(M, direction(theta, 40), w) * area).sum() == pytest.approx(1, abs=5e-3)


@pytest.mark.parametrize("bounded", [True, False])
@pytest.mark.parametrize("M", [[2, 0, 1], [3, 4, 2], [2, 0.5, 1.5, 0.8, -0.4]])
@pytest.mark.parametrize("theta", [20, 75])
def test_samples_follow_their_density(M, theta, bounded):
    """Chi-squared over 30 x 60 cells, pooled to an expectation of 5; twelve such tests at 0.01 together."""
    count, wo = 400000, direction(theta, 40)
    wi, density = ms.sample(M, wo, np.random.default_rng(11).random((count, 2)), bounded)
    kept = density > 0
    np.testing.assert_allclose(density[kept], ms.pdf(M, wo, wi, bounded)[kept], rtol=1e-5)
    wi = wi[kept]
    cells = (30, 60)
    observed = np.histogram2d(wi[:, 2], np.arctan2(wi[:, 1], wi[:, 0]), cells, [[0, 1], [-np.pi, np.pi]])[0].ravel()
    fine = 16
    z, phi = np.meshgrid(
        (np.arange(cells[0] * fine) + 0.5) / (cells[0] * fine),
        ((np.arange(cells[1] * fine) + 0.5) / (cells[1] * fine) * 2 - 1) * np.pi,
        indexing="ij",
    )
    r = np.sqrt(1 - z * z)
    p = ms.pdf(M, wo, np.stack([r * np.cos(phi), r * np.sin(phi), z], -1), bounded) * 2 * np.pi / z.size
    expected = count * p.reshape(cells[0], fine, cells[1], fine).sum((1, 3)).ravel()
    rejected = (count - kept.sum(), count - expected.sum())  # below the horizon: one more cell
    order = np.argsort(expected)
    small = order[np.cumsum(expected[order]) < 5]
    large = np.setdiff1d(order, small)
    pairs = np.concatenate([np.stack([observed[large], expected[large]], 1), [[observed[small].sum(), max(expected[small].sum(), 1e-9)]]])
    if rejected[1] > 5:
        pairs = np.concatenate([pairs, [rejected]])
    pairs = pairs[pairs[:, 1] >= 1]
    statistic, freedom = ((pairs[:, 0] - pairs[:, 1]) ** 2 / pairs[:, 1]).sum(), len(pairs) - 1
    # Wilson & Hilferty: chi-squared's cube root is nearly normal; 3.2 standard deviations are 1 - 0.01 / 12.
    score = ((statistic / freedom) ** (1 / 3) - (1 - 2 / (9 * freedom))) / math.sqrt(2 / (9 * freedom))
    assert score < 3.2


def test_weights_are_what_is_evaluated_over_the_density():
    random = np.random.default_rng(5)
    M = ms.canonical(random.uniform(-3, 3, (4000, 2, 2)))
    wo, wi = direction(random.uniform(0, 85, 4000), random.uniform(0, 360, 4000)), direction(
        random.uniform(0, 85, 4000), random.uniform(0, 360, 4000)
    )
    for correlated in (True, False):
        f = ms.evaluate(M, wo, wi, correlated)
        for bounded in (True, False):
            np.testing.assert_allclose(ms.weight(M, wo, wi, correlated, bounded) * ms.pdf(M, wo, wi, bounded), f, rtol=1e-9)
        # f cos = D G2 / (4 wo.z); reciprocity.
        h = wo + wi
        np.testing.assert_allclose(f, ms.D(M, h) * ms.G2(M, wo, wi, correlated) / (4 * wo[:, 2]), rtol=1e-9)
        np.testing.assert_allclose(f / wi[:, 2], ms.evaluate(M, wi, wo, correlated) / wo[:, 2], rtol=1e-9)
    np.testing.assert_allclose(ms.G2(M, wo, wi, False), ms.G1(M, wo) * ms.G1(M, wi), rtol=1e-9)
    below = wi * [1, 1, -1]
    assert (ms.evaluate(M, wo, below) == 0).all() and (ms.weight(M, wo, below) == 0).all() and (ms.pdf(M, wo, below) == 0).all()


# --- arrays ---------------------------------------------------------------------------------------------------------------


def single(*arrays):
    return [np.asarray(a, "f4") for a in arrays]


def test_float_is_double_rounded():
    random = np.random.default_rng(6)
    n = 3001  # no multiple of a block
    M = ms.from_alpha(random.uniform(0.05, 1, n), random.uniform(0.05, 1, n), random.uniform(0, 3, n))
    wo, wi = direction(random.uniform(0, 85, n), random.uniform(0, 360, n)), direction(random.uniform(0, 85, n), random.uniform(0, 360, n))
    m, o, i = single(M, wo, wi)
    M, wo, wi = (a.astype(float) for a in (m, o, i))
    for function in (ms.evaluate, ms.weight, ms.pdf, ms.G2, lambda *a: ms.pdf(*a, bounded=False), lambda *a: ms.weight(*a, bounded=False)):
        found, truth = function(m, o, i), function(M, wo, wi)
        assert found.dtype == np.float32 and truth.dtype == np.float64 and found.shape == (n,)
        np.testing.assert_allclose(found, truth, rtol=3e-4)
    for bounded in (True, False):
        u = random.random((n, 2)).astype("f4")
        w, density = ms.sample(m, o, u, bounded)
        W, Density = ms.sample(M, wo, u.astype(float), bounded)
        # unitCircle()'s polynomials are floats in both.
        assert w.dtype == np.float32 and np.abs(w - W).max() < 2e-3


def test_any_transform_per_row_and_axes_broadcast():
    M = np.stack([ms.from_alpha([0.1, 0.2, 0.3]), ms.from_alpha([0.4, 0.5, 0.6])])  # (2, 3, 5)
    w = direction([0, 20, 40], 10)  # (3, 3)
    found = ms.G1(M, w)
    assert found.shape == (2, 3)
    for i in range(2):
        for j in range(3):
            assert found[i, j] == ms.G1(M[i, j], w[j])
    assert ms.G1(M[0, 0], w[1]).shape == () and ms.D(np.zeros((0, 5)), [0, 0, 1]).shape == (0,)
    wi, density = ms.sample(M[:, :1], w, [0.3, 0.6])
    assert wi.shape == (2, 3, 3) and density.shape == (2, 3)
    # Three numbers are five without lean.
    assert ms.D([2, 0.5, 1.5], [0.3, 0.1, 1]) == ms.D([2, 0.5, 1.5, 0, 0], [0.3, 0.1, 1])


def test_rows_are_read_in_place():
    M, wo, wi = single(np.tile(PLATE, (100, 1)), np.tile([0, 0, 1], (100, 1)), np.tile([0.6, 0, 0.8], (100, 1)))
    before = taut.copies()
    for function in (ms.evaluate, ms.pdf, ms.weight, ms.G2):
        function(M, wo, wi)
        function(M[0], wo, wi[0])
    assert taut.copies() == before
    ms.evaluate(M, wo.astype(float), wi)
    assert taut.copies()[0] > before[0]


@pytest.mark.parametrize(
    "call, message",
    [
        (lambda: ms.D([0, 1, 1], [0, 0, 1]), "M[0]: found a = 0, d = 1, expected two numbers above 0"),
        (lambda: ms.G1([PLATE, [1, 0, float("nan")]], [0, 0, 1]), "M[1]: found a = 1, d = nan"),
        (lambda: ms.D([1, 1], [0, 0, 1]), "M: found an array of shape (2,), expected a last axis of 3 or 5"),
        (lambda: ms.D(PLATE, [0, 1]), "wm: found an array of shape (2,), expected a last axis of 3"),
        (
            lambda: ms.evaluate(PLATE, np.ones((2, 3)), np.ones((3, 3))),
            "arguments: found shapes M (3,), wo (2, 3), wi (3, 3), expected shapes that",
        ),
        (lambda: ms.D("x", [0, 0, 1]), "M: found 'x', expected an array of numbers"),
        (lambda: ms.from_alpha(-1.0), "alpha[0]: found -1, -1, expected two numbers above 0"),
        (lambda: ms.canonical([1, 2]), "block: found an array of shape (2,), expected (..., 2, 2)"),
    ],
)
def test_mistakes(call, message):
    with pytest.raises(taut.InputError) as error:
        call()
    assert str(error.value).startswith(message) and "\n" not in str(error.value)


def test_the_examples_of_the_documentation():
    for module in (ms, __import__("taut._gloss", fromlist=["gloss"])):
        failed, tried = doctest.testmod(module, optionflags=doctest.NORMALIZE_WHITESPACE)
        assert failed == 0
        assert tried > 0
