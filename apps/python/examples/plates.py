"""The talk's plates: alpha 0.1 both ways, at rest and under three A, each under one small lamp. Writes plates.png."""

import numpy as np
import taut

x, y = np.meshgrid(np.linspace(-0.5, 0.5, 33, dtype="f4"), np.linspace(-0.5, 0.5, 33, dtype="f4"))
rest = np.stack([x, y, 0 * x], -1).reshape(-1, 3)
first = np.arange(33 * 32).reshape(32, 33)[:, :-1].ravel()
faces = np.stack([first, first + 1, first + 34, first + 33], -1)
deformed = [rest @ np.float32([[a, 0, 0], [b, d, 0], [0, 0, 1]]) for a, b, d in ((1, 0, 1), (1, 0, 3), (1, 2, 1), (3, 0, 1))]
scene = taut.Scene({
    "render": {"width": 360, "height": 340, "spp": 32, "max_events": 1},
    "camera": {"position": [0, 0, 20], "up": [0, 1, 0], "fov_deg": 9.6},
    "light": [{"type": "sphere", "centre": [0, 0, 0.9], "radius": 0.025, "radiance": 38}],
    "material": {"satin": {"type": "conductor", "multiscatter": "off", "alpha": 0.1}},
    "mesh": [{"positions": rest, "faces": faces, "points": deformed, "material": "satin"}],
})  # fmt: skip
picture = np.hstack([scene.render(frame)["rgb"] for frame in (1, 2, 3, 4)])

if __name__ == "__main__":
    taut.write_image("plates.png", picture)
