#!/usr/bin/env bash
# The demo: a grained rubber sheet drawn out, a dimpled rubber grip drawn out, twisted and bent, and our brushed meshes sheared, twisted
# and stretched, with the gloss following the deformation and with roughness held fixed as other renderers do. Between the two only
# the scene key `follow` differs.
#
#   apps/demo/demo.sh TAUT OUTDIR             everything below, in about four minutes on two cores
#   apps/demo/demo.sh TAUT OUTDIR PICTURE     only the README's picture, with 256 samples a pixel; it is committed, made by
#                                             apps/demo/demo.sh build/release/taut out/picture docs/images/demo.png
#
#   OUTDIR/frames/{follow,fixed}/{rubber,grip,panel,body,plates}.####.{exr,png}   what taut renders
#   OUTDIR/pair/{rubber,grip,panel,body}.####.png                     each frame beside its twin
#   OUTDIR/plates.{exr,png}    the plate at rest and with M = [10 0; 0 30], [10 20; 0 10], [30 0; 0 10]
#   OUTDIR/contact.png         a contact sheet
#   OUTDIR/picture.png         at rest, following, held fixed
#   OUTDIR/demo.mp4            the pairs of metal as a film, where ffmpeg is present
#   OUTDIR/rubber.mp4, OUTDIR/grip.mp4   and those of rubber, three seconds each
#
# Needs oiiotool (Debian: openimageio-tools). Labels want fonts-dejavu-core and are left out without it.
# brushed.png, the lines on the metal, was made by
#   oiiotool --pattern noise:type=gaussian:mean=0.8:stddev=0.075:mono=1:seed=7 384x6 1 --clamp:min=0.55:max=1 -d uint8 -o brushed.png
# leather.png, the grain of the rubber sheet, 16 bits of height, by
#   noise=--pattern\ noise:type=gaussian:mean=0.5:stddev=0.3:mono=1:seed
#   oiiotool $noise=3 320x320 1 --blur 9x9 $noise=5 320x320 1 --blur 5x5 --mulc 0.25 --add --subc 0.6 --mulc 2 --addc 0.45 \
#       --clamp:min=0:max=1 -d uint16 --compression zip:9 -o leather.png
# and dimples.png, a tile of those of the grip, likewise, by
#   oiiotool --pattern checker:width=32:height=32 192x192 1 --blur 41x41 --cut 64x64+64+64 --subc 0.5 --mulc 1.6 --addc 0.5 \
#       --clamp:min=0:max=1 -d uint16 --compression zip:9 -o dimples.png
set -euo pipefail

fail() {
    echo "demo: $*" >&2
    exit 1
}

