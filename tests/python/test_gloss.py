"""taut.gloss against `taut export` of the same motion, against closed forms, and what it does with arrays, threads and mistakes."""

import threading

import numpy as np
import pytest
import taut

from conftest import ROOT, grid, read_obj


def alphas_of(A, alpha):
    """alpha_max, alpha_min of M = A M0, in double, by the eigenvalues of (M M^T)^-1."""
    M = np.asarray(A, float) @ np.diag(1 / np.asarray(alpha, float))
    eigenvalues = np.linalg.eigvalsh(np.linalg.inv(M @ M.swapaxes(-1, -2)))
    return np.sqrt(eigenvalues[..., 1]), np.sqrt(eigenvalues[..., 0])


# --- the command ------------------------------------------------------------------------------------------------------

SCENE = """
[material.brushed]
type = "conductor"
alpha = [0.08, 0.4]
rotation_deg = 25
poisson = 0.3
[[mesh]]
file = "{mesh}"
material = "brushed"
"""
MOTION = """
[[mesh.deform]]
type = "twist"
angle_deg = 60
[[mesh.deform]]
type = "shear"
plane = "xy"
amount = 0.7
"""


@pytest.mark.parametrize("name", ["panel", "body", "twist_bar"])
def test_equals_the_export_of_the_same_motion(name, command, tmp_path):
    mesh = ROOT / "meshes" / f"{name}.obj"
    moving, cached = tmp_path / "moving.toml", tmp_path / "cached.toml"
    moving.write_text(SCENE.format(mesh=mesh) + MOTION)
    made = command("export", moving, "-q", "-o", tmp_path / "motion.mdd")
    assert made.returncode == 0, made.stderr
    cached.write_text(SCENE.format(mesh=mesh) + f'cache = "{tmp_path}/motion.mdd"\n')
    made = command("export", cached, "-q", "-o", tmp_path / "gloss.npz")
    assert made.returncode == 0, made.stderr
    exported = np.load(tmp_path / "gloss.npz")

    rest, faces, uv, normals = read_obj(mesh)
    data = (tmp_path / "motion.mdd").read_bytes()
    deformed = np.frombuffer(data, ">f4", 3 * len(rest), 8 + 4).reshape(-1, 3).astype(np.float32)
    gloss = taut.Gloss(rest, faces, uv, (0.08, 0.4), np.radians(25), 0.3, normals, per="corner")
    found = gloss.at(deformed)

    # A vertex of the file is the corners of its rest position, tangent and so on: by position, then the one that is nearest in all.
    order = np.lexsort(exported["Pref"].T)
    keys = exported["Pref"][order]
    rows = np.concatenate(
        [
            np.column_stack([exported["M"], exported["tangent"]]),
            np.column_stack([exported[k] for k in ("alpha_max", "alpha_min", "phi", "stretch_max", "stretch_min")]),
        ],
        1,
    )[order]
    mine = np.concatenate([found.M, found.tangent, np.column_stack([found.alpha_max, found.alpha_min, found.phi]), found.stretch], 1)
    at = {}
    for row, key in enumerate(map(bytes, keys)):
        at.setdefault(key, []).append(row)
    worst = 0.0
    for corner, point in enumerate(faces[1]):
        candidates = rows[at[bytes(rest[point])]]
        difference = np.abs(candidates - mine[corner]) / np.maximum(1, np.abs(candidates))
        worst = max(worst, difference.max(1).min())
    assert worst <= 1e-6
    print(f"{name}: {len(faces[1])} corners, at most {worst:.1e} from the export")


# --- closed forms -----------------------------------------------------------------------------------------------------


def test_stretch():
    rest, faces, uv = grid(6, 5)
    for poisson, lam in ((0, 1), (0.5, 1 / 3), (-1, np.sqrt(3))):  # lambda = det^(-nu / (1 - nu)), det = 3
        found = taut.gloss(rest, rest * np.float32([2, 1.5, 1]), faces, uv, alpha=(0.1, 0.3), poisson=poisson)
        np.testing.assert_allclose(found.alpha_max, 0.3 / 1.5 * lam, rtol=2e-6)
        np.testing.assert_allclose(found.alpha_min, 0.1 / 2 * lam, rtol=2e-6)
        np.testing.assert_allclose(np.abs(found.phi), np.pi / 2, atol=1e-5)
        np.testing.assert_allclose(found.stretch, [[2, 1.5]] * len(rest), rtol=2e-6)
        np.testing.assert_allclose(found.tangent, [[1, 0, 0]] * len(rest), atol=1e-6)


