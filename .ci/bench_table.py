#!/usr/bin/env python3
"""bench_table.py NAME FILE... -- NAME FILE...: numbers of taut_bench on two systems side by side, each the median of its files."""

import json
import statistics
import sys

COLUMNS = (  # head, field, factor, digits
    ("Msamples/s", "samples_per_s", 1e-6, 3),
    ("Mrays/s", "rays_per_s", 1e-6, 2),
    ("bare Embree", "embree_rays_per_s", 1e-6, 2),
    ("to Embree", "ratio_to_embree", 1, 2),
    ("update ms", "update_seconds_per_frame", 1e3, 1),
    ("peak MB", "peak_mb", 1, 0),
)


def scenes_of(files):
    """{scene: {field: median}}"""
    runs = [{scene["name"]: scene for scene in json.load(open(file, encoding="utf-8"))["scenes"]} for file in files]
    return {name: {field: statistics.median(run[name][field] for run in runs) for _, field, _, _ in COLUMNS} for name in runs[0]}


words = sys.argv[1:]
middle = words.index("--")
sides = [words[:middle], words[middle + 1 :]]
tables = [scenes_of(side[1:]) for side in sides]
print(f"left: {sides[0][0]}, right: {sides[1][0]}; medians of {len(sides[0]) - 1} rounds, in turn")
print(f"{'scene':16}" + "".join(f"{head:>18}" for head, *_ in COLUMNS))
for name, left in tables[0].items():
    cells = [" ".join(f"{factor * row[field]:8.{digits}f}" for row in (left, tables[1][name])) for _, field, factor, digits in COLUMNS]
    print(f"{name:16}" + "".join(f"{cell:>18}" for cell in cells))
