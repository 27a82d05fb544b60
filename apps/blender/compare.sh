#!/bin/sh
# Taut against Cycles: one frame of a scene by `taut render`, and its `taut export` by Blender, with the gloss following the
# deformation and with it held fixed. Prints the relative mean squared error of each against the Taut image, of Taut's image with
# another seed and of two seeds of Cycles (the noise of either), and writes a picture of images and differences.
#
#   apps/blender/compare.sh build/release/taut SCENE.toml FRAME OUT [SPP] [-D key=value ...]
set -eu
if [ $# -lt 4 ]; then
    sed -n '2,7s/^# \{0,1\}//p' "$0" >&2
    exit 2
fi
taut=$1 scene=$2 frame=$3 out=$4
shift 4
spp=256
case ${1--} in -*) ;; *) spp=$1; shift ;; esac
here=$(dirname "$0")
blender() { command blender -b -noaudio --factory-startup --python-exit-code 1 "$@" >"$out/blender.log" 2>&1 || { cat "$out/blender.log" >&2; exit 1; }; }
# relMSE of an image against a reference, and of means of 4 x 4 pixels, which noise hardly touches.
errors() {
    "$taut" compare "$2" "$3" --box 4 | awk -v name="$1" '/^relMSE of means/ { filtered = $NF } /^relMSE [0-9]/ { raw = $2 + 0 } END { print "relMSE", name, raw, "filtered", filtered }'
}
mkdir -p "$out/follow" "$out/fixed"
rm -f "$out"/follow/* "$out"/fixed/*

"$taut" render "$scene" --frames "$frame" --spp "$spp" -q -o "$out/taut.exr" "$@"
"$taut" render "$scene" --frames "$frame" --spp "$spp" -q --seed 7 -o "$out/again.exr" "$@"
"$taut" export "$scene" --frames "$frame" -q -o "$out/follow/####.npz" "$@"
"$taut" export "$scene" --frames "$frame" -q -o "$out/fixed/####.npz" -D mesh.0.follow=false "$@"
for way in follow fixed; do
    blender --python "$here/cycles.py" -- render "$scene" "$frame" "$spp" "$out/$way.exr" "$out/$way"/*.npz
done
blender --python "$here/cycles.py" -- render "$scene" "$frame" "$spp" "$out/other.exr" seed=7 "$out/follow"/*.npz
errors cycles_two_seeds "$out/other.exr" "$out/follow.exr"
blender --python "$here/cycles.py" -- compare "$out/taut.exr" "$out/compare.png" \
    "cycles_follow=$out/follow.exr" "cycles_fixed=$out/fixed.exr" "taut_other_seed=$out/again.exr"
errors cycles_follow "$out/follow.exr" "$out/taut.exr"
errors cycles_fixed "$out/fixed.exr" "$out/taut.exr"
errors taut_other_seed "$out/again.exr" "$out/taut.exr"
