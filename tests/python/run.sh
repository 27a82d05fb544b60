#!/bin/sh
# run.sh PYTHON FOLDER COMMAND: the tests of the Python package in FOLDER; 77 where there is no pytest to run them.
# PRELOAD=... are libraries that the Python loads first: the runtimes of sanitizers that the package is built with.
set -eu
if ! "$1" -c 'import numpy, pytest' 2>/dev/null; then
    echo "skipped: $1 has no numpy or no pytest (python3-numpy, python3-pytest)"
    exit 77
fi
if [ -n "${PRELOAD:-}" ]; then export LD_PRELOAD="$PRELOAD"; fi
PYTHONPATH=$2 TAUT_COMMAND=$3 PYTHONDONTWRITEBYTECODE=1 exec "$1" -m pytest -q -p no:cacheprovider -ra "$(dirname "$0")"