[ $# = 2 ] || [ $# = 3 ] || fail "found $# arguments, expected TAUT OUTDIR [PICTURE]"
taut=$1
out=$2
scenes=$(dirname "${BASH_SOURCE[0]}")
[ -x "$taut" ] || fail "no program $taut: run make first"
command -v oiiotool >/dev/null || fail "oiiotool is missing: apt-get install openimageio-tools"
[ $# = 2 ] || command -v ffmpeg >/dev/null || fail "ffmpeg is missing: apt-get install ffmpeg"
mkdir -p "$out/frames/follow" "$out/frames/fixed" "$out/pair"

say() { printf '[%3d s] %s\n' "$SECONDS" "$*"; }

# Pictures are put together on a canvas: oiiotool arguments are collected in `canvas`, then run.
ground=0.085,0.088,0.095
ink=0.88,0.88,0.88
font=
for name in DejaVuSans /usr/share/fonts/truetype/dejavu/DejaVuSans.ttf; do # by its name where this oiiotool finds it so
    if oiiotool --create 8x8 3 --text:font=$name x -o "$out/label.png" >/dev/null 2>&1; then
        font=$name
        break
    fi
done
rm -f "$out/label.png"
[ -n "$font" ] || say "no labels: oiiotool can't draw text with DejaVuSans (apt-get install fonts-dejavu-core)"

newCanvas() { canvas=(--create "$1x$2" 3 "--fill:color=$ground" "$1x$2"); } # width height
paste() {                                                                   # file x y [width height]
    canvas+=("$1" --ch R,G,B)
    if [ $# = 5 ]; then canvas+=(--resize "$4x$5"); fi
    canvas+=(--swap --paste "+$2+$3")
}
label() { # text x y size, centred at (x, y)
    if [ -n "$font" ]; then canvas+=("--text:x=$2:y=$(($3 + $4 / 3)):size=$4:font=$font:color=$ink:xalign=center" "$1"); fi
}
save() { oiiotool "${canvas[@]}" -d uint8 --compression zip:9 -o "$1"; }

follows="gloss follows the deformation"
held="roughness held fixed"

# render NAME [options]: both versions of a scene.
render() {
    local name=$1
    shift
    rm -f "$out"/frames/{follow,fixed}/"$name".*.{exr,png}
    say "$name, $follows"
    "$taut" render "$scenes/$name.toml" --quiet -o "$out/frames/follow/$name.####.exr" -o "$out/frames/follow/$name.####.png" "$@"
    say "$name, $held"
    "$taut" render "$scenes/$name.toml" --quiet -D mesh.0.follow=false \
        -o "$out/frames/fixed/$name.####.exr" -o "$out/frames/fixed/$name.####.png" "$@"
}

# pair NAME HEIGHT: each frame beside its twin, all frames in one run (# stands for the frame number).
pair() {
    newCanvas 960 $(($2 + 32))
    paste "$out/frames/follow/$1.#.png" 0 32
    paste "$out/frames/fixed/$1.#.png" 480 32
    label "$follows" 240 16 17
    label "$held" 720 16 17
    rm -f "$out/pair/$1".*.png
    save "$out/pair/$1.#.png"
}

# row VERSION NAME Y WIDTH HEIGHT FRAME...: frames side by side, from the left.
row() {
    local version=$1 name=$2 y=$3 width=$4 height=$5 x=0 frame
    shift 5
    for frame; do
        paste "$out/frames/$version/$name.$(printf %04d "$frame").png" $x "$y" "$width" "$height"
        x=$((x + width))
    done
}

# labels Y SIZE STEP TEXT...: texts centred in columns of width STEP.
labels() {
    local y=$1 size=$2 step=$3 x=$(($3 / 2)) text
    shift 3
    for text; do
        label "$text" $x "$y" "$size"
        x=$((x + step))
    done
}

matrices=("M = [10 0; 0 10]  (at rest)" "M = [10 0; 0 30]" "M = [10 20; 0 10]" "M = [30 0; 0 10]")

plates() {
    newCanvas 1440 412
    row follow plates 36 360 340 1 2 3 4
    label "$follows: a plate of alpha 0.1, deformed" 720 18 17
    labels 394 17 360 "${matrices[@]}"
    save "$out/plates.png"
    oiiotool "$out"/frames/follow/plates.000[1-4].exr --mosaic 4x1 -o "$out/plates.exr"
}

contact() {
    newCanvas 1440 2014
    local y=0 name height captions
    for name in panel body; do
        height=240 captions=("at rest" "half sheared" "sheared" "sheared and stretched")
        if [ $name = body ]; then height=270 captions=("at rest" "half twisted" "twisted" "twisted and drawn out"); fi
        label "$follows" 720 $((y + 17)) 18
        row follow $name $((y + 34)) 360 $height 1 8 14 24
        label "$held" 720 $((y + 34 + height + 17)) 18
        row fixed $name $((y + 68 + height)) 360 $height 1 8 14 24
        labels $((y + 68 + 2 * height + 15)) 15 360 "${captions[@]}"
        y=$((y + 68 + 2 * height + 38))
    done
    label "$follows" 720 $((y + 17)) 18
    row follow plates $((y + 34)) 360 340 1 2 3 4
    labels $((y + 34 + 340 + 17)) 16 360 "${matrices[@]}"
    label "$held" 720 $((y + 34 + 340 + 51)) 18
    row fixed plates $((y + 34 + 340 + 68)) 360 340 1 2 3 4
    save "$out/contact.png"
}

# picture FILE: three columns, at rest, following, held fixed.
picture() {
    newCanvas 1400 1700
    labels 20 20 466 "at rest" "deformed: $follows" "deformed: $held"
    local y=40 name height last
    for name in rubber grip panel body; do
        height=311 last=0018
        if [ $name = body ]; then height=350; fi
        if [ $name = body ] || [ $name = panel ]; then last=0024; fi
        paste "$out/frames/follow/$name.0001.png" 0 $y 466 $height
        paste "$out/frames/follow/$name.$last.png" 467 $y 466 $height
        paste "$out/frames/fixed/$name.$last.png" 934 $y 466 $height
        y=$((y + height + 1))
    done
    row follow plates $y 350 331 1 2 3 4
    labels $((y + 331 + 20)) 18 350 "${matrices[@]}"
    save "$1"
}

if [ $# = 3 ]; then
    for name in rubber grip; do render $name --frames 1,18 --spp 256; done
    for name in panel body; do render $name --frames 1,24 --spp 256; done
    render plates --spp 256
    mkdir -p "$(dirname "$3")"
    picture "$out/picture.png"
    # 256 colours are enough for grey metal and rubber of two colours, and make a third of the file.
    ffmpeg -nostdin -loglevel error -y -i "$out/picture.png" \
        -vf 'split[a][b];[a]palettegen=stats_mode=single[p];[b][p]paletteuse=dither=sierra2_4a' -frames:v 1 "$3"
    say "wrote $3"
    exit
fi

for name in rubber grip panel body plates; do render $name; done
say "putting the pictures together"
for name in rubber grip panel; do pair $name 320; done
pair body 360
plates
contact
picture "$out/picture.png"

rm -f "$out/demo.mp4" "$out/rubber.mp4" "$out/grip.mp4"
if command -v ffmpeg >/dev/null; then
    codec=(-c:v mpeg4 -q:v 3)
    if grep -q ' libx264 ' <<<"$(ffmpeg -hide_banner -encoders 2>/dev/null)"; then codec=(-c:v libx264 -preset slow -crf 18); fi
    # There and back, with a rest at both ends.
    film='[0][1]vstack,tpad=start=6:start_mode=clone:stop=9:stop_mode=clone,split[there][again];[again]reverse[back];[there][back]concat'
    ffmpeg -nostdin -loglevel error -y -framerate 12 -i "$out/pair/panel.%04d.png" -framerate 12 -i "$out/pair/body.%04d.png" \
        -filter_complex "$film" "${codec[@]}" -pix_fmt yuv420p -movflags +faststart "$out/demo.mp4"
    for name in rubber grip; do
        ffmpeg -nostdin -loglevel error -y -framerate 12 -i "$out/pair/$name.%04d.png" "${codec[@]}" -pix_fmt yuv420p -movflags +faststart \
            "$out/$name.mp4"
    done
else
    say "no film: ffmpeg is missing"
fi
say "done: $out/contact.png, $out/picture.png, $out/plates.png$([ ! -f "$out/demo.mp4" ] || echo ", $out/demo.mp4, $out/rubber.mp4, $out/grip.mp4")"