@pytest.mark.parametrize("amount", [0.5, -1.2, 8.0])
def test_shear(amount):
    rest, faces, uv = grid(6, 5)
    A = np.array([[1, amount], [0, 1]])
    deformed = rest.copy()
    deformed[:, 0] += np.float32(amount) * rest[:, 1]
    found = taut.gloss(rest, deformed, faces, uv, alpha=(0.08, 0.4))
    largest, smallest = alphas_of(A, (0.08, 0.4))
    np.testing.assert_allclose(found.alpha_max, largest, rtol=1e-5)
    np.testing.assert_allclose(found.alpha_min, smallest, rtol=1e-5)
    np.testing.assert_allclose(found.stretch, [np.linalg.svd(A)[1]] * len(rest), rtol=1e-5)
    # The highlight turns and skews: phi is the eigenvector's, ds stays along x.
    M = A @ np.diag([1 / 0.08, 1 / 0.4])
    x, y = np.linalg.eigh(np.linalg.inv(M @ M.T))[1][:, 1]
    np.testing.assert_allclose(np.tan(found.phi), y / x, rtol=1e-4)


def test_any_rigid_motion_leaves_the_gloss_alone():
    rest, faces, uv = grid(6, 5)
    q, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    q *= np.linalg.det(q)
    still = taut.gloss(rest, rest, faces, uv)
    moved = taut.gloss(rest, (rest @ q.T + 5).astype(np.float32), faces, uv)
    np.testing.assert_allclose(moved.M, still.M, rtol=1e-5, atol=1e-4)
    np.testing.assert_allclose(moved.tangent, still.tangent @ q.T, atol=1e-5)


def tube(around, along, radius=1.0):
    """A closed cylinder about z with u around: points, quads and the angle and height of each point."""
    angle, height = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.linspace(0, 2, along + 1))
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], -1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(around), np.arange(along))
    next_i = (i + 1) % around
    faces = np.stack([j * around + i, j * around + next_i, (j + 1) * around + next_i, (j + 1) * around + i], -1).reshape(-1, 4)
    uv_corners = np.stack([np.stack([(i + di) / around, (j + dj) / along], -1) for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1))], 2)
    return points.astype("f4"), faces.astype("i4"), uv_corners.reshape(-1, 2).astype("f4"), angle.ravel(), height.ravel()


def second_order(errors):
    """Each halving of the faces leaves less than a third of the error: second order leaves a quarter."""
    assert all(finer < coarser / 3 for coarser, finer in zip(errors, errors[1:])), errors
    return errors


def test_twist_is_the_shear_of_its_radius():
    # Twisted by k radians a metre about its axis, a tube of radius r is sheared by r k along its circumference.
    turn, radius = 0.8, 0.7
    for size in (24, 48, 96):
        rest, faces, uv, angle, height = tube(size, size, radius)
        turned = angle + turn * height
        deformed = np.stack([radius * np.cos(turned), radius * np.sin(turned), height], -1).astype(np.float32)
        found = taut.gloss(rest, deformed, faces, uv, alpha=(0.1, 0.3))
        inside = (height > 0.1) & (height < 1.9)
        largest, smallest = alphas_of([[1, turn * radius], [0, 1]], (0.1, 0.3))
        np.testing.assert_allclose(found.alpha_max[inside], largest, rtol=5e-5)
        np.testing.assert_allclose(found.alpha_min[inside], smallest, rtol=5e-5)


def test_a_sheet_rolled_into_a_cylinder_keeps_its_gloss():
    radius, errors = 0.5, []
    for size in (64, 128, 256):
        rest, faces, uv = grid(size, size)
        angle = rest[:, 0].astype(float) / radius
        deformed = np.stack([radius * np.sin(angle), rest[:, 1], radius * np.cos(angle)], -1).astype(np.float32)
        found = taut.gloss(rest, deformed, faces, uv, alpha=(0.1, 0.3))
        inside = np.all((rest[:, :2] > 0.1) & (rest[:, :2] < 0.9), 1)
        errors.append(np.abs(found.M[inside] * [0.1, 0.1, 0.3, 0, 0] - [1, 0, 1, 0, 0]).max())
        along = np.stack([np.cos(angle), 0 * angle, -np.sin(angle)], -1)
        assert np.abs(found.tangent[inside] - along[inside]).max() < 1e-4
    print("cylinder:", second_order(errors))
    assert errors[-1] < 1e-3


