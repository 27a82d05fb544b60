"""Renders files of `taut export` with Cycles as render_export.py does, at several numbers of samples, and prints the seconds of each.

    blender -b -noaudio --factory-startup --python-exit-code 1 --python time_export.py -- SCENE.toml FRAME SPP,SPP,... ROUNDS OUT FILE...

Every round has a seed of its own. One render goes before, not counted. Writes OUT/SPP-ROUND.exr and prints `cycles SPP ROUND SECONDS`
for each: the whole call, so BVH and all that Blender hands to Cycles are in it.
"""

import os
import sys
import time
import tomllib

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import render_export  # noqa: E402: found beside this file


def main():
    words = sys.argv[sys.argv.index("--") + 1 :]
    with open(words[0], "rb") as stream:
        description = tomllib.load(stream)
    frame, rounds, folder = int(words[1]), int(words[3]), os.path.abspath(words[4])
    render_export.build(description, frame, 1, words[5:])
    scene = bpy.context.scene
    for turn in range(-1, rounds):
        for spp in [int(word) for word in words[2].split(",")] if turn >= 0 else [1]:
            scene.cycles.samples, scene.cycles.seed = spp, max(turn, 0)
            scene.render.filepath = os.path.join(folder, f"{spp}-{turn}.exr")
            start = time.perf_counter()
            bpy.ops.render.render(write_still=True)
            if turn >= 0:
                print("cycles", spp, turn, time.perf_counter() - start, flush=True)


main()
