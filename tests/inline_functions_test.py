#!/usr/bin/env python3
"""Of an inline function that several sources keep, programs hold the library's, which is optimised most.

    inline_functions_test.py LIBRARY PROGRAM...

Compares the sizes that nm prints of functions of namespace taut: the first of the archive's against each program's. Optimised otherwise,
most have other sizes.
"""
import subprocess
import sys


def functions(file, kinds):
    """Names of functions of namespace taut in the file, of these of nm's kinds, and their sizes in bytes; the first of a name counts."""
    sizes = {}
    for line in subprocess.run(["nm", "-S", file], capture_output=True, text=True, check=True).stdout.splitlines():
        words = line.split()
        if len(words) == 4 and words[2] in kinds and words[3].startswith("_ZN") and "4taut" in words[3][:8]:
            sizes.setdefault(words[3], int(words[1], 16))
    return sizes


library = functions(sys.argv[1], "W")
failed = False
for program in sys.argv[2:]:
    held = functions(program, "Wt")  # t: a module shows nothing
    both = [name for name in library if name in held]
    other = [name for name in both if held[name] != library[name]]
    print(f"{program}: {len(other)} of {len(both)} inline functions are not the library's", *other[:3])
    failed |= bool(other) or len(both) < 100
sys.exit(failed)