def test_a_sphere_drawn_out_to_an_ellipsoid():
    # The gradient of a linear map F on a surface is F on its tangent plane: its stretches are the singular values there, on a mesh of
    # any coarseness, for the fit is exact at rest and linear.
    F = np.diag([1.0, 0.8, 2.0])
    for size in (24, 48, 96):
        angle, polar = np.meshgrid(np.arange(size) * 2 * np.pi / size, np.linspace(0.15 * np.pi, 0.85 * np.pi, size // 2 + 1))
        n = np.stack([np.cos(angle) * np.sin(polar), np.sin(angle) * np.sin(polar), -np.cos(polar)], -1).reshape(-1, 3)
        _, faces, uv, _, _ = tube(size, size // 2)
        found = taut.gloss(n.astype("f4"), (n @ F).astype("f4"), faces, uv, alpha=0.2)
        s = np.stack([-np.sin(angle), np.cos(angle), 0 * angle], -1).reshape(-1, 3)
        tangents = np.stack([s, np.cross(n, s)], -1)
        stretches = np.linalg.svd(F @ tangents, compute_uv=False)
        inside = np.abs(n[:, 2]) < 0.8
        np.testing.assert_allclose(found.stretch[inside], stretches[inside], rtol=5e-5)
        np.testing.assert_allclose(found.alpha_max[inside], 0.2 / stretches[inside, 1], rtol=5e-5)
        np.testing.assert_allclose(found.alpha_min[inside], 0.2 / stretches[inside, 0], rtol=5e-5)


# --- arrays -----------------------------------------------------------------------------------------------------------


def test_inputs_are_read_in_place_and_copies_are_counted():
    rest, faces, uv = grid(20, 20)
    before = taut.copies()
    gloss = taut.Gloss(rest, faces, uv)
    first = gloss.at(rest)
    assert taut.copies() == before
    doubled = gloss.at(rest.astype(np.float64))  # another type
    assert taut.copies()[0] == before[0] + 1 and taut.copies()[1] == before[1] + rest.nbytes
    strided = gloss.at(np.concatenate([rest, rest], 1)[:, :3])  # another layout
    assert taut.copies()[0] == before[0] + 2
    for other in (doubled, strided):
        for a, b in zip(first, other):
            np.testing.assert_array_equal(a, b)


def test_the_arrays_stay_the_callers():
    rest, faces, uv = grid(10, 10)
    gloss = taut.Gloss(rest, faces, uv, alpha=0.2)
    positions = rest.copy()
    kept = gloss.at(positions)
    rest *= 7  # the rest shape was taken over
    positions[:, 0] *= 2  # rewritten in place for the next frame
    np.testing.assert_allclose(gloss.at(positions).alpha_min, 0.1, rtol=1e-5)
    np.testing.assert_allclose(kept.alpha_min, 0.2, rtol=1e-5)


def test_faces_in_any_form_are_the_same_mesh():
    rest, faces, uv = grid(4, 3)
    deformed = (rest * [1, 2, 1]).astype("f4")
    expected = taut.gloss(rest, deformed, faces, uv)
    starts = np.arange(0, 4 * len(faces), 4)
    for form in (faces.tolist(), faces.astype(np.int64), faces.astype(np.uint16), (starts, faces.ravel())):
        np.testing.assert_array_equal(taut.gloss(rest, deformed, form, uv).M, expected.M)
    mixed = [face for quad in faces[1:].tolist() for face in [quad]] + [faces[0, [0, 1, 2]].tolist(), faces[0, [0, 2, 3]].tolist()]
    assert np.abs(taut.gloss(rest, deformed, mixed, uv).alpha_max - expected.alpha_max).max() < 1e-6


def test_seams_and_points_without_faces_are_counted():
    rest, faces, uv, _, _ = tube(12, 4)
    mirrored = uv.reshape(-1, 4, 2).copy()
    mirrored[len(mirrored) // 2 :, :, 0] *= -1  # the upper half has its uv turned over
    gloss = taut.Gloss(np.concatenate([rest, [[9, 9, 9]]]).astype("f4"), faces, mirrored.reshape(-1, 2), rotation=0.3)
    found = gloss.at(np.concatenate([rest, [[9, 9, 9]]]).astype("f4"))
    assert gloss.loose_points == 1 and np.isnan(found.alpha_max[-1]) and np.isfinite(found.alpha_max[:-1]).all()
    assert gloss.split_points == 12
    corners = taut.Gloss(rest, faces, mirrored.reshape(-1, 2), rotation=0.3, per="corner").at(rest)
    assert corners.M.shape == (4 * len(faces), 5) and np.isfinite(corners.M).all()
    # Each corner has the sense of its own face.
    signs = np.sign(corners.phi.reshape(len(faces), 4))
    assert (signs[: len(faces) // 2] == signs[0, 0]).all() and (signs[len(faces) // 2 :] == -signs[0, 0]).all()


def test_corner_rows_of_polygons_follow_the_order_of_the_faces():
    points = np.array([[np.cos(a), np.sin(a), 0] for a in np.arange(7) * 2 * np.pi / 7], "f4")
    gloss = taut.Gloss(points, [list(range(7))], per="corner")
    stretched = taut.Gloss(points, [[3, 4, 5, 6, 0, 1, 2]], per="corner")
    deformed = (points * [3, 1, 1]).astype("f4")
    np.testing.assert_allclose(gloss.at(deformed).tangent, np.roll(stretched.at(deformed).tangent, 3, 0), atol=1e-6)


# --- threads ----------------------------------------------------------------------------------------------------------


def test_threads_of_python_run_meanwhile():
    rest, faces, uv = grid(500, 500)
    gloss = taut.Gloss(rest, faces, uv)
    counted, over = [0], threading.Event()

    def count():
        while not over.is_set():
            counted[0] += 1

    counter = threading.Thread(target=count)
    counter.start()
    try:
        inside = 0
        for _ in range(3):
            before = counted[0]
            gloss._core.at(rest)  # one call that never comes back to the interpreter
            inside += counted[0] - before
    finally:
        over.set()
        counter.join()
    assert inside > 1000  # with the lock held it would be none


def test_one_gloss_serves_many_threads():
    rest, faces, uv = grid(60, 60)
    gloss = taut.Gloss(rest, faces, uv)
    frames = [(rest * [1 + 0.1 * k, 1, 1]).astype("f4") for k in range(12)]
    alone = [gloss.at(frame).M for frame in frames]
    together = [None] * len(frames)

    def work(k):
        together[k] = gloss.at(frames[k]).M

    threads = [threading.Thread(target=work, args=(k,)) for k in range(len(frames))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for a, b in zip(alone, together):
        np.testing.assert_array_equal(a, b)


# --- mistakes ---------------------------------------------------------------------------------------------------------

REST, FACES, UV = grid(2, 2)


@pytest.mark.parametrize(
    "arguments, message",
    [
        (dict(rest=REST[:, :2]), "rest: found an array of shape (9, 2), expected (points, 3)"),
        (dict(rest="a"), "rest: found 'a', expected an array of numbers"),
        (dict(deformed=REST[:4]), "deformed: found an array of shape (4, 3), expected (9, 3)"),
        (
            dict(deformed=REST * np.nan),
            "object 'gloss': found a point that is not finite at frame 1 (point 0), expected finite coordinates",
        ),
        (dict(faces=[[0, 1, 99]]), "objects[0] 'gloss'.mesh.cornerPositions: found an index beyond the positions in element 2, expected"),
        (dict(faces=np.array([[0, 1, -1]])), "faces: found the index -1, expected indices of points"),
        (dict(faces=[[0, 1]]), "faces: found an array of shape (1, 2), expected (faces, corners of each)"),
        (dict(faces=[[0, 1, 2.5]]), "faces: found [[0, 1, 2.5]], expected an array of whole numbers"),
        (dict(uv=UV[:5]), "uv: found 5 rows, expected one for each of 9 points or of 16 corners"),
        (dict(alpha=-1), "materials[0] 'gloss'.alphaX: found -1, expected a number in [1e-4, 10]"),
        (dict(alpha=(1, 2, 3)), "alpha: found an array of shape (3,), expected a number, or two"),
        (dict(poisson=0.7), "materials[0] 'gloss'.poisson: found 0.7"),
        (dict(gradient="aera"), "gradient: found 'aera', expected one of auto"),
        (dict(per="face"), "per: found 'face', expected 'point' or 'corner'"),
    ],
)
def test_mistakes_are_one_line(arguments, message):
    given = dict(rest=REST, deformed=REST, faces=FACES)
    given.update(arguments)
    with pytest.raises(taut.InputError) as error:
        taut.gloss(**given)
    assert str(error.value).startswith(message)
    assert "\n" not in str(error.value) and isinstance(error.value, ValueError)


def test_an_empty_mesh_is_a_mistake():
    with pytest.raises(taut.InputError):
        taut.Gloss(np.zeros((0, 3), "f4"), np.zeros((0, 3), "i4"))
