"""The Python in README.md and docs/python.md runs as it is printed, block after block of a page."""

import re

import numpy as np
import pytest
import taut

from conftest import ROOT


@pytest.mark.parametrize("page", ["README.md", "docs/python.md"])
def test_the_page_runs(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(), re.S)
    assert blocks
    space = {}
    for block in blocks:
        exec(block, space)
        printed = capsys.readouterr().out.split()
        for promised in re.findall(r"^print\(.*\)  # (.*)$", block, re.M):
            assert printed == promised.split()
    if page == "docs/python.md":
        assert np.ptp(space["alpha_max"]) < 1e-4 and space["alpha_min"][0] < 0.1 < space["alpha_max"][0]
        picture, _ = taut.read_image("twisted.png")
        assert picture.shape == (90, 160, 3) and picture.std() > 0.05
