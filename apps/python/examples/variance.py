"""Variance of published samplers of the transformed GGX, by the shear of the surface. Writes variance.png (matplotlib)."""

import numpy as np
import taut.microsurface as ms


def unit_square(count, seed=1):
    return np.random.default_rng(seed).random((count, 2))


def cosine(M, wo, u):
    """Directions by the cosine: weights f cos / pdf."""
    r, phi = np.sqrt(u[:, 1]), 2 * np.pi * u[:, 0]
    wi = np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(1 - u[:, 1])], -1)
    return ms.evaluate(M, wo, wi) * np.pi / wi[:, 2]


def all_normals(M, wo, u):
    """Micro-normals by D cos (Walter et al. 2007): those of the standard surface, carried along by M^-T."""
    a, b, d = M[:3]
    r, phi = np.sqrt(u[:, 1]), 2 * np.pi * u[:, 0]
    x = r * np.cos(phi) / a
    wm = np.stack([x, (r * np.sin(phi) - b * x) / d, np.sqrt(1 - u[:, 1])], -1)
    wm /= np.linalg.norm(wm, axis=1, keepdims=True)
    cosine = wm @ wo
    wi = 2 * cosine[:, None] * wm - wo
    used = (cosine > 0) & (wi[:, 2] > 0)
    weights = np.zeros(len(u))
    weights[used] = ms.evaluate(M, wo, wi[used]) * 4 * cosine[used] / (ms.D(M, wm[used]) * wm[used, 2])
    return weights


def visible_normals(M, wo, u):
    """Visible normals by caps (Dupuy & Benyoub 2023)."""
    wi, pdf = ms.sample(M, wo, u, bounded=False)
    return np.where(pdf > 0, ms.weight(M, wo, wi, bounded=False), 0)


def bounded_normals(M, wo, u):
    """Visible normals without most of those that reflect below the horizon (Eto & Tokuyoshi 2023)."""
    wi, pdf = ms.sample(M, wo, u)
    return np.where(pdf > 0, ms.weight(M, wo, wi), 0)


SAMPLERS = {"cosine": cosine, "all normals": all_normals, "visible normals": visible_normals, "bounded": bounded_normals}
SHEARS = np.linspace(0, 4, 9)


def variances(count=100000, alpha=0.6, theta=60.0):
    """Mean and relative variance of a sample of the reflected light, by sampler and shear; the view at `theta` degrees across the shear."""
    wo = np.array([0, np.sin(np.radians(theta)), np.cos(np.radians(theta))])
    rows = {name: [] for name in SAMPLERS}
    for shear in SHEARS:
        M = ms.deform([[1, shear], [0, 1]], ms.from_alpha(alpha))
        for name, sampler in SAMPLERS.items():
            weights = sampler(M, wo, unit_square(count))
            rows[name].append((weights.mean(), weights.var() / weights.mean() ** 2))
    return {name: np.array(row) for name, row in rows.items()}


def draw(rows):
    import matplotlib.pyplot as plt

    figure, axis = plt.subplots(figsize=(6.4, 4.4), layout="constrained")
    for name, row in rows.items():
        axis.semilogy(SHEARS, row[:, 1], "o-", label=name)
    axis.set(xlabel="shear", ylabel="variance of a sample / mean²", title="alpha 0.6, seen at 60° across the shear")
    axis.legend()
    return figure


if __name__ == "__main__":
    draw(variances()).savefig("variance.png", dpi=110)
