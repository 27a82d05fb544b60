"""Shows what `taut export` wrote:

    blender --python apps/blender/show.py -- out/####.npz 1-24
"""

import os
import sys

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import taut_gloss  # noqa: E402


def main(pattern, frames="1"):
    first, last = (frames.split("-") * 2)[:2]
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = int(first), int(last)
    item = taut_gloss.import_gloss(pattern, int(first))
    taut_gloss.start_following()
    scene.frame_set(int(first))
    print(f"{item.name}: {len(item.data.vertices)} vertices, frames {first} to {last}")


if __name__ == "__main__":
    main(*sys.argv[sys.argv.index("--") + 1 :])
