#!/bin/sh
# Line coverage of src/ by all corpora: coverage.sh BUILD CORPORA, with a build of the preset fuzz-coverage. The table by file goes to
# CORPORA/coverage.txt, the sum to standard output.
set -eu
build=$1
corpora=$2
profiles=$corpora/profiles
mkdir -p "$profiles"
for name in $("$build/taut_fuzz_replay" --seeds "$corpora/seeds"); do
    mkdir -p "$corpora/$name"
    LLVM_PROFILE_FILE="$profiles/$name.profraw" "$build/taut_fuzz_replay" "$name" "$corpora/seeds/$name" "$corpora/$name" 2>&1 | tail -1
done
llvm-profdata-14 merge -sparse "$profiles"/*.profraw -o "$profiles/all.profdata"
llvm-cov-14 report "$build/taut_fuzz_replay" -object "$build/taut_images.so" -instr-profile "$profiles/all.profdata" \
    -ignore-filename-regex='/(apps|tests)/' >"$corpora/coverage.txt"
awk '/^TOTAL/ { print "lines of src/ covered: " $10 " (" $8 - $9 " of " $8 ")" }' "$corpora/coverage.txt"
