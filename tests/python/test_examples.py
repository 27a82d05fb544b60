"""The examples and the notebook run as they are printed; what they show is looked at."""

import json
import runpy
import sys

import numpy as np
import pytest
import taut

from conftest import ROOT

EXAMPLES = ROOT / "apps" / "python" / "examples"


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(EXAMPLES))
    monkeypatch.setenv("MPLBACKEND", "Agg")
    yield
    for name in ("cloth", "plates", "variance"):
        sys.modules.pop(name, None)


def code_lines(name):
    lines = (EXAMPLES / name).read_text().split('"""', 2)[2].splitlines()
    return [line for line in lines if line and not line.startswith(("import", "if __name__"))]


def test_the_plates(tmp_path):
    runpy.run_path(str(EXAMPLES / "plates.py"), run_name="__main__")
    pixels, _ = taut.read_image(tmp_path / "plates.png")
    assert pixels.shape[:2] == (340, 1440)
    statements = sum(not line.startswith((" ", "}")) for line in code_lines("plates.py"))
    assert statements <= 10
    # Second moments of the highlights: round; narrow along y; turned; narrow along x.
    moments = []
    for plate in np.split(taut.read_image("plates.png")[0][..., 1] ** 2.2, 4, 1):
        y, x = np.mgrid[:340, :360]
        w = plate / plate.sum()
        x, y = x - (w * x).sum(), (w * y).sum() - y  # rows run down
        moments.append([(w * x * x).sum(), (w * y * y).sum(), (w * x * y).sum()])
    rest, up, sheared, along = moments
    assert rest[0] == pytest.approx(rest[1], rel=0.05) and abs(rest[2]) < 0.02 * rest[0]
    assert up[1] < 0.5 * up[0] and along[0] < 0.5 * along[1]
    assert abs(sheared[2]) > 0.2 * np.sqrt(sheared[0] * sheared[1])


def test_the_cloth():
    import cloth

    frames = cloth.drape(size=24, steps=80)
    rest = cloth.sheet(24)[0]
    gloss = cloth.gloss_of(24, frames)[-1]
    # Drawn apart at its upper corners, it is stretched along its upper edge, most of all at the corners, and smoother there.
    upper = np.argsort(rest[:, 2])[-24:]
    assert gloss.stretch[upper, 0].mean() > 1.05 > np.median(gloss.stretch[:, 0])
    assert (np.abs(gloss.alpha_max * gloss.alpha_min * gloss.stretch.prod(1) / 0.03 - 1) < 1e-4).all()  # det M = det A det M0


def test_variance():
    import variance

    rows = variance.variances(40000)
    means = np.array([row[:, 0] for row in rows.values()])
    spread = np.sqrt(np.array([row[:, 1] for row in rows.values()]) / 40000) * means
    assert (np.abs(means - means[3]) < 5 * np.hypot(spread, spread[3])).all()  # all estimate one light
    assert (rows["bounded"][:, 1] <= rows["visible normals"][:, 1] * 1.02).all()
    assert (rows["visible normals"][:, 1] < rows["all normals"][:, 1]).all()


@pytest.mark.parametrize("name", ["cloth", "variance"])
def test_programs_draw(name, tmp_path):
    pytest.importorskip("matplotlib")
    runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
    assert (tmp_path / f"{name}.png").stat().st_size > 10000


def test_the_notebook():
    plt = pytest.importorskip("matplotlib.pyplot")
    cells = json.loads((EXAMPLES / "taut.ipynb").read_text())
    assert cells["nbformat"] == 4
    plt.close("all")
    space, shown = {}, 0
    for cell in cells["cells"]:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), space)
            shown += bool(plt.get_fignums())
            plt.close("all")
    assert shown == 5
