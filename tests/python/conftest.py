"""What the tests of the Python package share. ctest sets PYTHONPATH to the built package and TAUT_COMMAND to the built command."""

import os
import pathlib
import subprocess

import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]


def grid(columns, rows, width=1.0, height=1.0):
    """Points of a sheet in the xy plane, its quads and a uv with u along x."""
    x, y = np.meshgrid(np.linspace(0, width, columns + 1), np.linspace(0, height, rows + 1))
    points = np.stack([x, y, 0 * x], -1).reshape(-1, 3).astype(np.float32)
    first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    faces = np.stack([first, first + 1, first + columns + 2, first + columns + 1], -1).astype(np.int32)
    return points, faces, np.ascontiguousarray(points[:, :2])


def read_obj(path):
    """Positions, faces as (starts, corners), uv and normals a corner, of an OBJ with v/vt/vn corners."""
    table = {"v": [], "vt": [], "vn": []}
    starts, corners = [], []
    for line in open(path, encoding="utf-8"):
        words = line.split()
        if words and words[0] in table:
            table[words[0]].append([float(word) for word in words[1:]])
        elif words and words[0] == "f":
            starts.append(len(corners))
            corners += [[int(i) - 1 for i in word.split("/")] for word in words[1:]]
    v, vt, vn = (np.array(table[key], np.float32) for key in ("v", "vt", "vn"))
    corners = np.array(corners, np.int32)
    at = np.ascontiguousarray(corners[:, 0])
    return v, (np.array(starts, np.int32), at), np.ascontiguousarray(vt[corners[:, 1], :2]), vn[corners[:, 2]]


def run_taut(*words, **options):
    """The command; its output, or what it says on the way out."""
    return subprocess.run([os.environ["TAUT_COMMAND"], *map(str, words)], capture_output=True, text=True, **options)


@pytest.fixture
def command():
    if "TAUT_COMMAND" not in os.environ:
        pytest.skip("TAUT_COMMAND is not set")
    return run_taut
