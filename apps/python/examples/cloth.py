"""A cloth that numpy lets hang and pulls, and what becomes of its gloss. Writes cloth.png (matplotlib)."""

import numpy as np
import taut


def sheet(size):
    """Points [size^2, 3] of a square metre in the xz plane, its quads, and uv with u along x."""
    x, z = np.meshgrid(np.linspace(-0.5, 0.5, size, dtype="f4"), np.linspace(0, 1, size, dtype="f4"))
    first = np.arange(size * (size - 1)).reshape(size - 1, size)[:, :-1].ravel()
    faces = np.stack([first, first + 1, first + size + 1, first + size], -1).astype("i4")
    return np.stack([x, 0 * x, z], -1).reshape(-1, 3), faces, np.stack([x, z], -1).reshape(-1, 2)


def drape(size=40, steps=240, pull=1.15):
    """Frames of positions: masses and springs by Verlet's rule, held at the upper corners, which are drawn apart by `pull`."""
    rest = sheet(size)[0].astype(float)
    grid = rest.reshape(size, size, 3)
    pairs = [(grid[:, 1:], grid[:, :-1]), (grid[1:], grid[:-1]), (grid[1:, 1:], grid[:-1, :-1]), (grid[1:, :-1], grid[:-1, 1:])]
    number = np.arange(size * size).reshape(size, size)
    ends = [
        (number[:, 1:], number[:, :-1]),
        (number[1:], number[:-1]),
        (number[1:, 1:], number[:-1, :-1]),
        (number[1:, :-1], number[:-1, 1:]),
    ]
    a = np.concatenate([p.ravel() for p, _ in ends])
    b = np.concatenate([q.ravel() for _, q in ends])
    length = np.concatenate([np.linalg.norm(p - q, axis=-1).ravel() for p, q in pairs])
    share = 0.5 * np.bincount(np.concatenate([a, b]), minlength=size * size)
    held = [number[-1, 0], number[-1, -1]]
    now, before, frames = rest.copy(), rest.copy(), []
    for step in range(steps):
        now, before = now + 0.99 * (now - before) + [0, 2e-5 * np.sin(step / 9), -2e-4], now
        for _ in range(12):
            apart = now[a] - now[b]
            distance = np.linalg.norm(apart, axis=1)
            move = (0.5 * (1 - length / distance))[:, None] * apart
            for c in range(3):
                now[:, c] += (np.bincount(b, move[:, c], size * size) - np.bincount(a, move[:, c], size * size)) / share
            now[held] = rest[held] * [1 + (pull - 1) * min(1, 2 * step / steps), 1, 1]
        frames.append(now.astype("f4"))
    return frames


def gloss_of(size, frames, alpha=(0.1, 0.3)):
    """Gloss at each of the frames; topology is built once."""
    rest, faces, uv = sheet(size)
    kept = taut.Gloss(rest, faces, uv, alpha)
    return [kept.at(positions) for positions in frames]


def draw(size, positions, gloss):
    """Stretch, both alphas, and the direction of the rougher axis, on the cloth seen from the front."""
    import matplotlib.pyplot as plt

    faces = sheet(size)[1]
    triangles = np.concatenate([faces[:, :3], faces[:, [0, 2, 3]]])
    columns = {"largest stretch": gloss.stretch[:, 0], "alpha of the rougher axis": gloss.alpha_max, "alpha across it": gloss.alpha_min}
    figure, axes = plt.subplots(1, 3, figsize=(13, 4.6), sharex=True, sharey=True, layout="constrained")
    for axis, (name, values) in zip(axes, columns.items()):
        shown = axis.tripcolor(positions[:, 0], positions[:, 2], triangles, values, shading="gouraud", cmap="viridis")
        figure.colorbar(shown, ax=axis, orientation="horizontal", label=name)
        axis.set_aspect("equal")
    # The rougher axis lies at phi from the tangent towards cross(normal, tangent); the cloth faces -y.
    side = np.cross([0, -1, 0], gloss.tangent)
    rough = np.cos(gloss.phi)[:, None] * gloss.tangent + np.sin(gloss.phi)[:, None] * side
    some = np.arange(len(positions)).reshape(size, size)[::4, ::4].ravel()
    axes[1].quiver(
        positions[some, 0],
        positions[some, 2],
        rough[some, 0],
        rough[some, 2],
        color="w",
        pivot="mid",
        headaxislength=0,
        headlength=0,
        scale=34,
    )
    return figure


if __name__ == "__main__":
    cloth = drape()
    draw(40, cloth[-1], gloss_of(40, cloth)[-1]).savefig("cloth.png", dpi=110)
