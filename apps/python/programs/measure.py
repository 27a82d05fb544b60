"""What the module costs beside the library itself: gloss of a million points a frame, the microsurface a row.

    PYTHONPATH=build/release/python /usr/bin/python3 apps/python/programs/measure.py build/release/taut_gloss_bench

The C++ program and Python take turns. Of the gloss, which all threads compute, the least time of all turns counts, since what else runs
on a machine only adds to it; of rows on one thread the median of its processor time.
"""

import json
import statistics
import subprocess
import sys
import time

import numpy as np
import taut
import taut.microsurface as ms

SIDE, ROUNDS, ROWS = 1000, 9, 1 << 20


def seconds_of(call, clock=time.perf_counter, choose=min):
    call()
    seconds = []
    for _ in range(ROUNDS):
        start = clock()
        call()
        seconds.append(clock() - start)
    return choose(seconds)


def sheet():
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, SIDE, dtype="f4"), np.linspace(-0.5, 0.5, SIDE, dtype="f4"))
    points = np.stack([x, y, 0 * x], -1).reshape(-1, 3)
    first = np.arange(SIDE * SIDE, dtype=np.int32).reshape(SIDE, SIDE)[:-1, :-1].ravel()
    return points, np.stack([first, first + 1, first + SIDE + 1, first + SIDE], -1)


def gloss_ms(gloss, moved):
    before = taut.copies()
    seconds = seconds_of(lambda: gloss.at(moved))
    assert taut.copies() == before, "an input was copied"
    return 1e3 * seconds


def rows_ns():
    random = np.random.default_rng(1)
    M = np.zeros((ROWS, 5), "f4")
    M[:, [0, 2]] = random.uniform(1, 10, (ROWS, 2))
    M[:, 1] = random.uniform(-2, 2, ROWS)
    wo, wi = (random.uniform([-0.5, -0.5, 0.1], [0.5, 0.5, 1.1], (ROWS, 3)) for _ in range(2))
    wo, wi = (np.ascontiguousarray(w / np.linalg.norm(w, axis=1, keepdims=True), "f4") for w in (wo, wi))
    u = random.random((ROWS, 2), "f4")
    calls = {
        "evaluate": lambda: ms.evaluate(M, wo, wi),
        "weight": lambda: ms.weight(M, wo, wi, bounded=False),
        "sample": lambda: ms.sample(M, wo, u),
    }
    taut.limit_threads(1)
    one = {name: 1e9 * seconds_of(call, time.thread_time, statistics.median) / ROWS for name, call in calls.items()}
    taut.limit_threads(0)
    return one, {name: 1e9 * seconds_of(call) / ROWS for name, call in calls.items()}


def main(program):
    rest, faces = sheet()
    gloss = taut.Gloss(rest, faces, alpha=0.1)
    moved = rest.copy()
    moved[:, 2] = 0.1 * np.sin(6 * rest[:, 0])
    turns = []
    for _ in range(5):
        library = json.loads(subprocess.run([program], check=True, capture_output=True, text=True).stdout)
        turns.append((library, gloss_ms(gloss, moved), *rows_ns()))
    library = min(turn[0]["gloss_ms"] for turn in turns)
    python = min(turn[1] for turn in turns)
    print(
        f"gloss of {SIDE * SIDE} points a frame: C++ {library:.1f} ms, Python {python:.1f} ms, ratio {python / library:.2f}, no input copied"
    )
    for name in ("evaluate", "weight", "sample"):
        library = statistics.median(turn[0]["ns_a_row"][name] for turn in turns)
        one, all_threads = (statistics.median(turn[i][name] for turn in turns) for i in (2, 3))
        print(
            f"{name}: C++ batch {library:.2f} ns a row, Python {one:.2f} on one thread (ratio {one / library:.2f}), {all_threads:.2f} on all"
        )


if __name__ == "__main__":
    main(*sys.argv[1:])
